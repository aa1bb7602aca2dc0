#pragma once

namespace sightline {

/// What light between microfacets adds to a GGX lobe of unit Fresnel, relative to the single
/// reflections that the lobe holds: (1 − E)/E for its directional albedo E at `cos_o` and
/// perceptual `roughness` (Turquin 2019, "Practical multiple scattering compensation for microfacet
/// models"). A metal's lobe times 1 + F0 · this keeps the energy of a white one.
float missing_energy(float cos_o, float roughness);

}  // namespace sightline
