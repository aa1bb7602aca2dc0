#pragma once
namespace sightline {

/// The Charlie sheen lobe (Estevez and Kulla 2017) with the visibility of Ashikhmin and Neubelt,
/// without colour and times nothing: D·V. `roughness` is perceptual.
float sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness);

/// What a white sheen reflects in all of a uniform surround, at most 1.
float sheen_albedo(float cos_o, float roughness);

}  // namespace sightline
