#pragma once
#include "core/ray.h"
#include "exact/surface_id.h"
#include "scene/scene.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// Whether the rays of one call are similar, which decides how they are traversed. If a coherent
/// ray hits two surfaces at the same t, on a common edge, the reported one may depend on the other
/// rays of its packet of sixteen (counted from the front of the call); in incoherent calls it never
/// does.
enum class Coherence { coherent, incoherent };

/// Which surfaces a call takes into account.
enum class Visible {
    all,
    opaque,      ///< alpha mode OPAQUE without transmission: they block light
    translucent  ///< the others
};

/// A hit of the ray with that index in the call.
struct RayHit {
    uint32_t ray;
    Hit hit;
};

/// Closest-hit and any-hit queries for arrays of rays. Const calls are thread-safe.
/// An invalid ray (a NaN or infinity other than in tfar, a zero direction, tnear < 0) hits nothing.
class Intersector {
  public:
    virtual ~Intersector() = default;

    /// The closest hit of each ray; `hits` has the size of `rays` and is overwritten.
    virtual void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                         Visible = Visible::all) const = 0;

    /// Any hit: 1 if anything lies on the ray's segment, else 0.
    virtual void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                          Visible = Visible::all) const = 0;

    /// Appends all hits on each ray's segment, in any order, some perhaps twice; of a shape only
    /// the first. For short segments: nothing ends the search early.
    virtual void all(std::span<const Ray> rays, std::vector<RayHit>& hits,
                     Visible = Visible::all) const = 0;

    /// Appends the ids of all surfaces that come within `radius` of a point, some perhaps twice and
    /// some that do not. False if the engine cannot tell or if there are more than `most`.
    virtual bool nearby(const Vec3& /*centre*/, float /*radius*/, size_t /*most*/,
                        std::vector<SurfaceId>& /*found*/) const {
        return false;
    }

    /// Name and version of the engine and its modes, for statistics.
    virtual std::string description() const = 0;

    /// Bytes held by the acceleration structures.
    virtual size_t memory() const = 0;

    /// Parts of the scene that the engine had to leave out, one line each.
    virtual std::vector<std::string> warnings() const { return {}; }

    /// Whether a surface of the scene is withheld from the search of this ray, because the library
    /// behind the engine must not be asked.
    virtual bool leaves_out(const Ray&, const SurfaceId&) const { return false; }
};

/// True if the material lets light through: alpha MASK or BLEND, or transmission.
bool is_translucent(const Material& material);

}  // namespace sightline
