#pragma once
namespace sightline {

/// D·V of the Charlie sheen lobe with its own shadowing term (Estevez and Kulla 2017, "Production
/// Friendly Microfacet Sheen BRDF"; KHR_materials_sheen), without colour and cosine. `roughness` is
/// perceptual. Its albedo exceeds 1 for grazing views of low roughness.
float sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness);

}  // namespace sightline
