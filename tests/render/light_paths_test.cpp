// Each path of light is counted once: pictures by light sampling and secondary rays together are
// compared with those by one of the two alone, for pairs of light, pane and receiver.
#include "support/pictures.h"

#include <cmath>
#include <functional>
#include <numeric>

namespace sightline {
namespace {

// Sanitizers are twenty times slower. With them, few samples cover the code; the per cents are for
// the other builds.
constexpr bool sanitized = SIGHTLINE_SANITIZED;

// Independent estimates of one value.
using Pixels = std::array<double, 16>;

// A mean of pixels and its standard error.
struct Estimate {
    double mean = 0, error = 0;
};

double mean_of(const Pixels& pixels) {
    return std::accumulate(pixels.begin(), pixels.end(), 0.0) / pixels.size();
}

// The mean of `a` over that of `b`. Where both were sampled by the same random numbers, most of
// their noise is the same and cancels.
Estimate ratio(const Pixels& a, const Pixels& b) {
    const double mean = mean_of(a) / mean_of(b);
    double sum2 = 0;
    for (size_t i = 0; i < a.size(); ++i) sum2 += std::pow(a[i] - mean * b[i], 2);
    const auto n = static_cast<double>(a.size());
    return {mean, std::sqrt(sum2 / (n * (n - 1))) / mean_of(b)};
}

struct NamedMaterial {
    const char* name;
    Material material;
    bool is_solid = false;
};

Material metal(float roughness) {
    Material m;
    m.base_color_factor = {0.5f, 0.5f, 0.5f, 1};
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

// A floor below a pane. With a lamp of any brightness, here none, roulette drops no path for good,
// so that few paths make the right mean.
SceneBuilder floor_and_pane(const Material& floor, const NamedMaterial& pane) {
    SceneBuilder builder;
    builder.add_light(point_light({0, 9, 0}, 0));
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

using ChangeNeeds = std::function<void(Needs&)>;

Pixels render_pixels(const Scene& scene, const Environment* sky, RenderSettings settings,
                     const ChangeNeeds& change_needs) {
    // At the last bounce there are no rays alone: they see the lights that are sampled.
    settings.depth = 20;
    Needs needs = find_needs(scene, settings, sky != nullptr);
    change_needs(needs);
    const Film film = render_scene(scene, settings, sky, &needs).film;
    Pixels pixels;
    std::ranges::copy(film.find("G")->values, pixels.begin());
    return pixels;
}

// The radiance of one point of the floor, seen from below the pane.
Pixels floor_radiance(const Scene& scene, const Environment* sky, int samples,
                      const ChangeNeeds& change_needs) {
    RenderSettings settings =
        small_settings(look_at({0, 0.3f, 0.3f}, {0, 0, 0}, {0, 1, 0}, 1e-3f), samples, 4, 4);
    settings.cutoff = 0.1f;
    return render_pixels(scene, sky, settings, change_needs);
}

void no_light_samples(Needs& needs) { needs.area_lights = needs.environment_light = false; }

// What makes the paths, with a number of samples.
using Strategy = std::function<Pixels(const Scene&, const Environment*, int)>;

Pixels both(const Scene& scene, const Environment* sky, int samples) {
    return floor_radiance(scene, sky, samples, [](Needs&) {});
}

Pixels rays_alone(const Scene& scene, const Environment* sky, int samples) {
    return floor_radiance(scene, sky, samples, no_light_samples);
}

Pixels lights_alone(const Scene& scene, const Environment* sky, int samples) {
    return floor_radiance(scene, sky, samples, [](Needs& needs) {
        needs.secondary_rays = false;
        needs.depth = 0;
    });
}

Pixels lights_plus_rays(const Scene& scene, const Environment* sky, int samples) {
    Pixels sum = lights_alone(scene, sky, samples);
    const Pixels rays = rays_alone(scene, sky, samples);
    std::ranges::transform(sum, rays, sum.begin(), std::plus());
    return sum;
}

// Four times as many samples until the standard error is a quarter of a per cent.
Estimate refine(const std::function<Estimate(int samples)>& estimate) {
    for (int samples = sanitized ? 16 : 64;; samples *= 4) {
        const Estimate e = estimate(samples);
        if (sanitized || e.error <= 0.0024 * e.mean || samples >= 16384) return e;
    }
}

// One strategy's radiance relative to another's. Paths that both make are the same.
Estimate relative(const Strategy& got, const Strategy& right, const Scene& scene,
                  const Environment* sky) {
    return refine(
        [&](int samples) { return ratio(got(scene, sky, samples), right(scene, sky, samples)); });
}

// Two errors of a quarter of a per cent are a third of one together, so that 1 % is three of them.
void expect_equal(const Estimate& got, const Estimate& right) {
    ASSERT_GT(right.mean, 1e-3);
    const double error = std::hypot(got.error, right.error);
    if (!sanitized) {
        EXPECT_LT(error, 0.0034 * right.mean);
    }
    EXPECT_NEAR(got.mean, right.mean, std::max(sanitized ? 5 * error : 0, 0.01 * right.mean));
}

// Light sampling is less noisy with a small lamp, rays are with a large one.
constexpr float small_lamp = 1.8f, large_lamp = 5;

// Compares two strategies under a lamp and under a sky.
void expect_equal_below(const std::vector<NamedMaterial>& panes,
                        const std::vector<NamedMaterial>& receivers, float lamp_size,
                        const Strategy& got, const Strategy& right) {
    const Environment sky = half_sky();
    for (const NamedMaterial& pane : panes)
        for (const NamedMaterial& receiver : receivers) {
            SCOPED_TRACE(std::string(receiver.name) + " below a pane: " + pane.name);
            const Scene lit = under_a_lamp(receiver.material, pane, lamp_size);
            expect_equal(relative(got, right, lit, nullptr), {1, 0});
            const Scene open = floor_and_pane(receiver.material, pane).finish();
            expect_equal(relative(got, right, open, &sky), {1, 0});
        }
}

// The share of the light that a pane lets through to the receiver.
Estimate transmittance(const Scene& below, const Scene& open, const Environment* sky,
                       const Strategy& strategy) {
    return refine([&](int samples) {
        return ratio(strategy(below, sky, samples), strategy(open, sky, samples));
    });
}

// Below the first clear pane, strategies make the same radiance; the others take the same share of
// it. The paths to the pane are the same, so that shares need few samples.
void expect_equal_below_clear_panes(const std::vector<NamedMaterial>& receivers, float lamp_size,
                                    const Strategy& got, const Strategy& right) {
    const NamedMaterial& none = clear_panes[0];
    expect_equal_below({none}, receivers, lamp_size, got, right);
    const Environment sky = half_sky();
    for (size_t i = 1; i < clear_panes.size(); ++i)
        for (const NamedMaterial& receiver : receivers) {
            const NamedMaterial& pane = clear_panes[i];
            SCOPED_TRACE(std::string(receiver.name) + " below a pane: " + pane.name);
            const Scene lit = under_a_lamp(receiver.material, pane, lamp_size);
            const Scene lit_alone = under_a_lamp(receiver.material, none, lamp_size);
            expect_equal(transmittance(lit, lit_alone, nullptr, got),
                         transmittance(lit, lit_alone, nullptr, right));
            const Scene open = floor_and_pane(receiver.material, pane).finish();
            const Scene open_alone = floor_and_pane(receiver.material, none).finish();
            expect_equal(transmittance(open, open_alone, &sky, got),
                         transmittance(open, open_alone, &sky, right));
        }
}

// Each of the two alone makes every path of a rough lobe through these.
TEST(LightPaths, LightSamplingAndRaysAgreeThroughPanesThatReflectNothing) {
    expect_equal_below_clear_panes({glossy_receivers[0], glossy_receivers[2]}, small_lamp,
                                   lights_alone, rays_alone);
}

TEST(LightPaths, GlossyReflectionsThroughClearPanesAreThoseOfRaysAlone) {
    expect_equal_below_clear_panes(glossy_receivers, large_lamp, both, rays_alone);
}

TEST(LightPaths, MirrorsThroughGlassShowWhatRaysAloneDo) {
    expect_equal_below(reflecting_panes, {glossy_receivers[1]}, large_lamp, both, rays_alone);
}

TEST(LightPaths, GlossyReflectionsThroughRoughGlassAreThoseOfRaysAlone) {
    expect_equal_below({reflecting_panes[1], reflecting_panes[3]}, {glossy_receivers[0]},
                       large_lamp, both, rays_alone);
}

// Light sampling alone makes the diffuse part, straight through all panes; rays the smooth coat.
TEST(LightPaths, DiffuseReflectionIsThatOfLightSamplingAlone) {
    expect_equal_below_clear_panes(diffuse_receivers, small_lamp, both, lights_plus_rays);
    expect_equal_below(reflecting_panes, diffuse_receivers, small_lamp, both, lights_plus_rays);
}

// At the last bounce both strategies go straight through panes, whatever bends there.
TEST(LightPaths, TheLastBounceIsLitThroughPanesAsByLightSamplingAlone) {
    const Strategy last_bounce = [](const Scene& s, const Environment* sky, int samples) {
        return floor_radiance(s, sky, samples, [](Needs& needs) { needs.depth = 0; });
    };
    const Scene scene = under_a_lamp(metal(0.5f), reflecting_panes[3], small_lamp);
    expect_equal(relative(last_bounce, lights_alone, scene, nullptr), {1, 0});
}

// Light sampling alone would make a narrow lobe two hundred times too bright in one of as many
// samples.
TEST(LightPaths, NoSampleOfTheLastBounceIsMuchBrighterThanTheLight) {
    SceneBuilder builder;
    draw(builder, quad_mesh({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), metal(0.2f));
    const Scene scene = builder.finish();
    const Environment white = uniform_environment({1, 1, 1});
    RenderSettings settings =
        small_settings(look_at({0, 2, 2}, {0, 0, 0}, {0, 1, 0}, 0.5f), 1, 64, 64);
    settings.depth = 1;
    Needs needs = find_needs(scene, settings, true);
    needs.depth = 0;
    const Film film = render_scene(scene, settings, &white, &needs).film;
    EXPECT_LT(std::ranges::max(film.find("G")->values), 1.1f);
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
    const Strategy depth_one = [](const Scene& s, const Environment* sky, int samples) {
        return floor_radiance(s, sky, samples, [](Needs& needs) { needs.depth = 1; });
    };
    expect_equal(relative(depth_one, both, scene, nullptr), {1, 0});
}

TEST(LightPaths, APaneOfIor1ChangesNothingHoweverRoughItIs) {
    Material clear = glass(1, 0.5f, 0);
    clear.base_color_factor = {1, 1, 1, 1};
    for (const NamedMaterial& receiver : {glossy_receivers[0], diffuse_receivers[0]}) {
        SCOPED_TRACE(receiver.name);
        const Scene open = under_a_lamp(receiver.material, clear_panes[0], small_lamp);
        const Scene paned = under_a_lamp(receiver.material, {"", clear}, small_lamp);
        expect_equal(transmittance(paned, open, nullptr, both), {1, 0});
    }
}

// The pane reflects too little to be followed; it blurs the lamp behind it, which lights sample,
// too.
TEST(LightPaths, ALobeThatIsFollowedIsCountedOnceWhereTheOtherOneIsCut) {
    SceneBuilder builder;
    draw(builder, quad_mesh({-3, 0.4f, -3}, {6, 0, 0}, {0, 0, 6}), glass(1.5f, 0.5f, 0));
    draw(builder, lamp_mesh(small_lamp), lamp_material());
    const Scene scene = builder.finish();
    const auto blurred_lamp = [](const ChangeNeeds& change_needs) -> Strategy {
        return [=](const Scene& s, const Environment* sky, int samples) {
            RenderSettings settings =
                small_settings(look_at({0, 0, 0.1f}, {0, 1, 0}, {0, 0, 1}, 1e-3f), samples, 4, 4);
            settings.cutoff = 0.2f;
            return render_pixels(s, sky, settings, change_needs);
        };
    };
    expect_equal(
        relative(blurred_lamp([](Needs&) {}), blurred_lamp(no_light_samples), scene, nullptr),
        {1, 0});
}

}  // namespace
}  // namespace sightline
