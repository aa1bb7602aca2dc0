#include "shade/prepared_material.h"

#include "shade/bsdf.h"

#include <algorithm>
#include <tuple>

namespace sightline {

bool BoundTexture::shares_lookup(const BoundTexture& other) const {
    const auto modes = [](const Texture& s) {
        return std::tuple(s.wrap_s, s.wrap_t, s.mag, s.min);
    };
    return texcoord == other.texcoord && across == other.across && down == other.down &&
           offset == other.offset && stretch == other.stretch &&
           modes(*sampler) == modes(*other.sampler) && image->is_like(*other.image);
}

Vec4 TextureReader::operator()(const BoundTexture& t) {
    if (t.lookup != known_) {
        Vec2 uv = t.texcoord == 0 ? geometry.uv : geometry.texcoord(t.texcoord);
        if (t.transformed) uv = t.across * uv.x + t.down * uv.y + t.offset;
        const float width =
            footprint_ > 0 ? footprint_ * geometry.uv_per_world(t.texcoord) * t.stretch : 0;
        lookup_ = t.image->locate(*t.sampler, uv, width);
        known_ = t.lookup;
    }
    return t.image->read(lookup_);
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

float Surfaces::Prepared::factor(Slot slot, int channel, float value, TextureReader& read) const {
    const BoundTexture& t = texture(slot);
    return t && value != 0 ? value * read(t)[channel] : value;
}

Vec3 Surfaces::Prepared::color(Slot slot, const Vec3& value, TextureReader& read) const {
    const BoundTexture& t = texture(slot);
    if (!t) return value;
    const Vec4 texel = read(t);
    return value * Vec3(texel.x, texel.y, texel.z);
}

void Surfaces::Prepared::bind(Slot slot, BoundTexture bound) {
    const auto like = std::ranges::find_if(
        textures, [&](const BoundTexture& other) { return other && bound.shares_lookup(other); });
    bound.lookup = like == textures.end() ? static_cast<uint32_t>(slot) : like->lookup;
    textures[static_cast<size_t>(slot)] = bound;
}

Vec4 Surfaces::Prepared::base_color(TextureReader& read) const {
    Vec4 value = material->base_color_factor;
    if (const BoundTexture& t = texture(Slot::base_color)) value *= read(t);
    if (read.geometry.mesh && !read.geometry.mesh->colors.empty()) value *= read.geometry.color();
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

float Surfaces::Prepared::metallic(TextureReader& read) const {
    return factor(Slot::metallic_roughness, 2, material->metallic_factor, read);
}

float Surfaces::Prepared::transmission(TextureReader& read) const {
    return factor(Slot::transmission, 0, material->transmission_factor, read);
}

Vec3 Surfaces::Prepared::emission(TextureReader& read) const {
    const Vec3& value = material->emissive_factor;
    return max_component(value) > 0 ? color(Slot::emissive, value, read) : value;
}

void Surfaces::Prepared::shade(TextureReader& read, Surface& s) const {
    s.features = features;
    const Vec4 base = base_color(read);
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
        const Vec4 texel = read(t);
        s.roughness *= texel.y;
        s.metallic *= texel.z;
    }
    s.emission = emission(read);
    s.ior = material->ior;
    s.eta = s.has(feature_volume) && !s.front ? 1 / s.ior : s.ior;
    if (features) shade_extensions(read, s);
}

void Surfaces::Prepared::shade_extensions(TextureReader& read, Surface& s) const {
    const Material& m = *material;
    if (s.has(feature_specular)) {
        s.specular = factor(Slot::specular, 3, m.specular_factor, read);
        s.specular_color = color(Slot::specular_color, m.specular_color_factor, read);
    }
    if (s.has(feature_transmission)) s.transmission = transmission(read);
    if (s.has(feature_clearcoat)) {
        s.clearcoat = factor(Slot::clearcoat, 0, m.clearcoat_factor, read);
        s.clearcoat_roughness =
            factor(Slot::clearcoat_roughness, 1, m.clearcoat_roughness_factor, read);
    }
    if (s.has(feature_sheen)) {
        s.sheen_color = color(Slot::sheen_color, m.sheen_color_factor, read);
        s.sheen_roughness = factor(Slot::sheen_roughness, 3, m.sheen_roughness_factor, read);
    }
    if (s.has(feature_iridescence)) {
        s.iridescence = factor(Slot::iridescence, 0, m.iridescence_factor, read);
        s.iridescence_ior = m.iridescence_ior;
        s.iridescence_thickness = m.iridescence_thickness_maximum;
        if (const BoundTexture& t = texture(Slot::iridescence_thickness)) {
            const float low = m.iridescence_thickness_minimum;
            s.iridescence_thickness = low + (s.iridescence_thickness - low) * read(t).y;
        }
    }
    if (s.has(feature_diffuse_transmission)) {
        s.diffuse_transmission =
            factor(Slot::diffuse_transmission, 3, m.diffuse_transmission_factor, read);
        s.diffuse_transmission_color =
            color(Slot::diffuse_transmission_color, m.diffuse_transmission_color_factor, read);
    }
}

}  // namespace sightline
