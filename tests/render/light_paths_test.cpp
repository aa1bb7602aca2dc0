// Each path of light is counted once: pictures by light sampling and secondary rays together are
// compared with those by one of the two alone, for pairs of light, pane and receiver.
#include "support/pictures.h"

#include <cmath>
#include <functional>

namespace sightline {
namespace {

// Sanitizers are twenty times slower. With them, a sixteenth of the samples cover the code; the
// per cents are for the other builds.
constexpr bool sanitized = SIGHTLINE_SANITIZED;

// A mean over pixels, each an independent estimate, and its standard error.
struct Estimate {
    double mean = 0, error = 0;
};

Estimate operator+(const Estimate& a, const Estimate& b) {
    return {a.mean + b.mean, std::hypot(a.error, b.error)};
}

struct NamedMaterial {
    const char* name;
    Material material;
    bool is_solid = false;
};

Material metal(float roughness) {
    Material m;
    m.base_color_factor = {0.9f, 0.9f, 0.9f, 1};
    m.roughness_factor = roughness;
    m.double_sided = true;
    return m;
}

Material coated(Material base, float roughness) {
    base.clearcoat_factor = 1;
    base.clearcoat_roughness_factor = roughness;
    return base;
}

Material film(float alpha) {
    Material m = matte({0, 0, 0});
    m.base_color_factor.w = alpha;
    m.alpha_mode = AlphaMode::blend;
    return m;
}

Material glass(float ior, float roughness, float thickness) {
    Material m = matte({0.9f, 0.9f, 0.9f});
    m.specular_factor = 1;
    m.ior = ior;
    m.roughness_factor = roughness;
    m.transmission_factor = 1;
    m.thickness_factor = thickness;
    if (thickness > 0) {
        m.attenuation_distance = 1;
        m.attenuation_color = {0.5f, 0.5f, 0.5f};
    }
    return m;
}

// They reflect nothing, so that no path goes to and fro between pane and floor.
const std::vector<NamedMaterial> clear_panes = {
    {"none", film(0)},
    {"alpha", film(0.5f)},
    {"thin, ior 1", glass(1, 0, 0)},
    {"thin, ior 1, rough", glass(1, 0.5f, 0)},
    {"solid, ior 1, rough", glass(1, 0.5f, 1), true},
};

const std::vector<NamedMaterial> reflecting_panes = {
    {"thin", glass(1.5f, 0, 0)},
    {"thin, rough", glass(1.5f, 0.5f, 0)},
    {"solid", glass(1.5f, 0, 1), true},
    {"solid, rough", glass(1.5f, 0.4f, 1), true},
};

const std::vector<NamedMaterial> glossy_receivers = {
    {"rough metal", metal(0.5f)},
    {"mirror", metal(0)},
    {"rough metal under a rough coat", coated(metal(0.6f), 0.3f)},
};

const std::vector<NamedMaterial> diffuse_receivers = {
    {"diffuse", matte({0.8f, 0.8f, 0.8f})},
    {"diffuse under a smooth coat", coated(matte({0.8f, 0.8f, 0.8f}), 0)},
};

// A floor below a pane.
SceneBuilder floor_and_pane(const Material& floor, const NamedMaterial& pane) {
    SceneBuilder builder;
    draw(builder, quad_mesh({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), floor);
    Mesh lower = quad_mesh({-3, 0.4f, -3}, {6, 0, 0}, {0, 0, 6});
    if (!pane.is_solid) {
        draw(builder, lower, pane.material);
        return builder;
    }
    const uint32_t m = builder.add_material(pane.material);
    builder.add_instance(builder.add_mesh(lower, m));
    builder.add_instance(builder.add_mesh(quad_mesh({-3, 0.5f, 3}, {6, 0, 0}, {0, 0, -6}), m));
    return builder;
}

// A square lamp of that size, not quite above the point that is seen.
Mesh lamp_mesh(float size) {
    return quad_mesh({-0.5f * size, 1, -0.7f * size}, {size, 0, 0}, {0, 0, size});
}

Material lamp_material() {
    Material lamp = matte({0, 0, 0});
    lamp.emissive_factor = {1, 1, 1};
    lamp.double_sided = false;
    return lamp;
}

Scene under_a_lamp(const Material& floor, const NamedMaterial& pane, float size) {
    SceneBuilder builder = floor_and_pane(floor, pane);
    draw(builder, lamp_mesh(size), lamp_material());
    return builder.finish();
}

// Bright in a part of the upper half, dim in the rest of it.
Environment half_sky() {
    Image picture;
    picture.width = 16;
    picture.height = 8;
    picture.channels = 1;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x)
            picture.floats.push_back(y >= 3 ? 0 : x >= 2 && x < 8 ? 1 : 0.4f);
    return Environment(picture, 0);
}

// The radiance of one point of the floor, seen from below the pane.
Estimate floor_radiance(const Scene& scene, const Environment* sky, int samples,
                        const std::function<void(Needs&)>& change_needs) {
    RenderSettings settings = small_settings(look_at({0, 0.3f, 0.3f}, {0, 0, 0}, {0, 1, 0}, 1e-3f),
                                             sanitized ? samples / 16 : samples, 4, 4);
    settings.cutoff = 3e-4f;
    // At the last bounce light sampling is alone, which rays alone do not have.
    settings.depth = 20;
    Needs needs = find_needs(scene, settings, sky != nullptr);
    change_needs(needs);
    const Film film = render_scene(scene, settings, sky, &needs).film;
    double sum = 0, sum2 = 0, n = 16;
    for (const float v : film.find("G")->values) {
        sum += static_cast<double>(v);
        sum2 += static_cast<double>(v) * static_cast<double>(v);
    }
    const double variance = std::max(0.0, sum2 / n - sum * sum / (n * n)) / (n - 1);
    return {sum / n, std::sqrt(variance)};
}

Estimate by_both(const Scene& scene, const Environment* sky, int samples = 256) {
    return floor_radiance(scene, sky, samples, [](Needs&) {});
}

Estimate by_rays_alone(const Scene& scene, const Environment* sky, int samples = 256) {
    return floor_radiance(scene, sky, samples, [](Needs& needs) {
        needs.area_lights = needs.environment_light = false;
    });
}

// More samples, since a lobe that only lights sample is noisy.
Estimate by_lights_alone(const Scene& scene, const Environment* sky) {
    return floor_radiance(scene, sky, 4096, [](Needs& needs) {
        needs.secondary_rays = false;
        needs.depth = 0;
    });
}

// Both estimators have an error below a third of a per cent, so that 1 % is three of them.
void expect_equal(const Estimate& got, const Estimate& right) {
    ASSERT_GT(right.mean, 1e-3);
    const double error = std::hypot(got.error, right.error);
    if (!sanitized) {
        EXPECT_LT(error, 0.0034 * right.mean);
    }
    EXPECT_NEAR(got.mean, right.mean, sanitized ? 5 * error : 0.01 * right.mean);
}

using Check = std::function<void(const Scene&, const Environment*)>;

// Light sampling is less noisy with a small lamp, rays are with a large one.
constexpr float small_lamp = 2.2f, large_lamp = 5;

// Under a lamp, and under a sky.
void for_each_pair(const std::vector<NamedMaterial>& panes,
                   const std::vector<NamedMaterial>& receivers, float lamp_size,
                   const Check& check) {
    const Environment sky = half_sky();
    for (const NamedMaterial& pane : panes)
        for (const NamedMaterial& receiver : receivers) {
            SCOPED_TRACE(std::string(receiver.name) + " below a pane: " + pane.name);
            check(under_a_lamp(receiver.material, pane, lamp_size), nullptr);
            check(floor_and_pane(receiver.material, pane).finish(), &sky);
        }
}

// Each of the two alone makes every path of a rough lobe through these.
TEST(LightPaths, LightSamplingAndRaysAgreeThroughPanesThatReflectNothing) {
    const std::vector<NamedMaterial> rough = {glossy_receivers[0], glossy_receivers[2]};
    for_each_pair(clear_panes, rough, small_lamp, [](const Scene& scene, const Environment* sky) {
        expect_equal(by_lights_alone(scene, sky), by_rays_alone(scene, sky, 1024));
    });
}

void expect_rays_alone(const Scene& scene, const Environment* sky) {
    expect_equal(by_both(scene, sky), by_rays_alone(scene, sky));
}

TEST(LightPaths, GlossyReflectionsThroughClearPanesAreThoseOfRaysAlone) {
    for_each_pair(clear_panes, glossy_receivers, large_lamp, expect_rays_alone);
}

TEST(LightPaths, MirrorsThroughGlassShowWhatRaysAloneDo) {
    const std::vector<NamedMaterial> panes(reflecting_panes.begin(), reflecting_panes.begin() + 3);
    for_each_pair(panes, {glossy_receivers[1]}, large_lamp, expect_rays_alone);
    const Check check = [](const Scene& scene, const Environment* sky) {
        expect_equal(by_both(scene, sky, 1024), by_rays_alone(scene, sky, 1024));
    };
    for_each_pair({reflecting_panes[3]}, {glossy_receivers[1]}, large_lamp, check);
}

// Two rough bounces are noisier.
TEST(LightPaths, GlossyReflectionsThroughRoughGlassAreThoseOfRaysAlone) {
    const std::vector<NamedMaterial> rough = {reflecting_panes[1], reflecting_panes[3]};
    const Check check = [](const Scene& scene, const Environment* sky) {
        expect_equal(by_both(scene, sky, 2048), by_rays_alone(scene, sky, 2048));
    };
    for_each_pair(rough, {glossy_receivers[0]}, large_lamp, check);
}

// Light sampling alone makes the diffuse part, straight through all panes; rays the smooth coat.
TEST(LightPaths, DiffuseReflectionIsThatOfLightSamplingAlone) {
    const Check check = [](const Scene& scene, const Environment* sky) {
        expect_equal(by_both(scene, sky, 1024),
                     by_lights_alone(scene, sky) + by_rays_alone(scene, sky));
    };
    for_each_pair(clear_panes, diffuse_receivers, small_lamp, check);
    for_each_pair(reflecting_panes, diffuse_receivers, small_lamp, check);
}

// At the last bounce no ray follows the lobe: light sampling has all of it.
TEST(LightPaths, TheLastBounceIsLitThroughPanesByLightSamplingAlone) {
    const NamedMaterial& pane = reflecting_panes[0];
    const Scene scene = under_a_lamp(metal(0.5f), pane, small_lamp);
    const Estimate last =
        floor_radiance(scene, nullptr, 4096, [](Needs& needs) { needs.depth = 0; });
    expect_equal(last, by_lights_alone(scene, nullptr));
}

// Straight transmission is no bounce, so that rays get through panes wherever shadow rays do.
TEST(LightPaths, AnyNumberOfThinPanesLetsALobeThroughAtDepthOne) {
    SceneBuilder builder = floor_and_pane(metal(0.5f), clear_panes[2]);
    for (int i = 0; i < 3; ++i)
        draw(builder,
             quad_mesh({-3, 0.5f + 0.1f * static_cast<float>(i), -3}, {6, 0, 0}, {0, 0, 6}),
             glass(1, 0, 0));
    draw(builder, lamp_mesh(small_lamp), lamp_material());
    const Scene scene = builder.finish();
    const Estimate one =
        floor_radiance(scene, nullptr, 1024, [](Needs& needs) { needs.depth = 1; });
    expect_equal(one, by_both(scene, nullptr, 1024));
}

TEST(LightPaths, APaneOfIor1ChangesNothingHoweverRoughItIs) {
    Material clear = glass(1, 0.5f, 0);
    clear.base_color_factor = {1, 1, 1, 1};
    for (const NamedMaterial& receiver : {glossy_receivers[0], diffuse_receivers[0]}) {
        SCOPED_TRACE(receiver.name);
        const auto below = [&](const NamedMaterial& pane) {
            return by_both(under_a_lamp(receiver.material, pane, small_lamp), nullptr, 2048);
        };
        const Estimate open = below(clear_panes[0]), paned = below({"", clear});
        expect_equal(paned, open);
    }
}

}  // namespace
}  // namespace sightline
