#pragma once
// Rays from files and from command lines.
#include "render/recorded_ray.h"

#include <string>
#include <vector>

namespace sightline {

/// Reads what write_rays wrote. A ray may hold any bits: what is not valid hits nothing, by
/// definition. Throws Error: no such file, another format or version, a count that is not that of
/// the file's size, an unknown kind.
std::vector<RecordedRay> read_rays(const std::string& path);

/// A ray of eight numbers "ox,oy,oz,dx,dy,dz,tnear,tfar", decimal or hexadecimal, inf and nan
/// included; std::invalid_argument otherwise.
Ray parse_ray(const std::string& text);

/// The ray as parse_ray reads it back, bit by bit, but for a NaN's payload.
std::string ray_literal(const Ray& ray);

}  // namespace sightline
