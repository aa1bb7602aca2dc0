#include "intersect/exact/exact_intersector.h"

#include "exact/arithmetic.h"
#include "intersect/exact/scene_query.h"
#include "intersect/methods/method_intersector.h"
#include "intersect/methods/triangle_methods.h"
#include "intersect/ray_rules.h"

namespace sightline {
namespace {

/// The tree whose decisions are exact.
class ExactIntersector : public Intersector {
  public:
    explicit ExactIntersector(const Scene& scene)
        : placed_(scene), exceeds_caches_(placed_.memory() > waves_from) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence,
                 Visible visible) const override {
        assert(rays.size() == hits.size());
        std::fill(hits.begin(), hits.end(), Hit());
        search<NearestJudge>(rays, visible, coherence,
                             [&](size_t i, const NearestJudge& judge) { hits[i] = judge.hit(); });
    }

    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence coherence,
                  Visible visible) const override {
        assert(rays.size() == blocked.size());
        std::fill(blocked.begin(), blocked.end(), uint8_t{0});
        search<AnyJudge>(rays, visible, coherence,
                         [&](size_t i, const AnyJudge& judge) { blocked[i] = judge.blocked(); });
    }

    std::string description() const override {
        return std::string("Sightline's exact tree, ") + vector_target();
    }

    size_t memory() const override { return placed_.memory(); }

  private:
    /// Rays are traced in groups of this size: their judges should stay in the first cache.
    static constexpr size_t group = 64;

    /// Calls done(i, judge) for each valid ray.
    template <class Judge, class Done>
    void search(std::span<const Ray> rays, Visible visible, Coherence coherence,
                const Done& done) const {
        const bool in_waves = exceeds_caches_ && coherence == Coherence::incoherent;
        const TriangleTree& tree = placed_.baked.tree;
        std::vector<Judge> judges;
        std::vector<TreeRay> tree_rays;
        std::vector<Wanderer> wanderers;
        std::vector<size_t> places;
        judges.reserve(group);
        tree_rays.reserve(group);
        for (size_t begin = 0; begin < rays.size(); begin += group) {
            judges.clear();
            tree_rays.clear();
            wanderers.clear();
            places.clear();
            for (size_t i = begin; i < std::min(begin + group, rays.size()); ++i) {
                if (!is_valid(rays[i])) continue;
                Judge& judge = judges.emplace_back(placed_, rays[i], visible);
                places.push_back(i);
                if (judge.begin()) continue;
                tree_rays.emplace_back(judge.world_ray(), tree.boxes, tree.largest_edge);
                wanderers.push_back({&tree_rays.back(), &judge});
            }
            if (in_waves)
                traverse_wave(tree, wanderers);
            else
                traverse_each(tree, wanderers);
            for (const Wanderer& wanderer : wanderers)
                if (!wanderer.stopped) static_cast<Judge*>(wanderer.judge)->search_objects();
            for (const Judge& judge : judges) judge.prefetch_triangle();
            for (const Judge& judge : judges) judge.prefetch_corners();
            for (size_t i = 0; i < judges.size(); ++i) done(places[i], judges[i]);
        }
    }

    /// Incoherent rays through trees that do not fit into the caches take turns; others gain
    /// nothing by it.
    static constexpr size_t waves_from = size_t{256} << 20;

    PlacedScene placed_;
    bool exceeds_caches_;
};

}  // namespace

std::unique_ptr<Intersector> make_reference(const Scene& scene, std::string_view method) {
    check_arithmetic();
    if (method == "exact") return std::make_unique<ExactIntersector>(scene);
    return make_method_tree(scene, method);
}

bool is_reference_method(std::string_view method) {
    if (method == "exact") return true;
    for (const std::string_view structure : {":bounds", ":loop"})
        if (method.ends_with(structure)) {
            method.remove_suffix(structure.size());
            break;
        }
    return std::ranges::count(triangle_methods(), method, &TriangleMethod::name) > 0;
}

}  // namespace sightline
