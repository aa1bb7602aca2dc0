#include "support/surfaces.h"

namespace sightline {
namespace {

TEST(SurfaceMaterial, MultipliesFactorTextureAndVertexColour) {
    Scene scene = triangle_scene();
    scene.materials[0].base_color_factor = {0.5f, 0.5f, 1, 1};
    scene.materials[0].base_color_texture = add_texel(scene, {255, 188, 255});
    scene.meshes[0].colors = {{1, 1, 0, 1}, {1, 1, 0, 1}, {1, 1, 1, 1}};
    expect_near(surface(scene).base_color, {0.5f, 0.25145f, 0.5f}, 1e-4f);
}

TEST(SurfaceMaterial, ReadsRoughnessFromGreenAndMetallicFromBlue) {
    Scene scene = triangle_scene();
    scene.materials[0].metallic_factor = 1;
    scene.materials[0].roughness_factor = 0.5f;
    scene.materials[0].metallic_roughness_texture = add_texel(scene, {255, 51, 102});
    const Surface s = surface(scene);
    EXPECT_NEAR(s.roughness, 0.1f, 1e-6f);
    EXPECT_NEAR(s.metallic, 0.4f, 1e-6f);
}

TEST(SurfaceMaterial, ReadsTheChannelsThatTheExtensionsSpecify) {
    Scene scene = triangle_scene();
    Material& m = scene.materials[0];
    m.clearcoat_factor = m.clearcoat_roughness_factor = m.transmission_factor = 1;
    m.iridescence_factor = m.sheen_roughness_factor = m.diffuse_transmission_factor = 1;
    m.sheen_color_factor = Vec3(1);
    const TextureRef ref = add_texel(scene, {51, 102, 153, 204});
    m.clearcoat_texture = m.clearcoat_roughness_texture = m.transmission_texture = ref;
    m.iridescence_texture = m.iridescence_thickness_texture = m.specular_texture = ref;
    m.sheen_roughness_texture = m.diffuse_transmission_texture = ref;
    const Surface s = surface(scene);
    EXPECT_NEAR(s.clearcoat, 0.2f, 1e-6f);
    EXPECT_NEAR(s.clearcoat_roughness, 0.4f, 1e-6f);
    EXPECT_NEAR(s.transmission, 0.2f, 1e-6f);
    EXPECT_NEAR(s.iridescence, 0.2f, 1e-6f);
    EXPECT_NEAR(s.iridescence_thickness, 100 + 0.4f * 300, 1e-3f);
    EXPECT_NEAR(s.specular, 0.8f, 1e-6f);
    EXPECT_NEAR(s.sheen_roughness, 0.8f, 1e-6f);
    EXPECT_NEAR(s.diffuse_transmission, 0.8f, 1e-6f);
}

TEST(SurfaceMaterial, UsesTheCoordinateSetAndTransformOfEachTexture) {
    Scene scene = triangle_scene();
    scene.meshes[0].texcoords.push_back({{0.25f, 0.25f}, {0.25f, 0.25f}, {0.25f, 0.25f}});
    Material& m = scene.materials[0];
    m.base_color_texture = add_texel(scene, {255, 0, 0});
    scene.images[0].width = 2;  // red, then green
    scene.images[0].bytes = {255, 0, 0, 0, 255, 0};
    scene.textures[0].mag = Filter::nearest;
    m.base_color_texture.texcoord = 1;
    expect_near(surface(scene).base_color, {1, 0, 0});
    m.base_color_texture.offset = {0.5f, 0};
    expect_near(surface(scene).base_color, {0, 1, 0});
    m.base_color_texture.texcoord = 7;  // the mesh has none: (0, 0) and the offset
    expect_near(surface(scene).base_color, {0, 1, 0});
}

TEST(SurfaceMaterial, ASetThatAMeshLacksBeforeALaterOneIsZeroEverywhere) {
    Scene scene = triangle_scene();
    Mesh& mesh = scene.meshes[0];
    mesh.texcoords = {{}, {{0.25f, 0.25f}, {0.25f, 0.25f}, {0.25f, 0.25f}}};
    Material& m = scene.materials[0];
    m.base_color_texture = add_texel(scene, {255, 0, 0});
    m.normal_texture = add_texel(scene, {128, 128, 255});
    m.anisotropy_strength = 0.5f;
    const Surface s = surface(scene);
    expect_near(s.base_color, {1, 0, 0});
    EXPECT_NEAR(s.tangent.length(), 1, 1e-6f);
    EXPECT_EQ(Surfaces(scene).texcoord(towards({0, 0, 1}), middle_hit()), Vec2(0, 0));
}

TEST(SurfaceMaterial, AnisotropyRotatesTheTangent) {
    Scene scene = triangle_scene();
    scene.materials[0].anisotropy_strength = 0.5f;
    expect_near(surface(scene).tangent, {1, 0, 0});
    scene.materials[0].anisotropy_rotation = pi / 2;
    expect_near(surface(scene).tangent, {0, 1, 0});
    scene.materials[0].anisotropy_texture = add_texel(scene, {128, 255, 255});
    expect_near(surface(scene).tangent, {-1, 0, 0}, 0.01f);
}

TEST(SurfaceMaterial, AnisotropyWithoutATextureFollowsTheNormalTexturesCoordinates) {
    Scene scene = triangle_scene();
    Mesh& mesh = scene.meshes[0];
    mesh.texcoords.push_back({{0, 0}, {0, 1}, {1, 0}});  // u along y
    Material& m = scene.materials[0];
    m.anisotropy_strength = 0.5f;
    m.normal_texture = add_texel(scene, {128, 128, 255});
    m.normal_texture.texcoord = 1;
    expect_near(surface(scene).tangent, {0, 1, 0}, 0.01f);
}

/// Makes the material's base colour a texture of 64 × 64 texels in stripes of one texel along v.
void add_stripes(Scene& scene) {
    scene.materials[0].base_color_texture = add_texel(scene, {0});
    Image& image = scene.images[0];
    image.width = image.height = 64;
    image.bytes.clear();
    for (int i = 0; i < 64 * 64; ++i) image.bytes.push_back(i % 2 ? 255 : 0);
}

TEST(SurfaceMaterial, AGrazingViewStretchesTheFootprintAlongTheView) {
    Scene scene = triangle_scene();
    add_stripes(scene);
    // middle_hit lies between two texels; half a texel to the right it is on a white one.
    scene.materials[0].base_color_texture.offset = {1.5f / 64, 0};
    const auto red_at = [&](const Vec3& view) {
        return Surfaces(scene).at(towards(normalize(view)), middle_hit(), 1.0f / 64).base_color.x;
    };
    const float slope = std::sqrt(63.0f);  // tangent of the angle whose cosine is 1/8
    const float left_over = 0.5f / 6;      // one of six probes, which cancel out in pairs
    const Vec3 along_stripes(0, -slope, -1), across_stripes(slope, 0, -1);
    EXPECT_NEAR(red_at({0, 0, -1}), 1, 1e-3f);
    EXPECT_NEAR(red_at(along_stripes), 1, 1e-3f);
    EXPECT_NEAR(red_at(across_stripes), 0.5f, left_over);

    TextureRef& ref = scene.materials[0].base_color_texture;
    ref.rotation = pi / 2;  // turns u into −v: the stripes lie along u
    ref.offset = {1.5f / 64, 0.5f / 64};
    EXPECT_NEAR(red_at(across_stripes), 1, 1e-3f);
    EXPECT_NEAR(red_at(along_stripes), 0.5f, left_over);

    ref.rotation = 0;
    ref.offset = {1.5f / 64, 0};
    Mat4 matrix;  // a mirrored, turned instance: x to −y, y to −x
    matrix[0][0] = matrix[1][1] = 0;
    matrix[0][1] = matrix[1][0] = -1;
    scene.instances[0] = make_instance(0, matrix);
    const auto placed_red_at = [&](const Vec3& view) {
        Ray ray = towards(normalize(view));
        ray.origin = Vec3(-0.5f, -0.25f, 0) - ray.direction;
        return Surfaces(scene).at(ray, middle_hit(), 1.0f / 64).base_color.x;
    };
    EXPECT_NEAR(placed_red_at(across_stripes), 1, 1e-3f);
    EXPECT_NEAR(placed_red_at(along_stripes), 0.5f, left_over);
}

TEST(SurfaceMaterial, GlossinessIsOneMinusRoughnessForEachTexel) {
    Scene scene = triangle_scene();
    Material& m = scene.materials[0];
    m.roughness_factor = 0.25f;  // glossiness 0.75
    // sRGB: 188 is 0.50289 (IEC 61966-2-1); alpha is linear.
    m.specular_color_texture = m.glossiness_texture = add_texel(scene, {255, 188, 0, 51});
    const Surface s = surface(scene);
    EXPECT_NEAR(s.roughness, 1 - 0.75f * 0.2f, 1e-6f);
    expect_near(s.specular_color, {1, 0.50289f, 0}, 1e-4f);
    scene.images[0].channels = 3;  // without alpha: the factor alone
    scene.images[0].bytes = {255, 188, 0};
    EXPECT_EQ(surface(scene).roughness, 0.25f);
}

TEST(SurfaceMaterial, AlphaFollowsTheAlphaMode) {
    Scene scene = triangle_scene();
    Material& m = scene.materials[0];
    m.base_color_factor.w = 0.4f;
    const auto alpha = [&] { return surface(scene).alpha; };
    EXPECT_EQ(alpha(), 1);
    m.alpha_mode = AlphaMode::mask;
    EXPECT_EQ(alpha(), 0);
    m.alpha_cutoff = 0.4f;
    EXPECT_EQ(alpha(), 1);
    m.alpha_mode = AlphaMode::blend;
    EXPECT_NEAR(alpha(), 0.4f, 1e-6f);
}

TEST(SurfaceMaterial, BackOfASingleSidedMaterialIsNotDrawn) {
    Scene scene = triangle_scene();
    const auto back_alpha = [&] { return surface(scene, from_back).alpha; };
    EXPECT_EQ(back_alpha(), 0);
    EXPECT_EQ(Surfaces(scene).at(from_back, middle_hit(), 0, Faces::all).alpha,
              1);  // but it casts a shadow
    scene.materials[0].double_sided = true;
    EXPECT_EQ(back_alpha(), 1);
    scene.materials[0].double_sided = false;
    scene.materials[0].transmission_factor = 1;
    EXPECT_EQ(back_alpha(), 1);
}

TEST(SurfaceMaterial, ColoursTheLightOfShadowRays) {
    Scene scene = triangle_scene();
    Material& m = scene.materials[0];
    const auto passed = [&] {
        const LayerTransmittance layer = layer_transmittance(surface(scene));
        return layer.unbent + layer.bent;
    };
    EXPECT_EQ(passed(), Vec3(0));
    m.base_color_factor = {1, 0.5f, 0, 0.25f};
    m.transmission_factor = 1;
    m.roughness_factor = 0;
    expect_near(passed(), {0.96f, 0.48f, 0});
    m.metallic_factor = 0.5f;
    expect_near(passed(), {0.48f, 0.24f, 0});
    m.transmission_factor = 0;
    m.alpha_mode = AlphaMode::blend;
    expect_near(passed(), Vec3(0.75f));
}

TEST(SurfaceMaterial, LeavingAVolumeInvertsTheRefractiveIndex) {
    Scene scene = triangle_scene();
    scene.materials[0].transmission_factor = 1;
    scene.materials[0].ior = 1.25f;
    EXPECT_EQ(surface(scene, from_back).eta, 1.25f);  // thin
    scene.materials[0].thickness_factor = 1;
    EXPECT_EQ(surface(scene).eta, 1.25f);
    EXPECT_EQ(surface(scene, from_back).eta, 0.8f);
}

TEST(SurfaceMaterial, UnlitShowsItsBaseColour) {
    Scene scene = triangle_scene();
    scene.materials[0].unlit = true;
    scene.materials[0].base_color_factor = {0.1f, 0.2f, 0.3f, 1};
    const Surface s = surface(scene);
    EXPECT_TRUE(s.has(feature_unlit));
    expect_near(s.emission, {0.1f, 0.2f, 0.3f});
}

TEST(SurfaceMaterial, CoatAttenuatesTheEmissionBelowIt) {
    Scene scene = triangle_scene();
    scene.materials[0].emissive_factor = {1, 2, 3};
    expect_near(surface(scene).emission, {1, 2, 3});
    scene.materials[0].clearcoat_factor = 1;
    expect_near(surface(scene).emission, Vec3(1, 2, 3) * 0.96f);
}

TEST(SurfaceMaterial, OwnsNoUnusedTextures) {
    Scene scene = triangle_scene();
    scene.materials[0].occlusion_texture = add_texel(scene, {255, 255, 255});
    scene.images[0].width = 4;
    scene.images[0].bytes.resize(12);
    EXPECT_EQ(Surfaces(scene).texture_memory(), 0u);
    scene.materials[0].emissive_factor = Vec3(1);
    scene.materials[0].emissive_texture = scene.materials[0].occlusion_texture;
    EXPECT_EQ(Surfaces(scene).texture_memory(), 9u);  // levels of two and one texels
    EXPECT_EQ(Surfaces(scene, false).texture_memory(), 0u);
}

}  // namespace
}  // namespace sightline
