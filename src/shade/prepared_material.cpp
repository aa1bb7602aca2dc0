#include "shade/prepared_material.h"

#include "shade/bsdf.h"

#include <algorithm>

namespace sightline {

Vec4 BoundTexture::sample(const HitGeometry& g, float footprint) const {
    Vec2 uv = texcoord == 0 ? g.uv : g.texcoord(texcoord);
    if (transformed) uv = across * uv.x + down * uv.y + offset;
    const float width = footprint > 0 ? footprint * g.uv_per_world(texcoord) * stretch : 0;
    return image->sample(*sampler, uv, width);
}

std::array<SlotUse, static_cast<size_t>(Slot::count)> texture_uses(const Material& m) {
    return {{
        {Slot::base_color, &m.base_color_texture, true},
        {Slot::metallic_roughness, &m.metallic_roughness_texture, false},
        {Slot::normal, &m.normal_texture, false},
        {Slot::emissive, &m.emissive_texture, true},
        {Slot::transmission, &m.transmission_texture, false},
        {Slot::specular, &m.specular_texture, false},
        {Slot::specular_color, &m.specular_color_texture, true},
        {Slot::clearcoat, &m.clearcoat_texture, false},
        {Slot::clearcoat_roughness, &m.clearcoat_roughness_texture, false},
        {Slot::clearcoat_normal, &m.clearcoat_normal_texture, false},
        {Slot::sheen_color, &m.sheen_color_texture, true},
        {Slot::sheen_roughness, &m.sheen_roughness_texture, false},
        {Slot::anisotropy, &m.anisotropy_texture, false},
        {Slot::iridescence, &m.iridescence_texture, false},
        {Slot::iridescence_thickness, &m.iridescence_thickness_texture, false},
        {Slot::diffuse_transmission, &m.diffuse_transmission_texture, false},
        {Slot::diffuse_transmission_color, &m.diffuse_transmission_color_texture, true},
    }};
}

uint32_t material_features(const Material& m) {
    if (m.unlit) return feature_unlit;
    uint32_t features = 0;
    const auto add = [&](bool used, MaterialFeature feature) {
        if (used) features |= feature;
    };
    add(m.specular_factor != 1 || m.specular_texture || m.specular_color_factor != Vec3(1) ||
            m.specular_color_texture,
        feature_specular);
    add(m.transmission_factor > 0, feature_transmission);
    add(m.transmission_factor > 0 && m.thickness_factor > 0, feature_volume);
    add(m.clearcoat_factor > 0, feature_clearcoat);
    add(max_component(m.sheen_color_factor) > 0, feature_sheen);
    add(m.anisotropy_strength > 0, feature_anisotropy);
    add(m.iridescence_factor > 0, feature_iridescence);
    add(m.diffuse_transmission_factor > 0, feature_diffuse_transmission);
    return features;
}

float Surfaces::Prepared::factor(Slot slot, int channel, float value, const HitGeometry& g,
                                 float footprint) const {
    const BoundTexture& t = texture(slot);
    return t && value != 0 ? value * t.sample(g, footprint)[channel] : value;
}

Vec3 Surfaces::Prepared::color(Slot slot, const Vec3& value, const HitGeometry& g,
                               float footprint) const {
    const BoundTexture& t = texture(slot);
    if (!t) return value;
    const Vec4 texel = t.sample(g, footprint);
    return value * Vec3(texel.x, texel.y, texel.z);
}

Vec4 Surfaces::Prepared::base_color(const HitGeometry& g, float footprint) const {
    Vec4 value = material->base_color_factor;
    if (const BoundTexture& t = texture(Slot::base_color)) value *= t.sample(g, footprint);
    if (g.mesh && !g.mesh->colors.empty()) value *= g.color();
    return value;
}

float Surfaces::Prepared::coverage(float alpha) const {
    switch (material->alpha_mode) {
        case AlphaMode::opaque:
            return 1;
        case AlphaMode::mask:
            return alpha < material->alpha_cutoff ? 0.0f : 1.0f;
        case AlphaMode::blend:
            break;
    }
    return std::clamp(alpha, 0.0f, 1.0f);
}

float Surfaces::Prepared::metallic(const HitGeometry& g, float footprint) const {
    return factor(Slot::metallic_roughness, 2, material->metallic_factor, g, footprint);
}

float Surfaces::Prepared::transmission(const HitGeometry& g, float footprint) const {
    return factor(Slot::transmission, 0, material->transmission_factor, g, footprint);
}

Vec3 Surfaces::Prepared::emission(const HitGeometry& g, float footprint) const {
    const Vec3& value = material->emissive_factor;
    return max_component(value) > 0 ? color(Slot::emissive, value, g, footprint) : value;
}

void Surfaces::Prepared::shade(const HitGeometry& g, float footprint, Surface& s) const {
    s.features = features;
    const Vec4 base = base_color(g, footprint);
    s.base_color = {base.x, base.y, base.z};
    s.alpha = culls_back && !s.front ? 0 : coverage(base.w);
    if (s.alpha == 0) return;
    if (features & feature_unlit) {
        s.emission = s.base_color;
        return;
    }
    s.metallic = material->metallic_factor;
    s.roughness = material->roughness_factor;
    if (const BoundTexture& t = texture(Slot::metallic_roughness)) {
        const Vec4 texel = t.sample(g, footprint);
        s.roughness *= texel.y;
        s.metallic *= texel.z;
    }
    s.emission = emission(g, footprint);
    s.ior = material->ior;
    s.eta = s.has(feature_volume) && !s.front ? 1 / s.ior : s.ior;
    if (features) shade_extensions(g, footprint, s);
}

void Surfaces::Prepared::shade_extensions(const HitGeometry& g, float footprint, Surface& s) const {
    const Material& m = *material;
    if (s.has(feature_specular)) {
        s.specular = factor(Slot::specular, 3, m.specular_factor, g, footprint);
        s.specular_color = color(Slot::specular_color, m.specular_color_factor, g, footprint);
    }
    if (s.has(feature_transmission)) s.transmission = transmission(g, footprint);
    if (s.has(feature_clearcoat)) {
        s.clearcoat = factor(Slot::clearcoat, 0, m.clearcoat_factor, g, footprint);
        s.clearcoat_roughness =
            factor(Slot::clearcoat_roughness, 1, m.clearcoat_roughness_factor, g, footprint);
    }
    if (s.has(feature_sheen)) {
        s.sheen_color = color(Slot::sheen_color, m.sheen_color_factor, g, footprint);
        s.sheen_roughness =
            factor(Slot::sheen_roughness, 3, m.sheen_roughness_factor, g, footprint);
    }
    if (s.has(feature_iridescence)) {
        s.iridescence = factor(Slot::iridescence, 0, m.iridescence_factor, g, footprint);
        s.iridescence_ior = m.iridescence_ior;
        s.iridescence_thickness = m.iridescence_thickness_maximum;
        if (const BoundTexture& t = texture(Slot::iridescence_thickness)) {
            const float low = m.iridescence_thickness_minimum;
            s.iridescence_thickness =
                low + (s.iridescence_thickness - low) * t.sample(g, footprint).y;
        }
    }
    if (s.has(feature_diffuse_transmission)) {
        s.diffuse_transmission =
            factor(Slot::diffuse_transmission, 3, m.diffuse_transmission_factor, g, footprint);
        s.diffuse_transmission_color = color(Slot::diffuse_transmission_color,
                                             m.diffuse_transmission_color_factor, g, footprint);
    }
}

}  // namespace sightline
