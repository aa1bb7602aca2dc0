#pragma once
// The interiors of volumes (KHR_materials_volume): which of them a ray is in, what they absorb.
#include "scene/scene.h"
#include "shade/surface.h"

#include <array>

namespace sightline {

/// The volumes that contain a ray's origin, by material index, innermost last. Holds four; a deeper
/// one is ignored.
struct MediumStack {
    std::array<uint16_t, 4> material{};
    uint16_t count = 0;

    void enter(uint32_t m);
    /// Removes the innermost entry of material `m`, if there is one.
    void leave(uint32_t m);
    /// The innermost medium, or `none` in air.
    uint32_t current() const { return count ? material[count - 1] : none; }
};

/// The volumes beyond the boundary of one, from those on the side of its wo.
MediumStack beyond(const Surface& boundary, MediumStack media);

/// Refractive indices of the material's interior for red, green and blue: the lines C, d and F of
/// KHR_materials_dispersion ("Implementation"). Equal without dispersion.
Vec3 channel_iors(const Material& material);

/// True where the interior of the material absorbs light.
bool absorbs(const Material& material);

/// Absorption coefficient of each material's interior, per world unit:
/// −ln(attenuation colour) / attenuation distance, or 0 where it does not absorb.
std::vector<Vec3> absorption_coefficients(const Scene& scene);

/// Transmittance of `distance` world units of an absorbing medium (the Beer–Lambert law).
inline Vec3 attenuate(const Vec3& absorption, float distance) {
    return {std::exp(-absorption.x * distance), std::exp(-absorption.y * distance),
            std::exp(-absorption.z * distance)};
}

}  // namespace sightline
