#pragma once
// Recorded rays: files of them, and single rays as text.
#include "exact/surface_id.h"
#include "scene/scene.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sightline {

enum class RayKind : uint32_t { camera, shadow, reflection, refraction };
inline constexpr size_t ray_kinds = 4;
inline constexpr const char* ray_kind_names[] = {"camera", "shadow", "reflection", "refraction"};

/// A ray as a render traced it, for replay.
struct RecordedRay {
    Ray ray;
    RayKind kind;
    int x = -1, y = -1;     ///< the pixel that it was traced for; negative: unknown
    SurfaceId source = {};  ///< the surface that it leaves; `none`: it leaves none, or unknown
};

/// Rays and the scene that they were recorded in.
struct RayFile {
    std::vector<RecordedRay> rays;
    std::optional<uint64_t> geometry_hash;  ///< hash_geometry; none in files of version 1
    uint64_t hash = 0;                      ///< of the rays, by which answers refer to them
    Frame frame;                            ///< of the rays' coordinates; the identity in version 1
};

/// The hash by which answers and verdicts refer to rays.
uint64_t hash_rays(std::span<const RecordedRay> rays);

/// Writes rays of a scene, without their pixels, in the format that docs/engines.md describes.
/// Throws Error.
void write_rays(const std::string& path, std::span<const RecordedRay> rays, const Scene& scene);

/// Reads a file of write_rays, of this version or of version 1. Rays may hold any bits; an invalid
/// ray hits nothing by definition. Throws Error if the file is missing or truncated, has another
/// format or version, or holds an unknown kind.
RayFile read_rays(const std::string& path);

/// A ray of eight numbers "ox,oy,oz,dx,dy,dz,tnear,tfar", decimal or hexadecimal, inf and nan
/// included; then optionally its kind by name, and after that the instance, geometry and primitive
/// that it leaves. Throws std::invalid_argument on any other text.
RecordedRay parse_ray(const std::string& text);

/// The ray as text that parse_ray converts back to the same bits, but for a NaN's payload.
std::string ray_literal(const Ray& ray);
std::string ray_literal(const RecordedRay& ray);

}  // namespace sightline
