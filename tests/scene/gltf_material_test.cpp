#include "core/error.h"
#include "scene/gltf/load.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

using nlohmann::json;

// The material read from a file that contains it alone.
struct Loaded {
    Scene scene;
    const Material& material() const { return scene.materials.at(1); }
};

Loaded load_material(const char* text) {
    GltfBuilder file;
    file.json["materials"] = json::array({json::parse(text)});
    file.json["images"] = {{{"uri", "a.png"}}, {{"uri", "b.png"}}};
    file.json["samplers"] = {{{"wrapS", 33071}, {"minFilter", 9984}, {"magFilter", 9728}}};
    file.json["textures"] = {{{"source", 1}, {"sampler", 0}}, {{"source", 0}}};
    return {load_gltf(file.save())};
}

TEST(GltfMaterial, TheDefaultMaterialIsFirst) {
    const Loaded loaded = load_material("{}");
    ASSERT_EQ(loaded.scene.materials.size(), 2u);
    for (const Material& m : loaded.scene.materials) {
        EXPECT_EQ(m.base_color_factor, Vec4(1, 1, 1, 1));
        EXPECT_EQ(m.metallic_factor, 1);
        EXPECT_EQ(m.ior, 1.5f);
        EXPECT_EQ(m.alpha_mode, AlphaMode::opaque);
        EXPECT_FALSE(m.base_color_texture);
    }
}

TEST(GltfMaterial, CorePropertiesAreRead) {
    const Loaded loaded = load_material(R"({
        "name": "m",
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5,
            "roughnessFactor": 0.6},
        "normalTexture": {"index": 1, "scale": 0.7},
        "occlusionTexture": {"index": 1, "strength": 0.8},
        "emissiveFactor": [0.5, 0, 1], "alphaMode": "MASK", "alphaCutoff": 0.9,
        "doubleSided": true})");
    const Material& m = loaded.material();
    EXPECT_EQ(m.name, "m");
    EXPECT_EQ(m.base_color_factor, Vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(m.metallic_factor, 0.5f);
    EXPECT_EQ(m.roughness_factor, 0.6f);
    EXPECT_EQ(m.normal_texture.texture, 1u);
    EXPECT_EQ(m.normal_scale, 0.7f);
    EXPECT_EQ(m.occlusion_strength, 0.8f);
    EXPECT_EQ(m.emissive_factor, Vec3(0.5f, 0, 1));
    EXPECT_EQ(m.alpha_mode, AlphaMode::mask);
    EXPECT_EQ(m.alpha_cutoff, 0.9f);
    EXPECT_TRUE(m.double_sided);
    EXPECT_FALSE(m.unlit);
}

TEST(GltfMaterial, TexturesHaveSamplersAndTransforms) {
    const Loaded loaded = load_material(R"({"pbrMetallicRoughness": {"baseColorTexture":
        {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform":
            {"offset": [1, 2], "rotation": 3, "scale": [4, 5], "texCoord": 0}}}}})");
    const TextureRef& ref = loaded.material().base_color_texture;
    EXPECT_EQ(ref.texture, 0u);
    EXPECT_EQ(ref.texcoord, 0u);
    EXPECT_EQ(ref.offset, Vec2(1, 2));
    EXPECT_EQ(ref.scale, Vec2(4, 5));
    EXPECT_EQ(ref.rotation, 3);
    const Texture& texture = loaded.scene.textures[0];
    EXPECT_EQ(texture.image, 1u);
    EXPECT_EQ(texture.wrap_s, Wrap::clamp_to_edge);
    EXPECT_EQ(texture.wrap_t, Wrap::repeat);
    EXPECT_EQ(texture.min, Filter::nearest_mipmap_nearest);
    EXPECT_EQ(texture.mag, Filter::nearest);
    // No geometry uses it, so its images need not exist.
    EXPECT_TRUE(loaded.scene.images.at(0).empty());
}

TEST(GltfMaterial, ExtensionsAreRead) {
    const Loaded loaded = load_material(R"({"emissiveFactor": [0.5, 0, 1], "extensions": {
        "KHR_materials_emissive_strength": {"emissiveStrength": 4},
        "KHR_materials_ior": {"ior": 1.8}, "KHR_materials_unlit": {},
        "KHR_materials_transmission": {"transmissionFactor": 0.25},
        "KHR_materials_volume": {"thicknessFactor": 2, "attenuationDistance": 3,
            "attenuationColor": [0.5, 0.6, 0.7]},
        "KHR_materials_specular": {"specularFactor": 0.3, "specularColorFactor": [2, 1, 0]},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.4, "clearcoatNormalTexture":
            {"index": 0, "scale": 2}},
        "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 1], "sheenRoughnessFactor": 0.2},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1},
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceIor": 1.4},
        "KHR_materials_dispersion": {"dispersion": 0.1},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.9}}})");
    const Material& m = loaded.material();
    EXPECT_EQ(m.emissive_factor, Vec3(2, 0, 4));
    EXPECT_TRUE(m.unlit);
    EXPECT_EQ(m.ior, 1.8f);
    EXPECT_EQ(m.transmission_factor, 0.25f);
    EXPECT_EQ(m.thickness_factor, 2);
    EXPECT_EQ(m.attenuation_distance, 3);
    EXPECT_EQ(m.attenuation_color, Vec3(0.5f, 0.6f, 0.7f));
    EXPECT_EQ(m.specular_factor, 0.3f);
    EXPECT_EQ(m.specular_color_factor, Vec3(2, 1, 0));
    EXPECT_EQ(m.clearcoat_factor, 0.4f);
    EXPECT_EQ(m.clearcoat_normal_scale, 2);
    EXPECT_EQ(m.sheen_color_factor, Vec3(1, 0, 1));
    EXPECT_EQ(m.sheen_roughness_factor, 0.2f);
    EXPECT_EQ(m.anisotropy_strength, 0.6f);
    EXPECT_EQ(m.anisotropy_rotation, 1);
    EXPECT_EQ(m.iridescence_ior, 1.4f);
    EXPECT_EQ(m.dispersion, 0.1f);
    EXPECT_EQ(m.diffuse_transmission_factor, 0.9f);
}

TEST(GltfMaterial, FactorsBeyondTheirRangeAreClampedWithAWarning) {
    const Loaded loaded = load_material(
        R"({"pbrMetallicRoughness": {"roughnessFactor": 7, "baseColorFactor": [2, 0, -1, 1]}})");
    EXPECT_EQ(loaded.material().roughness_factor, 1);
    EXPECT_EQ(loaded.material().base_color_factor, Vec4(1, 0, 0, 1));
    EXPECT_EQ(loaded.scene.warnings.size(), 2u);
}

TEST(GltfMaterial, AVolumeWithoutAttenuationDistanceAbsorbsNothing) {
    for (const char* distance : {"0", "-1"}) {
        const Loaded loaded = load_material(
            (std::string(R"({"extensions": {"KHR_materials_volume": {"thicknessFactor": 1,
                "attenuationColor": [0.5, 0, 1], "attenuationDistance": )") +
             distance + "}}}")
                .c_str());
        EXPECT_TRUE(std::isinf(loaded.material().attenuation_distance));
        ASSERT_EQ(loaded.scene.warnings.size(), 1u);
        EXPECT_NE(loaded.scene.warnings[0].find("materials[0].extensions.KHR_materials_volume"),
                  std::string::npos);
    }
}

TEST(GltfMaterial, SpecularGlossinessBecomesADielectricOfTheSameReflectance) {
    const Loaded loaded = load_material(R"({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.5, 0.5, 0.3], "diffuseTexture": {"index": 1},
        "specularFactor": [0.04, 0.08, 0.5], "glossinessFactor": 0.75,
        "specularGlossinessTexture": {"index": 0, "texCoord": 1}}}})");
    const Material& m = loaded.material();
    EXPECT_EQ(m.base_color_factor, Vec4(0.5f, 0.5f, 0.5f, 0.3f));
    EXPECT_EQ(m.base_color_texture.texture, 1u);
    EXPECT_EQ(m.metallic_factor, 0);
    EXPECT_EQ(m.roughness_factor, 0.25f);
    EXPECT_FLOAT_EQ(m.specular_color_factor.y * 0.04f, 0.08f);
    EXPECT_FLOAT_EQ(m.specular_color_factor.z * 0.04f, 0.5f);
    for (const TextureRef& ref : {m.specular_color_texture, m.glossiness_texture}) {
        EXPECT_EQ(ref.texture, 0u);
        EXPECT_EQ(ref.texcoord, 1u);
    }
    EXPECT_TRUE(loaded.scene.warnings.empty());
}

TEST(GltfMaterial, SpecularGlossinessReplacesTheMaterialBesideIt) {
    const Loaded loaded = load_material(R"({
        "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.1, 0.1, 1], "roughnessFactor": 0.3,
            "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {},
            "KHR_materials_ior": {"ior": 1.2}, "KHR_materials_specular": {"specularFactor": 0}}})");
    const Material& m = loaded.material();
    EXPECT_EQ(m.base_color_factor, Vec4(1, 1, 1, 1));
    EXPECT_FALSE(m.base_color_texture);
    EXPECT_FALSE(m.metallic_roughness_texture);
    EXPECT_EQ(m.metallic_factor, 0);
    EXPECT_EQ(m.roughness_factor, 0);
    EXPECT_EQ(m.ior, 1.5f);
    EXPECT_EQ(m.specular_factor, 1);
    EXPECT_EQ(m.specular_color_factor, Vec3(1 / 0.04f));
}

TEST(GltfMaterial, AVariantSelectsMaterialsAndAnUnknownOneIsAnError) {
    GltfBuilder file;
    const size_t node = file.triangle();
    ASSERT_EQ(node, 0u);
    file.json["materials"] = {{{"name", "day"}}, {{"name", "night"}}};
    file.json["extensionsUsed"] = {"KHR_materials_variants"};
    file.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "sun"}},
                                                                     {{"name", "moon"}}};
    json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
        {{"material", 1}, {"variants", {1}}}};
    const std::string path = file.save();
    EXPECT_EQ(load_gltf(path).meshes.at(0).material, 1u);
    LoadOptions options;
    options.variant = "moon";
    EXPECT_EQ(load_gltf(path, options).meshes.at(0).material, 2u);
    options.variant = "sun";
    EXPECT_EQ(load_gltf(path, options).meshes.at(0).material, 1u);
    options.variant = "rain";
    EXPECT_THROW(load_gltf(path, options), Error);
}

}  // namespace
}  // namespace sightline
