#pragma once
// Answers that any program has computed for recorded rays, as a file.
#include "intersect/engines.h"
#include "intersect/ray_file.h"

namespace sightline {

/// Reads the answers to `rays` as an engine that repeats them, in the format that docs/engines.md
/// describes; `rays` must outlive nothing, `geometry_hash` is that of `scene`. Throws Error, with
/// the ray, if the file is truncated or of another version, belongs to other rays or another scene,
/// or holds an id that does not exist, a number that is none, or a t outside the ray's segment.
Engine read_answers(const std::string& name, const std::string& path, const Scene& scene,
                    const RayFile& rays);

/// Writes answers, by ray; `occluded` holds those to shadow rays. For tests and examples: a foreign
/// engine writes the format itself. Throws Error.
void write_answers(const std::string& path, std::span<const Hit> hits,
                   std::span<const uint8_t> occluded, const Scene& scene, const RayFile& rays);

}  // namespace sightline
