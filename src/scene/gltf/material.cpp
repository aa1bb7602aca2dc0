#include "scene/gltf/material.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

using nlohmann::json;

// One JSON object of a material, or none. Reading an absent property leaves the value unchanged.
class Properties {
  public:
    Properties(Document& document, const json* object, std::string place)
        : document_(document), object_(object), place_(std::move(place)) {}

    explicit operator bool() const { return object_; }

    Properties child(const char* key) const { return {document_, find(key), place_ + "." + key}; }

    Properties extension(const char* name) const {
        return {document_, object_ ? find_extension(*object_, name) : nullptr,
                place_ + ".extensions." + name};
    }

    template <class T>
    void read(const char* key, T& value) const {
        if (const json* found = find(key)) found->get_to(value);
    }

    // Reads a number and clamps it to [low, high], its physical range.
    void read(const char* key, float& value, float low, float high) const {
        read(key, value);
        const float clamped = std::clamp(value, low, high);
        if (clamped != value)
            document_.warn(place_ + "." + key, fmt::format("{} is clamped to {}", value, clamped));
        value = clamped;
    }

    template <class T>
    void read_vector(const char* key, T& value, float high) const {
        const json* found = find(key);
        if (!found) return;
        bool is_clamped = false;
        for (unsigned i = 0; i < T::dimensions(); ++i) {
            const float number = (*found)[i].get<float>();
            value[static_cast<int>(i)] = std::clamp(number, 0.0f, high);
            is_clamped |= value[static_cast<int>(i)] != number;
        }
        if (is_clamped)
            document_.warn(place_ + "." + key, fmt::format("is clamped to [0, {}]", high));
    }

    // Reads the texture's scale or strength, under `scale_key`, into `scale`.
    void read_texture(const char* key, TextureRef& ref, const char* scale_key = nullptr,
                      float* scale = nullptr) const {
        const Properties info = child(key);
        if (!info) return;
        info.read("index", ref.texture);
        info.read("texCoord", ref.texcoord);
        if (scale_key) info.read(scale_key, *scale);
        const Properties transform = info.extension("KHR_texture_transform");
        transform.read_pair("offset", ref.offset);
        transform.read_pair("scale", ref.scale);
        transform.read("rotation", ref.rotation);
        transform.read("texCoord", ref.texcoord);
    }

    void warn(const std::string& text) const { document_.warn(place_, text); }

  private:
    const json* find(const char* key) const {
        if (!object_) return nullptr;
        const auto found = object_->find(key);
        return found == object_->end() ? nullptr : &*found;
    }

    void read_pair(const char* key, Vec2& value) const {
        if (const json* found = find(key)) value = {(*found)[0].get<float>(), (*found)[1]};
    }

    Document& document_;
    const json* object_;
    std::string place_;
};

constexpr float infinity = std::numeric_limits<float>::infinity();

void read_metallic_roughness(const Properties& pbr, Material& m) {
    pbr.read_vector("baseColorFactor", m.base_color_factor, 1);
    pbr.read_texture("baseColorTexture", m.base_color_texture);
    pbr.read("metallicFactor", m.metallic_factor, 0, 1);
    pbr.read("roughnessFactor", m.roughness_factor, 0, 1);
    pbr.read_texture("metallicRoughnessTexture", m.metallic_roughness_texture);
}

void read_common(const Properties& p, Material& m) {
    p.read("name", m.name);
    p.read_texture("normalTexture", m.normal_texture, "scale", &m.normal_scale);
    p.read_texture("occlusionTexture", m.occlusion_texture, "strength", &m.occlusion_strength);
    p.read_vector("emissiveFactor", m.emissive_factor, 1);
    p.read_texture("emissiveTexture", m.emissive_texture);
    std::string mode = "OPAQUE";
    p.read("alphaMode", mode);
    m.alpha_mode = mode == "MASK"    ? AlphaMode::mask
                   : mode == "BLEND" ? AlphaMode::blend
                                     : AlphaMode::opaque;
    p.read("alphaCutoff", m.alpha_cutoff);
    p.read("doubleSided", m.double_sided);
    m.unlit = static_cast<bool>(p.extension("KHR_materials_unlit"));
    float strength = 1;
    p.extension("KHR_materials_emissive_strength").read("emissiveStrength", strength, 0, infinity);
    m.emissive_factor *= strength;
}

void read_transmission(const Properties& p, Material& m) {
    const Properties transmission = p.extension("KHR_materials_transmission");
    transmission.read("transmissionFactor", m.transmission_factor, 0, 1);
    transmission.read_texture("transmissionTexture", m.transmission_texture);
    const Properties volume = p.extension("KHR_materials_volume");
    volume.read("thicknessFactor", m.thickness_factor, 0, infinity);
    volume.read("attenuationDistance", m.attenuation_distance);
    if (!(m.attenuation_distance > 0)) {
        volume.warn(fmt::format("attenuationDistance {} is not positive: nothing is absorbed",
                                m.attenuation_distance));
        m.attenuation_distance = infinity;
    }
    volume.read_vector("attenuationColor", m.attenuation_color, 1);
    p.extension("KHR_materials_dispersion").read("dispersion", m.dispersion, 0, infinity);
    const Properties diffuse = p.extension("KHR_materials_diffuse_transmission");
    diffuse.read("diffuseTransmissionFactor", m.diffuse_transmission_factor, 0, 1);
    diffuse.read_texture("diffuseTransmissionTexture", m.diffuse_transmission_texture);
    diffuse.read_vector("diffuseTransmissionColorFactor", m.diffuse_transmission_color_factor, 1);
    diffuse.read_texture("diffuseTransmissionColorTexture", m.diffuse_transmission_color_texture);
}

void read_specular(const Properties& p, Material& m) {
    const Properties ior = p.extension("KHR_materials_ior");
    ior.read("ior", m.ior, 0, infinity);
    if (m.ior > 0 && m.ior < 1) {
        ior.warn(fmt::format("{} is clamped to 1", m.ior));
        m.ior = 1;
    }
    const Properties specular = p.extension("KHR_materials_specular");
    specular.read("specularFactor", m.specular_factor, 0, 1);
    specular.read_texture("specularTexture", m.specular_texture);
    specular.read_vector("specularColorFactor", m.specular_color_factor, infinity);
    specular.read_texture("specularColorTexture", m.specular_color_texture);
}

void read_anisotropy(const Properties& p, Material& m) {
    const Properties anisotropy = p.extension("KHR_materials_anisotropy");
    anisotropy.read("anisotropyStrength", m.anisotropy_strength, 0, 1);
    anisotropy.read("anisotropyRotation", m.anisotropy_rotation);
    anisotropy.read_texture("anisotropyTexture", m.anisotropy_texture);
}

void read_layers(const Properties& p, Material& m) {
    const Properties coat = p.extension("KHR_materials_clearcoat");
    coat.read("clearcoatFactor", m.clearcoat_factor, 0, 1);
    coat.read_texture("clearcoatTexture", m.clearcoat_texture);
    coat.read("clearcoatRoughnessFactor", m.clearcoat_roughness_factor, 0, 1);
    coat.read_texture("clearcoatRoughnessTexture", m.clearcoat_roughness_texture);
    coat.read_texture("clearcoatNormalTexture", m.clearcoat_normal_texture, "scale",
                      &m.clearcoat_normal_scale);
    const Properties sheen = p.extension("KHR_materials_sheen");
    sheen.read_vector("sheenColorFactor", m.sheen_color_factor, 1);
    sheen.read_texture("sheenColorTexture", m.sheen_color_texture);
    sheen.read("sheenRoughnessFactor", m.sheen_roughness_factor, 0, 1);
    sheen.read_texture("sheenRoughnessTexture", m.sheen_roughness_texture);
    const Properties film = p.extension("KHR_materials_iridescence");
    film.read("iridescenceFactor", m.iridescence_factor, 0, 1);
    film.read_texture("iridescenceTexture", m.iridescence_texture);
    film.read("iridescenceIor", m.iridescence_ior, 1, infinity);
    film.read("iridescenceThicknessMinimum", m.iridescence_thickness_minimum, 0, infinity);
    film.read("iridescenceThicknessMaximum", m.iridescence_thickness_maximum, 0, infinity);
    film.read_texture("iridescenceThicknessTexture", m.iridescence_thickness_texture);
}

// Specular-glossiness equals a dielectric whose reflectance at normal incidence is the specular
// colour, which with index 1.5 is 0.04 times KHR_materials_specular's colour, and whose roughness
// is 1 − glossiness.
void read_specular_glossiness(const Properties& p, Material& m) {
    m.metallic_factor = 0;
    p.read_vector("diffuseFactor", m.base_color_factor, 1);
    p.read_texture("diffuseTexture", m.base_color_texture);
    m.specular_color_factor = {1, 1, 1};
    p.read_vector("specularFactor", m.specular_color_factor, 1);
    m.specular_color_factor /= 0.04f;
    p.read_texture("specularGlossinessTexture", m.specular_color_texture);
    m.glossiness_texture = m.specular_color_texture;
    float glossiness = 1;
    p.read("glossinessFactor", glossiness, 0, 1);
    m.roughness_factor = 1 - glossiness;
}

// The one place that decides which images a material reads: none whose values a factor of 0
// removes, and of an unlit material only the base colour. Others need not even exist.
void drop_unread_textures(Material& m) {
    const auto keep = [](bool is_read, std::initializer_list<TextureRef*> refs) {
        if (is_read) return;
        for (TextureRef* ref : refs) *ref = {};
    };
    const auto has_color = [](const Vec3& c) { return std::max({c.x, c.y, c.z}) > 0; };
    keep(m.metallic_factor > 0 || m.roughness_factor > 0, {&m.metallic_roughness_texture});
    keep(has_color(m.emissive_factor), {&m.emissive_texture});
    keep(m.transmission_factor > 0, {&m.transmission_texture});
    keep(m.specular_factor > 0, {&m.specular_texture});
    keep(has_color(m.specular_color_factor), {&m.specular_color_texture});
    keep(m.roughness_factor < 1, {&m.glossiness_texture});
    keep(m.clearcoat_factor > 0,
         {&m.clearcoat_texture, &m.clearcoat_roughness_texture, &m.clearcoat_normal_texture});
    keep(m.clearcoat_roughness_factor > 0, {&m.clearcoat_roughness_texture});
    keep(has_color(m.sheen_color_factor), {&m.sheen_color_texture, &m.sheen_roughness_texture});
    keep(m.sheen_roughness_factor > 0, {&m.sheen_roughness_texture});
    keep(m.anisotropy_strength > 0, {&m.anisotropy_texture});
    keep(m.iridescence_factor > 0, {&m.iridescence_texture, &m.iridescence_thickness_texture});
    keep(m.diffuse_transmission_factor > 0,
         {&m.diffuse_transmission_texture, &m.diffuse_transmission_color_texture});
    keep(has_color(m.diffuse_transmission_color_factor), {&m.diffuse_transmission_color_texture});
    if (!m.unlit) return;
    const TextureRef base_color = m.base_color_texture;
    for_each_texture(m, [](TextureRef& ref) { ref = {}; });
    m.base_color_texture = base_color;
}

Material read_material(Document& document, const json& source, const std::string& place) {
    const Properties p(document, &source, place);
    Material m;
    read_common(p, m);
    const Properties glossiness = p.extension("KHR_materials_pbrSpecularGlossiness");
    if (glossiness) {
        // What the file has beside it is a substitute for programs without the extension.
        read_specular_glossiness(glossiness, m);
    } else {
        read_metallic_roughness(p.child("pbrMetallicRoughness"), m);
        read_specular(p, m);
    }
    read_anisotropy(p, m);
    read_transmission(p, m);
    read_layers(p, m);
    drop_unread_textures(m);
    return m;
}

// Removes the textures that no pixel depends on: their images need not exist.
void drop_textures_without_effect(Material& m) {
    const auto drop = [](bool without_effect, std::initializer_list<TextureRef*> textures) {
        if (!without_effect) return;
        for (TextureRef* texture : textures) *texture = {};
    };
    drop(m.emissive_factor == Vec3(0), {&m.emissive_texture});
    drop(m.clearcoat_factor == 0,
         {&m.clearcoat_texture, &m.clearcoat_roughness_texture, &m.clearcoat_normal_texture});
    drop(m.sheen_color_factor == Vec3(0), {&m.sheen_color_texture, &m.sheen_roughness_texture});
    drop(m.transmission_factor == 0, {&m.transmission_texture});
    drop(m.iridescence_factor == 0, {&m.iridescence_texture, &m.iridescence_thickness_texture});
    drop(m.anisotropy_strength == 0, {&m.anisotropy_texture});
    drop(m.diffuse_transmission_factor == 0,
         {&m.diffuse_transmission_texture, &m.diffuse_transmission_color_texture});
    drop(m.unlit, {&m.normal_texture, &m.metallic_roughness_texture, &m.clearcoat_normal_texture,
                   &m.anisotropy_texture});
}

Wrap to_wrap(int code) {
    return code == 33071   ? Wrap::clamp_to_edge
           : code == 33648 ? Wrap::mirrored_repeat
                           : Wrap::repeat;
}

Filter to_filter(int code) {
    switch (code) {
        case 9728:
            return Filter::nearest;
        case 9729:
            return Filter::linear;
        case 9984:
            return Filter::nearest_mipmap_nearest;
        case 9985:
            return Filter::linear_mipmap_nearest;
        case 9986:
            return Filter::nearest_mipmap_linear;
        default:
            return Filter::linear_mipmap_linear;
    }
}

// The image to use; WebP and AVIF take precedence.
uint32_t texture_source(Document& document, const json& texture, const std::string& place) {
    for (const char* name : {"EXT_texture_webp", "EXT_texture_avif"}) {
        const json* extension = find_extension(texture, name);
        if (extension && extension->contains("source")) return (*extension)["source"];
    }
    if (texture.contains("source")) return texture["source"];
    if (find_extension(texture, "KHR_texture_basisu"))
        document.report(Fault::ktx2_texture, place);
    else
        document.warn(place, "has no supported image: drawn without");
    return none;
}

Texture read_texture(Document& document, const json& source, const std::string& place) {
    Texture texture;
    texture.image = texture_source(document, source, place);
    if (source.contains("sampler")) {
        const json& sampler = document.json["samplers"][source["sampler"].get<size_t>()];
        texture.mag = to_filter(sampler.value("magFilter", 9729));
        texture.min = to_filter(sampler.value("minFilter", 9987));
        texture.wrap_s = to_wrap(sampler.value("wrapS", 10497));
        texture.wrap_t = to_wrap(sampler.value("wrapT", 10497));
    }
    return texture;
}

}  // namespace

std::vector<Texture> read_textures(Document& document) {
    std::vector<Texture> textures;
    for (const json& source : document.list("textures")) {
        const std::string place = fmt::format("textures[{}]", textures.size());
        textures.push_back(read_texture(document, source, place));
    }
    return textures;
}

std::vector<Material> read_materials(Document& document, const std::vector<Texture>& textures) {
    std::vector<Material> materials(1);
    for (const json& source : document.list("materials")) {
        const std::string place = fmt::format("materials[{}]", materials.size() - 1);
        Material& m = materials.emplace_back(read_material(document, source, place));
        for_each_texture(m, [&](TextureRef& ref) {
            if (textures[ref.texture].image == none) ref.texture = none;
        });
        drop_textures_without_effect(m);
    }
    return materials;
}

}  // namespace sightline
