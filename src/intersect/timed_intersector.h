#pragma once
#include "intersect/intersector.h"

#include <atomic>

namespace sightline {

/// Another engine, which must outlive it, with a clock: one look at it before and after each call.
class TimedIntersector : public Intersector {
  public:
    explicit TimedIntersector(const Intersector& engine) : engine_(engine) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence,
                 Visible visible) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence coherence,
                  Visible visible) const override;
    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible visible) const override;
    bool nearby(const Vec3& centre, float radius, size_t most,
                std::vector<SurfaceId>& found) const override {
        return engine_.nearby(centre, radius, most, found);
    }
    std::string description() const override { return engine_.description(); }
    size_t memory() const override { return engine_.memory(); }
    std::vector<std::string> warnings() const override { return engine_.warnings(); }
    bool leaves_out(const Ray& ray, const SurfaceId& surface) const override {
        return engine_.leaves_out(ray, surface);
    }

    /// Sum over all threads of the time that calls took so far.
    double thread_seconds() const { return static_cast<double>(nanoseconds_) * 1e-9; }

  private:
    void measure(const auto& call) const;

    const Intersector& engine_;
    mutable std::atomic<int64_t> nanoseconds_ = 0;
};

}  // namespace sightline
