#include "shade/surface.h"

#include "core/parallel.h"
#include "shade/bsdf.h"
#include "shade/compiled_material.h"

#include <algorithm>
#include <bit>
#include <optional>

namespace sightline {
namespace {

BoundTexture bind(const Scene& scene, const TextureRef& ref, const TextureImage* image) {
    BoundTexture bound;
    bound.image = image;
    bound.sampler = &scene.textures[ref.texture];
    bound.texcoord = ref.texcoord;
    TextureRef linear = ref;
    linear.offset = {0, 0};
    bound.offset = ref.offset;
    bound.across = transform_uv(linear, {1, 0});
    bound.down = transform_uv(linear, {0, 1});
    bound.transformed =
        bound.across != Vec2(1, 0) || bound.down != Vec2(0, 1) || bound.offset != Vec2(0, 0);
    return bound;
}

/// The decoded image of a reference, or none.
uint32_t image_of(const Scene& scene, const TextureRef& ref) {
    if (!ref || ref.texture >= scene.textures.size()) return none;
    const uint32_t image = scene.textures[ref.texture].image;
    return image < scene.images.size() && !scene.images[image].empty() ? image : none;
}

/// Bends `n` just enough for the mirror direction of wo to lie above the surface
/// (Keller et al. 2017, "The Iray Light Transport Simulation and Rendering System", A.3).
Vec3 bend_normal(const Vec3& n, const Vec3& ng, const Vec3& wo) {
    if (n == ng) return n;
    const Vec3 mirrored = reflect(wo, n);
    // The mirror direction of the flat surface limits what bending can reach.
    const float least = std::min(0.9f * dot(wo, ng), 0.01f);
    const float height = dot(mirrored, ng);
    if (height >= least && dot(n, wo) > 0) return n;
    const Vec3 raised = normalize(mirrored + ng * (least - height));
    const Vec3 bent = normalize(wo + raised);
    return dot(bent, wo) > 0 ? bent : ng;
}

Vec3 mapped_normal(const BoundTexture& texture, float scale, TextureReader& read) {
    const HitGeometry& g = read.geometry;
    const Vec4 texel = read(texture);
    const Vec4 frame = g.tangent(texture.texcoord, texture.across, texture.down);
    const Vec3 t(frame.x, frame.y, frame.z);
    const Vec3 b = cross(g.normal, t) * frame.w;
    const Vec3 n = t * ((texel.x * 2 - 1) * scale) + b * ((texel.y * 2 - 1) * scale) +
                   g.normal * (texel.z * 2 - 1);
    return dot(n, n) > 1e-12f ? normalize(n) : g.normal;
}

/// Sets the tangent: rotated as KHR_materials_anisotropy describes and projected onto ns's plane.
void orient_anisotropy(const Material& m, const BoundTexture& texture, TextureReader& read,
                       Surface& s) {
    const HitGeometry& g = read.geometry;
    Vec2 along(1, 0);
    s.anisotropy = m.anisotropy_strength;
    if (texture) {
        const Vec4 texel = read(texture);
        along = Vec2(texel.x * 2 - 1, texel.y * 2 - 1);
        s.anisotropy *= texel.z;
    }
    const float c = std::cos(m.anisotropy_rotation), sine = std::sin(m.anisotropy_rotation);
    const Vec4 frame = texture ? g.tangent(texture.texcoord, texture.across, texture.down)
                               : g.tangent(m.normal_texture.texcoord);
    const Vec3 t(frame.x, frame.y, frame.z);
    const Vec3 b = cross(g.normal, t) * frame.w;
    const Vec3 turned = t * (c * along.x - sine * along.y) + b * (sine * along.x + c * along.y);
    s.tangent = normalize(turned - s.ns * dot(s.ns, turned));
    if (!(dot(s.tangent, s.tangent) > 0.5f)) s.anisotropy = 0;
}

/// The float next to the finite x in the direction of the sign of `step`. Floats are stored as sign
/// and magnitude; as two's complements they are in order.
float nudged(float x, float step) {
    const auto flipped = [](int32_t i) {
        return i < 0 ? std::numeric_limits<int32_t>::min() - i : i;
    };
    const int32_t next = flipped(std::bit_cast<int32_t>(x)) + int(step > 0) - int(step < 0);
    return std::bit_cast<float>(flipped(next));
}

Vec3 offset_origin(const Surface& s, const Vec3& position, bool above) {
    const Vec3& n = s.ng;
    const float distance = std::fabs(n.x) * s.position_error.x +
                           std::fabs(n.y) * s.position_error.y +
                           std::fabs(n.z) * s.position_error.z;
    const Vec3 step = n * (above ? distance : -distance);
    return {nudged(position.x + step.x, step.x), nudged(position.y + step.y, step.y),
            nudged(position.z + step.z, step.z)};
}

/// True if no texel of the image has a colour; early out, since few images are black.
bool is_black(const Image& image) {
    const auto channels = static_cast<size_t>(image.channels);
    const size_t colors = channels >= 3 ? 3 : 1;
    const auto all_black = [&](const auto& values) {
        for (size_t texel = 0; texel < values.size(); texel += channels)
            for (size_t c = 0; c < colors; ++c)
                if (values[texel + c] > 0) return false;
        return true;
    };
    return image.bytes.empty() ? all_black(image.floats) : all_black(image.bytes);
}

}  // namespace

bool culls_back_faces(const Material& m) { return !m.double_sided && !(m.transmission_factor > 0); }

Surfaces::Surfaces(const Scene& scene, bool mipmaps, unsigned threads) : scene_(scene) {
    const size_t count = scene.images.size();
    std::vector<uint8_t> is_used(2 * count, 0);  // linear, then sRGB
    for (const Material& material : scene.materials) {
        for (const SlotTexture& use : slot_textures(material)) {
            const uint32_t image = image_of(scene, *use.ref);
            if (image != none) is_used[use.srgb ? count + image : image] = 1;
        }
    }
    linear_.resize(count);
    srgb_.resize(count);
    const auto prepare = [&](size_t i) {
        const bool srgb = i >= count;
        const size_t image = srgb ? i - count : i;
        if (!is_used[i]) return;
        (srgb ? srgb_ : linear_)[image] =
            std::make_unique<TextureImage>(scene.images[image], srgb, mipmaps);
    };
    run_with_threads(threads, [&] { parallel_for(is_used.size(), prepare); });
    for (const Material& material : scene.materials) {
        CompiledMaterial& compiled = materials_.emplace_back();
        compiled.material = &material;
        compiled.features = material_features(material);
        compiled.culls_back = culls_back_faces(material);
        compiled.needs_uv = (compiled.features & feature_anisotropy) != 0;
        for (const SlotTexture& use : slot_textures(material)) {
            const uint32_t image = image_of(scene, *use.ref);
            if (image == none) continue;
            compiled.needs_uv = true;
            const auto& images = use.srgb ? srgb_ : linear_;
            compiled.bind(use.slot, bind(scene, *use.ref, images[image].get()));
        }
    }
    prepare_emission();
}

void Surfaces::prepare_emission() {
    filtered_textures_ = scene_.textures;
    for (Texture& texture : filtered_textures_) {
        texture.mag = Filter::linear;
        texture.min = Filter::linear_mipmap_linear;
    }
    std::vector<std::optional<bool>> black(scene_.images.size());
    filtered_.resize(materials_.size());
    for (size_t i = 0; i < materials_.size(); ++i) {
        const Material& m = *materials_[i].material;
        if (m.unlit || !(max_component(m.emissive_factor) > 0)) continue;
        const uint32_t image = image_of(scene_, m.emissive_texture);
        if (image != none) {
            if (!black[image]) black[image] = is_black(scene_.images[image]);
            if (*black[image]) continue;
        }
        filtered_[i] = std::make_unique<CompiledMaterial>(materials_[i]);
        for (BoundTexture& bound : filtered_[i]->textures) {
            if (bound) bound.sampler = &filtered_textures_[bound.sampler - scene_.textures.data()];
        }
    }
}

Surfaces::~Surfaces() = default;

Surface Surfaces::at(const Ray& ray, const Hit& hit, float footprint, Faces faces) const {
    Surface s;
    s.material = scene_.material_of(hit.geometry);
    s.id = surface_of(hit);
    const CompiledMaterial& compiled = materials_[s.material];
    const HitGeometry g = hit_geometry(scene_, hit, &ray, compiled.needs_uv);
    const Material& m = *compiled.material;
    s.position = g.position;
    s.position_error = g.position_error;
    s.wo = normalize(-ray.direction);
    const float cos_o = dot(g.outward, s.wo);
    s.front = cos_o >= 0;
    s.ng = s.front ? g.outward : -g.outward;
    if (g.area2 == 0 && g.mesh) s.ng = s.wo;

    TextureReader read(g, -s.wo, footprint);
    const float facing = dot(g.normal, s.ng) < 0 ? -1.0f : 1.0f;
    Vec3 normal = g.normal;
    if (g.has_vertex_normals) s.shadow_terminator_offset = g.shadow_terminator_offset(s.ng);
    if (const BoundTexture& t = compiled.texture(TextureSlot::normal)) {
        normal = mapped_normal(t, m.normal_scale, read);
    }
    s.ns = bend_normal(normal * facing, s.ng, s.wo);
    s.bend = s.ns - normal * facing;
    compiled.shade(read, s, faces);
    if (s.has(feature_clearcoat)) {
        const BoundTexture& t = compiled.texture(TextureSlot::clearcoat_normal);
        const Vec3 coat = t ? mapped_normal(t, m.clearcoat_normal_scale, read) : g.normal;
        s.coat_normal = bend_normal(coat * facing, s.ng, s.wo);
        if (!is_black(s.emission)) {
            const float cos_coat = std::fabs(dot(s.coat_normal, s.wo));
            s.emission *= 1 - s.clearcoat * coat_albedo(cos_coat, s.clearcoat_roughness);
        }
    }
    if (s.has(feature_anisotropy)) {
        orient_anisotropy(m, compiled.texture(TextureSlot::anisotropy), read, s);
    }
    return s;
}

Vec3 Surfaces::emission(const HitGeometry& g, const Hit& hit, const Ray& ray) const {
    const CompiledMaterial& compiled = materials_[scene_.material_of(hit.geometry)];
    if (compiled.features & feature_clearcoat) {
        const Surface s = at(ray, hit, 0);
        return s.emission * s.alpha;
    }
    TextureReader whole(g, g.outward, 0), read(g, g.outward, 0, emitter_footprint);
    const float alpha = compiled.material->alpha_mode == AlphaMode::opaque
                            ? 1
                            : compiled.coverage(compiled.base_color(whole).w);
    return alpha > 0 ? compiled.emission(read) * alpha : Vec3(0);
}

float Surfaces::mean_emission(const Hit& hit, float size) const {
    const CompiledMaterial& compiled = *filtered_[scene_.material_of(hit.geometry)];
    const Material& m = *compiled.material;
    const HitGeometry g = hit_geometry(scene_, hit, nullptr, true);
    const float width = size * std::sqrt(0.5f * g.area2);
    TextureReader read(g, g.outward, width), emitted(g, g.outward, width, emitter_footprint);
    const float emission = luminance(compiled.emission(emitted));
    if (m.alpha_mode == AlphaMode::opaque || !(emission > 0)) return emission;
    const float alpha = compiled.base_color(read).w;
    const bool varies = m.base_color_texture || !g.mesh->colors.empty();
    const bool cut_out = m.alpha_mode == AlphaMode::mask && varies;
    return emission * (cut_out ? std::clamp(alpha, 0.0f, 1.0f) : compiled.coverage(alpha));
}

Vec2 Surfaces::texcoord(const Ray& ray, const Hit& hit) const {
    return hit_geometry(scene_, hit, &ray, true).uv;
}

size_t Surfaces::texture_memory() const {
    size_t sum = 0;
    for (const auto* images : {&linear_, &srgb_}) {
        for (const auto& image : *images) sum += image ? image->memory() : 0;
    }
    return sum;
}

uint64_t Surfaces::finer_lookups() const {
    uint64_t sum = 0;
    for (const auto* images : {&linear_, &srgb_}) {
        for (const auto& image : *images) sum += image ? image->finer_lookups() : 0;
    }
    return sum;
}

Ray spawn_ray(const Surface& surface, const Vec3& direction, float tfar) {
    const bool above = dot(direction, surface.ng) >= 0;
    return {offset_origin(surface, surface.position, above), 0, direction, tfar};
}

Ray spawn_shadow_ray(const Surface& surface, const Vec3& direction, float distance) {
    // Light that a normal sees, though the surface hides it, starts above and meets the surface.
    const bool above =
        dot(direction, surface.ns) >= 0 || dot(direction, surface.diffuse_normal()) >= 0;
    const Vec3 start =
        above ? surface.position + surface.shadow_terminator_offset : surface.position;
    Ray ray{offset_origin(surface, start, above), 0, direction, distance};
    if (std::isinf(distance)) return ray;
    // In the old direction, a ray from above the surface would end beside the light's point or
    // behind it.
    const Vec3 towards = surface.position + direction * distance - ray.origin;
    const float length2 = dot(towards, towards);
    if (!(length2 > 0)) return ray;
    ray.tfar = std::sqrt(length2);
    ray.direction = towards * (1 / ray.tfar);
    return ray;
}

}  // namespace sightline
