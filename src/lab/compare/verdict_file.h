#pragma once
#include "lab/compare/compare.h"

namespace sightline {

/// Writes the verdict on each engine's answer to each ray, in the format of docs/engines.md; the
/// hashes are those of the geometry and of the rays. Throws Error.
void write_verdicts(const std::string& path, const Comparison& comparison, uint64_t geometry_hash,
                    uint64_t rays_hash);

}  // namespace sightline
