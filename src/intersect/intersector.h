#pragma once
#include "core/ray.h"
#include "scene/scene.h"

#include <memory>
#include <span>
#include <string>

namespace sightline {

/// How the rays of one call lie to each other: decides how they are traversed. Where an edge gives
/// a coherent ray two surfaces at the same t, it may depend on the other rays of its sixteen
/// (counted from the front of the call) which one is reported; never in incoherent calls.
enum class Coherence { coherent, incoherent };

/// Which surfaces a call may see.
enum class Visible {
    all,
    opaque,      ///< alpha mode OPAQUE without transmission: they stop light
    translucent  ///< the others
};

/// Answers the two questions of ray casting for arrays of rays. Const calls are thread-safe.
/// An invalid ray (a NaN or infinity but in tfar, a zero direction, tnear < 0) hits nothing.
class Intersector {
  public:
    virtual ~Intersector() = default;

    /// Nearest hit of each ray; `hits` has the size of `rays` and is overwritten.
    virtual void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                         Visible = Visible::all) const = 0;

    /// 1 where anything lies on the ray's segment, else 0.
    virtual void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                          Visible = Visible::all) const = 0;

    /// Name and version of the engine and its modes, for statistics.
    virtual std::string description() const = 0;

    /// Bytes held by the acceleration structures.
    virtual size_t memory() const = 0;

    /// What of the scene the engine could not take in, one line each.
    virtual std::vector<std::string> warnings() const { return {}; }
};

enum class BuildQuality { low, medium, high };

/// What Embree is asked for; `needs` chooses it from the scene.
struct EmbreeOptions {
    bool robust = true;
    BuildQuality quality = BuildQuality::medium;
    std::string isa = {};  ///< Embree's name (sse2, sse4.2, avx, avx2, avx512); empty: the best
    unsigned threads = 0;  ///< for the build; 0: all
    bool packets = true;   ///< sixteen rays a call; false: each alone, for comparison
};

/// Builds Embree's structures over the scene, which must outlive the result. Throws Error.
std::unique_ptr<Intersector> make_embree(const Scene& scene, const EmbreeOptions& options = {});

/// True where the material lets light through: alpha MASK or BLEND, transmission.
bool is_translucent(const Material& material);

}  // namespace sightline
