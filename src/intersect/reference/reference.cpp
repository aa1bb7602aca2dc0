#include "intersect/reference/reference.h"

#include "exact/arithmetic.h"
#include "intersect/ray_rules.h"
#include "intersect/reference/judges.h"
#include "intersect/reference/method_tree.h"

namespace sightline {
namespace {

/// The tree whose decisions are exact.
class ExactIntersector : public Intersector {
  public:
    explicit ExactIntersector(const Scene& scene) : placed_(scene) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible visible) const override {
        assert(rays.size() == hits.size());
        for (size_t i = 0; i < rays.size(); ++i) {
            hits[i] = {};
            if (!is_valid(rays[i])) continue;
            NearestJudge judge(placed_, rays[i], visible);
            judge.search();
            hits[i] = judge.hit();
        }
    }

    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                  Visible visible) const override {
        assert(rays.size() == blocked.size());
        for (size_t i = 0; i < rays.size(); ++i) {
            blocked[i] = 0;
            if (!is_valid(rays[i])) continue;
            AnyJudge judge(placed_, rays[i], visible);
            judge.search();
            blocked[i] = judge.blocked();
        }
    }

    std::string description() const override {
        return std::string("Sightline's exact tree, ") + vector_target();
    }

    size_t memory() const override { return placed_.memory(); }

  private:
    PlacedScene placed_;
};

}  // namespace

std::unique_ptr<Intersector> make_reference(const Scene& scene, std::string_view method) {
    check_arithmetic();
    if (method == "exact") return std::make_unique<ExactIntersector>(scene);
    return make_method_tree(scene, method);
}

}  // namespace sightline
