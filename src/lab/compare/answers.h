#pragma once
// Answers that any program has computed for recorded rays, as a file.
#include "intersect/engines.h"
#include "intersect/ray_file.h"

namespace sightline {

/// Reads the answers to `rays` in the format that docs/engines.md describes, as an engine that
/// returns them. Throws Error if the file is truncated or of another version, or belongs to other
/// rays or another scene; with the index of the ray if an id does not exist, t, u or v is not
/// finite, or t lies outside the ray's segment.
Engine read_answers(const std::string& name, const std::string& path, const Scene& scene,
                    const RayFile& rays);

/// Writes answers, by ray; `occluded` holds those to shadow rays. The tests use it: another program
/// writes the format itself. Throws Error.
void write_answers(const std::string& path, std::span<const Hit> hits,
                   std::span<const uint8_t> occluded, const Scene& scene, const RayFile& rays);

}  // namespace sightline
