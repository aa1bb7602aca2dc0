#pragma once
namespace sightline {

/// D·V of the Charlie sheen lobe (Estevez and Kulla 2017, "Production Friendly Microfacet Sheen
/// BRDF") with the visibility of Ashikhmin and Neubelt, without colour and cosine. `roughness` is
/// perceptual.
float sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness);

/// Directional albedo of a white sheen, at most 1.
float sheen_albedo(float cos_o, float roughness);

}  // namespace sightline
