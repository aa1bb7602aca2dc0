#include "intersect/exact/exact_intersector.h"

#include "exact/arithmetic.h"
#include "intersect/exact/hit_query.h"
#include "intersect/ray_rules.h"

namespace sightline {
namespace {

/// A valid ray on its way through the BVHs.
template <class Query>
struct InFlight {
    InFlight(const TwoLevelBvh& bvh, const Ray& from, Visible visible, size_t i)
        : query(bvh, from, visible), limits(query.initial_limits()), index(i) {}

    Query query;
    TraversalLimits limits;
    std::optional<TraversalRay> ray;  ///< none: the BVHs need not be searched
    size_t index;                     ///< of the ray within the call
};

class ExactIntersector : public Intersector {
  public:
    explicit ExactIntersector(const Scene& scene)
        : bvh_(scene), exceeds_caches_(bvh_.memory() > interleaved_from) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence,
                 Visible visible) const override {
        assert(rays.size() == hits.size());
        std::fill(hits.begin(), hits.end(), Hit());
        search<ClosestHitQuery>(
            rays, visible, coherence,
            [&](size_t i, const ClosestHitQuery& query) { hits[i] = query.hit(); });
    }

    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence coherence,
                  Visible visible) const override {
        assert(rays.size() == blocked.size());
        std::fill(blocked.begin(), blocked.end(), uint8_t{0});
        search<AnyHitQuery>(rays, visible, coherence, [&](size_t i, const AnyHitQuery& query) {
            blocked[i] = query.occluded();
        });
    }

    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible visible) const override {
        search<AllHitsQuery>(rays, visible, Coherence::incoherent,
                             [&](size_t i, const AllHitsQuery& query) {
                                 for (const Hit& hit : query.hits())
                                     hits.push_back({static_cast<uint32_t>(i), hit});
                             });
    }

    std::string description() const override {
        return std::string("Sightline's exact tree, ") + vector_target();
    }

    size_t memory() const override { return bvh_.memory(); }

  private:
    /// Rays are traced in groups of this size, so that their queries stay in the first-level cache.
    static constexpr size_t group_size = 64;

    /// Calls done(i, query) for each valid ray.
    template <class Query, class Done>
    void search(std::span<const Ray> rays, Visible visible, Coherence coherence,
                const Done& done) const {
        std::vector<InFlight<Query>> in_flight;
        std::vector<TraversalJob> jobs;
        in_flight.reserve(group_size);
        jobs.reserve(group_size);
        for (size_t begin = 0; begin < rays.size(); begin += group_size) {
            in_flight.clear();
            jobs.clear();
            for (size_t i = begin; i < std::min(begin + group_size, rays.size()); ++i)
                if (is_valid(rays[i]))
                    start(in_flight.emplace_back(bvh_, rays[i], visible, i), jobs);
            traverse_baked(jobs, coherence);
            auto job = jobs.begin();
            for (InFlight<Query>& flight : in_flight)
                if (flight.ray) flight.query.finish(flight.limits, (job++)->stopped);
            if constexpr (std::is_same_v<Query, ClosestHitQuery>) {
                for (const auto& flight : in_flight) flight.query.prefetch_triangle();
                for (const auto& flight : in_flight) flight.query.prefetch_vertices();
            }
            for (const auto& flight : in_flight) done(flight.index, flight.query);
        }
    }

    template <class Query>
    void start(InFlight<Query>& flight, std::vector<TraversalJob>& jobs) const {
        if (flight.query.begin(flight.limits)) return;
        const TriangleBvh& baked = bvh_.baked.triangles;
        flight.ray.emplace(flight.query.world_ray(), baked.bvh, baked.max_edge);
        jobs.push_back({&*flight.ray, &flight.limits, &flight.query});
    }

    void traverse_baked(std::span<TraversalJob> jobs, Coherence coherence) const {
        if (exceeds_caches_ && coherence == Coherence::incoherent)
            traverse_interleaved(bvh_.baked.triangles, jobs);
        else
            traverse_each(bvh_.baked.triangles, jobs);
    }

    /// Bytes. Incoherent rays are interleaved in BVHs that do not fit into the caches; others gain
    /// nothing by it.
    static constexpr size_t interleaved_from = size_t{256} << 20;

    TwoLevelBvh bvh_;
    bool exceeds_caches_;
};

}  // namespace

std::unique_ptr<Intersector> make_exact_intersector(const Scene& scene) {
    check_arithmetic();
    return std::make_unique<ExactIntersector>(scene);
}

}  // namespace sightline
