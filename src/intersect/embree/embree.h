#pragma once
#include "intersect/intersector.h"

namespace sightline {

enum class BuildQuality { low, medium, high };

/// How Embree builds and is called; `Needs` chooses mode and quality from the scene.
struct EmbreeOptions {
    bool robust = true;
    BuildQuality quality = BuildQuality::medium;
    std::string isa = {};  ///< Embree's name (sse2, sse4.2, avx, avx2, avx512); empty: the best
    unsigned threads = 0;  ///< for the build; 0: all
    bool packets = true;   ///< sixteen rays per call; false: one, for comparison

    bool operator==(const EmbreeOptions&) const = default;
};

/// The instruction set that Embree uses if this one is requested; empty: the best of the processor.
/// Throws Error if the processor lacks it.
std::string embree_isa(const std::string& requested);

/// Builds Embree's structures over the scene, which must outlive the result. Throws Error.
std::unique_ptr<Intersector> make_embree(const Scene& scene, const EmbreeOptions& options = {});

}  // namespace sightline
