// Light between two parallel mirrors: a geometric series, and where renders end it.
#include "intersect/engines.h"
#include "lab/atlas/families.h"
#include "render/render.h"
#include "scene/scene_builder.h"

#include <algorithm>

namespace sightline {
namespace {

/// Two endless mirrors that glow, at y = 0 and y = 1, facing each other.
Scene facing_mirrors(double reflectance) {
    Material mirror;
    const auto r = static_cast<float>(reflectance);
    mirror.base_color_factor = {r, r, r, 1};
    mirror.roughness_factor = 0;
    mirror.emissive_factor = {1, 1, 1};
    mirror.double_sided = true;
    Shape plane;
    plane.kind = ShapeKind::plane;
    plane.size = {0, 0, 0};
    SceneBuilder builder;
    plane.material = builder.add_material(mirror);
    Shape upper = plane;
    upper.to_object.setTranslation(Vec3d(0, 1, 0));
    builder.add_instance(builder.add_group({}, {plane, upper}));
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

struct DepthPicture {
    std::vector<float> radiance;  ///< of each pixel, row by row
    std::vector<double> cosines;  ///< of the pixel's ray with the mirrors' normal
};

DepthPicture render_mirrors(const Scene& scene, const RenderSettings& settings, bool keep_rays) {
    Needs needs = find_needs(scene, settings, false);
    needs.embree.threads = 1;
    const auto engine = make_engine(scene, engine_name(needs), needs.embree);
    const RenderContext context(scene, settings, needs, *engine, nullptr, 1);
    const auto width = static_cast<size_t>(settings.width);
    DepthPicture picture;
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
        // Tiles are traced whole, also where they stick out of the picture.
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

std::string method_of(int depth) { return "render-depth-" + std::to_string(depth); }

/// t is the radiance; all rays hit. A pixel's truth is 1/(1 − R), R being the reflectance at its
/// ray's angle, the same at each mirror. Wrong is what lacks (or exceeds) more of it than the
/// cutoff, half a quantum of eight bits: what a picture may lack by ending the series.
class DepthTrial : public Trial {
  public:
    explicit DepthTrial(const TrialRequest& request)
        : scene_(facing_mirrors(1 - 1 / request.knob)), count_(request.rays) {
        const double r = static_cast<double>(scene_.materials[1].base_color_factor.x);
        for (const double c : render_mirrors(scene_, looking_down(count_, 0), true).cosines)
            reflectances_.push_back(r + (1 - r) * std::pow(1 - c, 5));
    }

    size_t size() const override { return count_; }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const int depth : depths) {
            const std::string name = method_of(depth);
            if (std::find(methods.begin(), methods.end(), name) == methods.end()) continue;
            const auto picture = std::make_shared<DepthPicture>();
            result.push_back({name,
                              [this, picture, settings = looking_down(count_, depth)] {
                                  *picture = render_mirrors(scene_, settings, false);
                              },
                              [picture](size_t i) {
                                  MethodAnswer answer;
                                  answer.hit.geometry = 0;
                                  answer.t = static_cast<double>(picture->radiance[i]);
                                  return answer;
                              }});
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        const double lacking = 1 - answer.t / truth(i);
        if (std::abs(lacking) <= cutoff) return Verdict::same;
        // An ulp of the reflectance moves the truth by as much.
        if (std::abs(lacking) <= cutoff + condition(i) * 0x1p-23) return Verdict::undecidable;
        return lacking < 0 ? Verdict::false_hit : Verdict::missed;
    }

    Measures measure(size_t i, const MethodAnswer& answer) const override {
        const double error = std::abs(answer.t - truth(i)) / truth(i);
        Measures measures = no_measures;
        measures[static_cast<size_t>(Measure::t_ulps)] = error * 0x1p23;
        measures[static_cast<size_t>(Measure::stability)] = error / (condition(i) * 0x1p-24);
        return measures;
    }

    bool hits(size_t) const override { return true; }
    bool decidable(size_t) const override { return true; }
    /// With respect to the reflectance and the emission.
    double condition(size_t i) const override { return truth(i); }

  private:
    static constexpr double cutoff = 0.5 / 255;

    double truth(size_t i) const { return 1 / (1 - reflectances_[i]); }

    Scene scene_;
    size_t count_;
    std::vector<double> reflectances_;
};

}  // namespace

void add_depth_family(std::vector<Family>& families) {
    std::vector<std::string> methods;
    for (const int depth : depths) methods.push_back(method_of(depth));
    families.push_back({"R4", "light between parallel mirrors: a series that renders end",
                        "1 / (1 - reflectance)", powers(2, 1, 6), methods,
                        [](const TrialRequest& r) { return std::make_unique<DepthTrial>(r); }});
}

}  // namespace sightline
