#include "shade/compiled_material.h"

#include "shade/bsdf.h"

#include <algorithm>
#include <tuple>

namespace sightline {

bool BoundTexture::shares_lookup(const BoundTexture& other) const {
    const auto modes = [](const Texture& s) {
        return std::tuple(s.wrap_s, s.wrap_t, s.mag, s.min);
    };
    return texcoord == other.texcoord && across == other.across && down == other.down &&
           offset == other.offset && modes(*sampler) == modes(*other.sampler) &&
           image->has_size_of(*other.image);
}

// A point that lies x off the cone's axis d projects along d onto the plane with the normal n at
// x − d (x·n) / (d·n), where the coordinates differ by g·x − (g·d) (x·n) / (d·n) for a gradient g
// in the plane: their gradient across the cone is g − n (g·d) / (d·n).
TextureFootprint TextureReader::footprint(const BoundTexture& t) {
    if (!(width_ > 0)) return {least2_, 0, least2_};
    if (t.texcoord != set_) {
        set_ = t.texcoord;
        const Vec3& n = geometry.outward;
        const float cosine = dot(n, direction_);
        const float per_cosine = 1 / std::copysign(std::max(std::fabs(cosine), 1e-3f), cosine);
        const auto [u, v] = geometry.uv_gradients(t.texcoord);
        across_ = {(u - n * (dot(u, direction_) * per_cosine)) * width_,
                   (v - n * (dot(v, direction_) * per_cosine)) * width_};
    }
    UvGradients g = across_;
    if (t.transformed) g = {g.u * t.across.x + g.v * t.down.x, g.u * t.across.y + g.v * t.down.y};
    return {dot(g.u, g.u) + least2_, dot(g.u, g.v), dot(g.v, g.v) + least2_};
}

Vec4 TextureReader::operator()(const BoundTexture& t) {
    if (t.lookup != lookup_id_) {
        Vec2 uv = t.texcoord == 0 ? geometry.uv : geometry.texcoord(t.texcoord);
        if (t.transformed) uv = t.across * uv.x + t.down * uv.y + t.offset;
        t.image->locate(*t.sampler, uv, footprint(t), lookup_);
        lookup_id_ = t.lookup;
    }
    return t.image->read(lookup_);
}

std::array<SlotTexture, static_cast<size_t>(TextureSlot::count)> slot_textures(const Material& m) {
    return {{
        {TextureSlot::base_color, &m.base_color_texture, true},
        {TextureSlot::metallic_roughness, &m.metallic_roughness_texture, false},
        {TextureSlot::normal, &m.normal_texture, false},
        {TextureSlot::emissive, &m.emissive_texture, true},
        {TextureSlot::transmission, &m.transmission_texture, false},
        {TextureSlot::specular, &m.specular_texture, false},
        {TextureSlot::specular_color, &m.specular_color_texture, true},
        // Only its alpha is read; as a texture of colours it is the image of specular_color.
        {TextureSlot::glossiness, &m.glossiness_texture, true},
        {TextureSlot::clearcoat, &m.clearcoat_texture, false},
        {TextureSlot::clearcoat_roughness, &m.clearcoat_roughness_texture, false},
        {TextureSlot::clearcoat_normal, &m.clearcoat_normal_texture, false},
        {TextureSlot::sheen_color, &m.sheen_color_texture, true},
        {TextureSlot::sheen_roughness, &m.sheen_roughness_texture, false},
        {TextureSlot::anisotropy, &m.anisotropy_texture, false},
        {TextureSlot::iridescence, &m.iridescence_texture, false},
        {TextureSlot::iridescence_thickness, &m.iridescence_thickness_texture, false},
        {TextureSlot::diffuse_transmission, &m.diffuse_transmission_texture, false},
        {TextureSlot::diffuse_transmission_color, &m.diffuse_transmission_color_texture, true},
    }};
}

uint32_t material_features(const Material& m) {
    if (m.unlit) return feature_unlit;
    uint32_t features = 0;
    const auto add = [&](bool used, MaterialFeature feature) {
        if (used) features |= feature;
    };
    add(m.specular_factor != 1 || m.specular_texture || m.specular_color_factor != Vec3(1) ||
            m.specular_color_texture || m.glossiness_texture,
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

float CompiledMaterial::factor(TextureSlot slot, int channel, float value,
                               TextureReader& read) const {
    const BoundTexture& t = texture(slot);
    return t && value != 0 ? value * read(t)[channel] : value;
}

Vec3 CompiledMaterial::color(TextureSlot slot, const Vec3& value, TextureReader& read) const {
    const BoundTexture& t = texture(slot);
    if (!t) return value;
    const Vec4 texel = read(t);
    return value * Vec3(texel.x, texel.y, texel.z);
}

void CompiledMaterial::bind(TextureSlot slot, BoundTexture bound) {
    const auto like = std::ranges::find_if(
        textures, [&](const BoundTexture& other) { return other && bound.shares_lookup(other); });
    bound.lookup = like == textures.end() ? static_cast<uint32_t>(slot) : like->lookup;
    textures[static_cast<size_t>(slot)] = bound;
}

Vec4 CompiledMaterial::base_color(TextureReader& read) const {
    Vec4 value = material->base_color_factor;
    if (const BoundTexture& t = texture(TextureSlot::base_color)) value *= read(t);
    if (read.geometry.mesh && !read.geometry.mesh->colors.empty()) value *= read.geometry.color();
    return value;
}

float CompiledMaterial::coverage(float alpha) const {
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

Vec3 CompiledMaterial::emission(TextureReader& read) const {
    const Vec3& value = material->emissive_factor;
    return max_component(value) > 0 ? color(TextureSlot::emissive, value, read) : value;
}

void CompiledMaterial::shade(TextureReader& read, Surface& s, Faces faces) const {
    s.features = features;
    const Vec4 base = base_color(read);
    s.base_color = {base.x, base.y, base.z};
    const bool culled = culls_back && !s.front && faces == Faces::drawn;
    s.alpha = culled ? 0 : coverage(base.w);
    if (s.alpha == 0) return;
    if (features & feature_unlit) {
        s.emission = s.base_color;
        return;
    }
    s.metallic = material->metallic_factor;
    s.roughness = material->roughness_factor;
    if (const BoundTexture& t = texture(TextureSlot::metallic_roughness)) {
        const Vec4 texel = read(t);
        s.roughness *= texel.y;
        s.metallic *= texel.z;
    }
    s.emission = emission(read);
    s.ior = material->ior;
    s.eta = s.has(feature_volume) && !s.front ? 1 / s.ior : s.ior;
    if (features) shade_extensions(read, s);
}

void CompiledMaterial::shade_extensions(TextureReader& read, Surface& s) const {
    const Material& m = *material;
    if (s.has(feature_specular)) {
        s.specular = factor(TextureSlot::specular, 3, m.specular_factor, read);
        s.specular_color = color(TextureSlot::specular_color, m.specular_color_factor, read);
        if (const BoundTexture& t = texture(TextureSlot::glossiness))
            s.roughness = 1 - (1 - m.roughness_factor) * read(t).w;
    }
    if (s.has(feature_transmission))
        s.transmission = factor(TextureSlot::transmission, 0, m.transmission_factor, read);
    if (s.has(feature_clearcoat)) {
        s.clearcoat = factor(TextureSlot::clearcoat, 0, m.clearcoat_factor, read);
        s.clearcoat_roughness =
            factor(TextureSlot::clearcoat_roughness, 1, m.clearcoat_roughness_factor, read);
    }
    if (s.has(feature_sheen)) {
        s.sheen_color = color(TextureSlot::sheen_color, m.sheen_color_factor, read);
        s.sheen_roughness = factor(TextureSlot::sheen_roughness, 3, m.sheen_roughness_factor, read);
    }
    if (s.has(feature_iridescence)) {
        s.iridescence = factor(TextureSlot::iridescence, 0, m.iridescence_factor, read);
        s.iridescence_ior = m.iridescence_ior;
        s.iridescence_thickness = m.iridescence_thickness_maximum;
        if (const BoundTexture& t = texture(TextureSlot::iridescence_thickness)) {
            const float low = m.iridescence_thickness_minimum;
            s.iridescence_thickness = low + (s.iridescence_thickness - low) * read(t).y;
        }
    }
    if (s.has(feature_diffuse_transmission)) {
        s.diffuse_transmission =
            factor(TextureSlot::diffuse_transmission, 3, m.diffuse_transmission_factor, read);
        s.diffuse_transmission_color = color(TextureSlot::diffuse_transmission_color,
                                             m.diffuse_transmission_color_factor, read);
    }
}

}  // namespace sightline
