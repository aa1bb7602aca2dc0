// Coincident surfaces: a ray that goes on visits each of them, in an order that does not depend
// on the engine.
#include "intersect/engines.h"
#include "intersect/few_shapes.h"
#include "support/pictures.h"

#include <set>

namespace sightline {
namespace {

// Embree's default mode, which loses rays at vertices, is not among them.
const std::vector<std::string> engines = {"embree", "few-shapes", "exact", "woop-double"};

Material unlit(const Vec4& color, AlphaMode mode = AlphaMode::opaque) {
    Material m;
    m.base_color_factor = color;
    m.alpha_mode = mode;
    m.unlit = true;
    m.double_sided = true;
    return m;
}

Material absorbing_solid(const Vec3& color) {
    Material m = absorbing_glass({1, 1, 1}, color);
    m.ior = 1;
    return m;
}

const Vec3 coincidence(0.6f, 0.4f, -0.5f);

RenderSettings towards_the_plane() {
    return small_settings(look_at(coincidence + Vec3(0.3f, 0.2f, 4), coincidence, {0, 1, 0}, 0.3f),
                          4, 24, 24);
}

Film render_by(const std::string& engine, const Scene& scene, const RenderSettings& settings) {
    const Needs needs = find_needs(scene, settings, false);
    const auto intersector = make_engine(scene, engine, needs.embree);
    const RenderContext context(scene, settings, needs, *intersector, nullptr);
    Film film = blank_film(context.layers.layout, window_of(settings));
    render(context, [&](const Film& band) { copy_pixels(film, band, band.window); });
    return film;
}

// Renders with all engines that support the scene and expects one colour everywhere.
void expect_color(const Scene& scene, const RenderSettings& settings, const Vec3& color,
                  float tolerance = 1e-5f) {
    for (const std::string& engine : engines) {
        if (engine == "few-shapes" && !has_few_shapes(scene)) continue;
        const Film film = render_by(engine, scene, settings);
        float worst = 0;
        for (int y = 0; y < settings.height; ++y)
            for (int x = 0; x < settings.width; ++x)
                worst = std::max(worst, max_abs_component(beauty_at(film, x, y) - color));
        EXPECT_LE(worst, tolerance) << engine;
    }
}

// A square around `coincidence` in a plane that no float holds, in `n` × `n` quads.
Mesh turned_square(int n, float size, bool flipped = false) {
    const Vec3 across = normalize(Vec3(1, 0.1f, 0.3f)), up = normalize(Vec3(-0.1f, 1, 0.07f));
    const float step = 2 * size / static_cast<float>(n);
    Mesh mesh;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            mesh.positions.push_back(coincidence + across * (step * static_cast<float>(i) - size) +
                                     up * (step * static_cast<float>(j) - size));
    const auto row = static_cast<uint32_t>(n) + 1;
    for (uint32_t i = 0; i + 1 < row; ++i)
        for (uint32_t j = 0; j + 1 < row; ++j) {
            const uint32_t a = i * row + j, b = a + row, c = b + 1, d = a + 1;
            if (flipped)
                mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {a, d, c}});
            else
                mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
        }
    mesh.positions.reserve(mesh.positions.size() + 1);
    return mesh;
}

TEST(CoincidentHits, AFlippedCopyMakesASingleSidedFaceVisibleFromBothSides) {
    Material leaf = unlit({0, 1, 0, 1});
    leaf.double_sided = false;
    for (const bool flipped_first : {false, true}) {
        SceneBuilder builder;
        const uint32_t m = builder.add_material(leaf);
        for (const bool flipped : {flipped_first, !flipped_first})
            builder.add_instance(builder.add_mesh(turned_square(1, 2, flipped), m));
        expect_color(builder.finish(), towards_the_plane(), {0, 1, 0});
    }
}

TEST(CoincidentHits, BehindACutOutCopyOfAnotherTessellationLiesTheWall) {
    for (const int n : {1, 3})
        for (const bool decal_first : {false, true}) {
            SceneBuilder builder;
            const auto decal = [&] {
                draw(builder, turned_square(n, 2), unlit({0, 0, 1, 0}, AlphaMode::mask));
            };
            if (decal_first) decal();
            draw(builder, turned_square(1, 2), unlit({1, 0, 0, 1}));
            if (!decal_first) decal();
            expect_color(builder.finish(), towards_the_plane(), {1, 0, 0});
        }
}

TEST(CoincidentHits, ABlendedDecalIsSeenOverTheWall) {
    for (const bool decal_first : {false, true}) {
        SceneBuilder builder;
        const auto decal = [&] {
            draw(builder, turned_square(3, 2), unlit({0, 0, 1, 0.25f}, AlphaMode::blend));
        };
        if (decal_first) decal();
        draw(builder, turned_square(1, 2), unlit({1, 0, 0, 1}));
        if (!decal_first) decal();
        expect_color(builder.finish(), towards_the_plane(), {0.75f, 0, 0.25f});
    }
}

TEST(CoincidentHits, TwoHalvesCoverThreeQuarters) {
    SceneBuilder builder;
    const Material half = unlit({0, 0, 0, 0.5f}, AlphaMode::blend);
    draw(builder, turned_square(1, 2), half);
    draw(builder, turned_square(3, 2), half);
    RenderSettings settings = towards_the_plane();
    settings.background_color = {1, 1, 1};
    expect_color(builder.finish(), settings, Vec3(0.25f));
}

TEST(CoincidentHits, EdgesBetweenTrianglesOfOneMeshAreNoSecondLayer) {
    // The view's axis runs through the diagonal of the square and through corners of its parts.
    for (const int n : {1, 2, 4}) {
        const Scene scene = scene_of(turned_square(n, 2), unlit({0, 0, 0, 0.5f}, AlphaMode::blend));
        RenderSettings settings = towards_the_plane();
        settings.camera = look_at(coincidence + Vec3(0, 0, 4), coincidence, {0, 1, 0}, 1e-7f);
        settings.width = settings.height = 5;
        settings.background_color = {1, 1, 1};
        expect_color(scene, settings, Vec3(0.5f));
    }
}

TEST(CoincidentHits, TwoHalvesLetAQuarterOfTheLightThrough) {
    SceneBuilder builder;
    const Material half = unlit({0, 0, 0, 0.5f}, AlphaMode::blend);
    draw(builder, quad_mesh({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), matte({1, 1, 1}));
    draw(builder, quad_mesh({-2, 1, 2}, {4, 0, 0}, {0, 0, -4}), half);
    draw(builder, quad_mesh({-2.5f, 1, 2}, {5, 0, 0}, {0, 0, -4}), half);
    Light sun;
    sun.kind = LightKind::directional;
    sun.direction = normalize(Vec3(0.1f, -1, 0.2f));
    sun.intensity = pi;
    builder.add_light(sun);
    const Scene scene = builder.finish();
    const RenderSettings settings =
        small_settings(look_at({0, 0.5f, 2}, {0, 0, 0}, {0, 1, 0}, 0.2f), 1, 16, 16);
    expect_color(scene, settings, Vec3(-0.25f * sun.direction.y));
}

// Each absorbs a colour over its thickness of 1; they share the face at z = 0.
TEST(CoincidentHits, SolidsThatShareAFaceAreBothEntered) {
    SceneBuilder builder;
    const auto slab = [&](float back, const Vec3& color) {
        const uint32_t m = builder.add_material(absorbing_solid(color));
        builder.add_instance(
            builder.add_mesh(quad_mesh({-8, -8, back + 1}, {16, 0, 0}, {0, 16, 0}), m));
        builder.add_instance(
            builder.add_mesh(quad_mesh({-8, -8, back}, {0, 16, 0}, {16, 0, 0}), m));
    };
    slab(0, {0.5f, 1, 1});
    slab(-1, {1, 0.5f, 1});
    RenderSettings settings = towards_the_plane();
    settings.camera = look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 1e-3f);
    settings.background_color = {1, 1, 1};
    expect_color(builder.finish(), settings, {0.5f, 0.5f, 1}, 1e-3f);
}

TEST(CoincidentHits, AllEnginesFindAllHitsOfASegment) {
    const Scene scene = [] {
        SceneBuilder builder;
        draw(builder, turned_square(1, 2), unlit({1, 1, 1, 1}));
        draw(builder, turned_square(1, 2, true), unlit({1, 1, 1, 0}, AlphaMode::mask));
        const uint32_t square = builder.add_mesh(turned_square(1, 2));
        Mat4 aside;
        aside.setTranslation(Vec3(0, 0, -1));
        builder.add_instance(square, aside);
        builder.add_instance(square, Mat4());
        return builder.finish();
    }();
    const Ray rays[] = {{{0.9f, 0.6f, 3.5f}, 0, {0, 0, -1}, 4.5f}, {{9, 9, 4}, 0, {0, 0, -1}, 9}};
    for (const std::string& name : engines) {
        const auto engine = make_engine(scene, name);
        const auto count = [&](Visible visible) {
            std::vector<RayHit> hits;
            engine->all(rays, hits, visible);
            std::set<std::array<uint32_t, 4>> ids;
            for (const auto& [ray, hit] : hits)
                ids.insert({ray, hit.instance, hit.geometry, hit.primitive});
            return ids.size();
        };
        EXPECT_EQ(count(Visible::all), 3u) << name;
        EXPECT_EQ(count(Visible::translucent), 1u) << name;
        EXPECT_EQ(count(Visible::opaque), 2u) << name;
    }
}

}  // namespace
}  // namespace sightline
