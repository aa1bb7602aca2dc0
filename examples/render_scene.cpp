// Makes a scene in code, renders it and writes it as ball.png and ball.exr into the current folder.
//
// A glossy red ball lies on a grey floor under a lamp and the neutral studio. The steps are those
// of `sightline render`: scene, settings, needs, intersector, context, render, output.
#include "image/write_image.h"
#include "intersect/engines.h"
#include "output/display.h"
#include "output/exr.h"
#include "render/render.h"
#include "scene/camera_fit.h"
#include "scene/mesh_makers.h"
#include "scene/scene_builder.h"
#include "shade/studio.h"

#include <fmt/format.h>

using namespace sightline;

namespace {

Scene ball_on_a_floor() {
    Material grey;  // names and defaults are glTF's
    grey.base_color_factor = {0.2f, 0.2f, 0.2f, 1};
    grey.metallic_factor = 0;
    Material red = grey;
    red.base_color_factor = {0.7f, 0.05f, 0.05f, 1};
    red.roughness_factor = 0.1f;
    Light lamp;
    lamp.position = {2, 4, 3};
    lamp.intensity = 12;  // candela

    SceneBuilder builder;
    const uint32_t floor = builder.add_mesh(quad_mesh({-5, 0, 5}, {10, 0, 0}, {0, 0, -10}),
                                            builder.add_material(grey));
    const uint32_t ball = builder.add_mesh(sphere_mesh(64, 128), builder.add_material(red));
    builder.add_instance(floor);  // its vertices are in world space
    Mat4 up;
    up.setTranslation(Vec3(0, 1, 0));
    builder.add_instance(ball, up);
    builder.add_light(lamp);
    builder.add_camera(look_at({0, 2, 6}, {0, 0.8f, 0}, {0, 1, 0}, pi / 5));
    return builder.finish();
}

}  // namespace

int main() {
    const Scene scene = ball_on_a_floor();
    const Environment studio(light_image("studio"), 0);
    RenderSettings settings;
    settings.width = 320;
    settings.height = 240;
    settings.samples = 16;
    settings.camera = scene.cameras[0];

    // Everything that this scene does not need is left out; `needs.report` gives the reasons.
    const Needs needs = find_needs(scene, settings, true);
    const auto intersector = make_engine(scene, engine_name(needs), needs.embree);
    const RenderContext context(scene, settings, needs, *intersector, &studio);

    // The rows of the picture arrive in bands, from the top. Here they are gathered in one film.
    Film film = blank_film(context.layers.layout, window_of(settings));
    const RenderResult result =
        render(context, [&](const Film& band) { copy_pixels(film, band, band.window); });

    write_exr("ball.exr", film, PictureMetadata());
    write_image("ball.png", display_picture(film, ToneMap::pbr_neutral, 0, false));
    fmt::print("ball.png, ball.exr: {} tiles, {}\n", result.tiles_done, intersector->description());
}
