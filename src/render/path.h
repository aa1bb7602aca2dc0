#pragma once
// The rays of one depth, and what each carries from the camera.
#include "core/ray.h"
#include "intersect/ray_file.h"
#include "shade/media.h"

#include <vector>

namespace sightline {

inline constexpr uint8_t all_channels = 3;

/// The path from the camera to the origin of a ray.
struct Path {
    uint32_t slot;    ///< of its camera sample
    uint32_t stream;  ///< seed of this branch's random numbers
    Vec3 throughput;
    /// Pdf per solid angle with which the last scattering vertex picked the ray's direction, or 0
    /// if that was its only one; length of the path from there to the ray's origin.
    float pdf, straight_length;
    float cone_width, cone_spread;  ///< the ray cone at the origin; growth per unit of distance
    uint16_t depth, layers;
    bool from_camera;    ///< no reflection or refraction since: through transparent layers only
    bool sees_backdrop;  ///< only smooth refraction and transparent layers since the camera
    bool mirrored;       ///< by the ground, and has met nothing that covers since
    RayKind kind;
    uint8_t channel;   ///< the only one of throughput that is not 0, or all_channels
    SurfaceId source;  ///< the surface that the ray leaves
    MediumStack media;
};

/// Rays that are traced together.
struct Wave {
    std::vector<Ray> rays;
    std::vector<Path> paths;  ///< by ray, as are the hits
    std::vector<Hit> hits;
    std::vector<uint32_t> hit_indices, miss_indices;  ///< of the rays
    /// Distance by ray at which it passes the ground before it hits anything, else infinity. Empty
    /// without a ground. A ray that passes the ground is a miss.
    std::vector<float> ground;

    void clear() { rays.clear(), paths.clear(); }
    void add(const Ray& ray, const Path& path) { rays.push_back(ray), paths.push_back(path); }
    void erase(size_t i) {
        rays.erase(rays.begin() + static_cast<ptrdiff_t>(i));
        paths.erase(paths.begin() + static_cast<ptrdiff_t>(i));
    }
};

}  // namespace sightline
