#include "intersect/timed_intersector.h"

#include <chrono>

namespace sightline {

void TimedIntersector::measure(const auto& call) const {
    const auto begin = std::chrono::steady_clock::now();
    call();
    const std::chrono::nanoseconds time = std::chrono::steady_clock::now() - begin;
    nanoseconds_.fetch_add(time.count(), std::memory_order_relaxed);
}

void TimedIntersector::closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence,
                               Visible visible) const {
    measure([&] { engine_.closest(rays, hits, coherence, visible); });
}

void TimedIntersector::occluded(std::span<const Ray> rays, std::span<uint8_t> blocked,
                                Coherence coherence, Visible visible) const {
    measure([&] { engine_.occluded(rays, blocked, coherence, visible); });
}

void TimedIntersector::all(std::span<const Ray> rays, std::vector<RayHit>& hits,
                           Visible visible) const {
    measure([&] { engine_.all(rays, hits, visible); });
}

}  // namespace sightline
