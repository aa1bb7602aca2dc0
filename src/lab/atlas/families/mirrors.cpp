#include "lab/atlas/families.h"

#include "intersect/engines.h"
#include "render/render.h"
#include "scene/scene_builder.h"

#include <algorithm>

namespace sightline {
namespace {

/// Two endless mirrors that emit light, at y = 0 and y = 1, facing each other.
Scene facing_mirrors(float reflectance) {
    Material mirror;
    mirror.base_color_factor = {reflectance, reflectance, reflectance, 1};
    mirror.roughness_factor = 0;
    mirror.emissive_factor = {1, 1, 1};
    mirror.double_sided = true;
    Shape plane;
    plane.kind = ShapeKind::plane;
    plane.size = {0, 0, 0};
    SceneBuilder builder;
    plane.material = builder.add_material(mirror);
    Shape ceiling = plane;
    ceiling.to_object.setTranslation(Vec3d(0, 1, 0));
    builder.add_instance(builder.add_group({}, {plane, ceiling}));
    return builder.finish();
}

/// One sample a pixel, looking down from between the mirrors.
RenderSettings looking_down(size_t pixels, int depth) {
    RenderSettings settings;
    settings.width = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(pixels))));
    settings.height = settings.width;
    settings.samples = 1;
    settings.depth = depth;
    settings.background = Background::color;
    settings.camera.yfov = pi / 2;
    settings.camera.to_world = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0.5f, 0, 1};
    return settings;
}

struct MirrorPicture {
    std::vector<float> radiance;  ///< of each pixel, row by row
    std::vector<double> cosines;  ///< between each pixel's ray and the mirrors' normal
};

MirrorPicture render_mirrors(const Scene& scene, const RenderSettings& settings, bool keep_rays) {
    Needs needs = find_needs(scene, settings, false);
    needs.embree.threads = 1;
    const auto engine = make_engine(scene, engine_name(needs), needs.embree);
    const RenderContext context(scene, settings, needs, *engine, nullptr, 1);
    const auto width = static_cast<size_t>(settings.width);
    MirrorPicture picture;
    picture.radiance.resize(width * width);
    const BandSink keep = [&](const Film& band) {
        const std::vector<float>& values = band.find("G")->values;
        std::copy(values.begin(), values.end(),
                  picture.radiance.begin() +
                      static_cast<ptrdiff_t>(width * static_cast<size_t>(band.window.y0)));
    };
    const RenderResult result = render(context, keep, {.threads = 1, .record_rays = keep_rays});
    picture.cosines.resize(keep_rays ? width * width : 0);
    for (const RecordedRay& recorded : result.rays) {
        // Tiles are traced whole, including pixels outside of the picture.
        if (recorded.kind != RayKind::camera || recorded.x >= settings.width ||
            recorded.y >= settings.height)
            continue;
        const Vec3d direction = normalize(Vec3d(recorded.ray.direction));
        picture.cosines[width * static_cast<size_t>(recorded.y) + static_cast<size_t>(recorded.x)] =
            std::abs(direction.y);
    }
    return picture;
}

constexpr int depths[] = {2, 8, 32, 128, 512};
std::string method_name(int depth) { return "render-depth-" + std::to_string(depth); }

/// A pixel, by the reflectance at its ray's angle, which is the same at each mirror.
using Reflectance = double;

/// t is the radiance.
Method<Reflectance> render_method(const std::shared_ptr<const Scene>& scene, int depth) {
    return {method_name(depth), [scene, depth](std::span<const Reflectance> pixels) {
                const auto picture = std::make_shared<MirrorPicture>();
                return MethodRun{[scene, picture, settings = looking_down(pixels.size(), depth)] {
                                     *picture = render_mirrors(*scene, settings, false);
                                 },
                                 [picture](size_t i) {
                                     return answer_of(true,
                                                      static_cast<double>(picture->radiance[i]));
                                 }};
            }};
}

/// Half a quantum of eight bits: the fraction of its radiance that a pixel may lack because the
/// series ends.
constexpr double cutoff = 0.5 / 255;

/// Undecidable where an ulp of the reflectance makes the difference.
Verdict mirror_verdict(Reflectance, double truth, const MethodAnswer& answer) {
    const double lacking = 1 - answer.t / truth;
    if (std::abs(lacking) <= cutoff) return Verdict::same;
    if (std::abs(lacking) <= cutoff + truth * 0x1p-23) return Verdict::undecidable;
    return lacking < 0 ? Verdict::false_hit : Verdict::missed;
}

Measures mirror_measures(Reflectance, double truth, const MethodAnswer& answer) {
    const double error = std::abs(answer.t - truth) / truth;
    return {.t_ulps = error * 0x1p23, .stability = error / (truth * 0x1p-24)};
}

/// All rays hit. The truth is the sum of the geometric series, which is also its condition with
/// respect to the reflectance and the emission.
Problem<Reflectance, double> mirror_problem(const std::shared_ptr<const Scene>& scene) {
    std::vector<Method<Reflectance>> methods;
    for (const int depth : depths) methods.push_back(render_method(scene, depth));
    return {.methods = std::move(methods),
            .solve = [](Reflectance r) { return 1 / (1 - r); },
            .is_hit = [](double) { return true; },
            .condition = [](Reflectance, double truth) { return truth; },
            .measure = mirror_measures,
            .verdict = mirror_verdict};
}

Experiment between_mirrors(const ExperimentRequest& request) {
    const auto reflectance = static_cast<float>(1 - 1 / request.knob);
    const auto scene = std::make_shared<const Scene>(facing_mirrors(reflectance));
    const auto r = static_cast<double>(reflectance);
    std::vector<Reflectance> pixels;
    for (const double c : render_mirrors(*scene, looking_down(request.rays, 0), true).cosines)
        pixels.push_back(r + (1 - r) * std::pow(1 - c, 5));
    pixels.resize(request.rays);
    return make_experiment(mirror_problem(scene), std::move(pixels));
}

}  // namespace

std::vector<Family> mirror_families() {
    std::vector<std::string> methods;
    for (const int depth : depths) methods.push_back(method_name(depth));
    return {{"R4", "light between parallel mirrors: a series that renders truncate",
             "1 / (1 - reflectance)", powers(2, 1, 6), methods, between_mirrors}};
}

}  // namespace sightline
