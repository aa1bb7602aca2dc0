#include "render/embree_choice.h"

#include "intersect/embree/build_quality.h"
#include "render/breakdown.h"
#include "render/knobs.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

constexpr const char* default_mode = "embree-default";

/// What decides the mode, in a line.
struct Mode {
    bool robust;
    std::string because;
};

bool has_triangles_only(const Scene& scene) {
    return std::all_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& i) {
        return i.baked && scene.groups[i.group].shapes.empty();
    });
}

Mode choose_mode(const Scene& scene, const Vec3& eye) {
    if (!has_triangles_only(scene))
        return {true, "shapes or instances, on which the default mode is not measured"};
    const TriangleKnobs knobs = find_triangle_knobs(scene, eye);
    if (knobs.shared_edges)
        return {true, fmt::format("triangles share edges; reach / edge is {:.3g}, and the default "
                                  "mode errs from {:.3g} on (atlas T1e)",
                                  knobs.reach_per_edge, wrong_from("T1e", default_mode))};
    const double limit = right_up_to("T2", default_mode);
    return {!(knobs.reach_per_width <= limit),
            fmt::format("no shared edges; reach / width is {:.3g}, and the default mode is right "
                        "up to {:.3g} (atlas T2)",
                        knobs.reach_per_width, limit)};
}

}  // namespace

void choose_embree(const Scene& scene, const RenderSettings& settings, Needs& needs) {
    const Mode mode = choose_mode(scene, settings.camera.to_world.translation());
    needs.embree.robust = mode.robust;
    needs.report.push_back({"embree_mode", mode.robust ? "robust" : "default", mode.because,
                            mode.robust ? "" : "the wider bounds of ROBUST's tests"});
    if (mode.robust) return;
    needs.embree.quality = choose_build_quality(scene);
    const bool splits = needs.embree.quality == BuildQuality::high;
    const BoxWaste waste = box_waste(scene);
    needs.report.push_back({"spatial_splits", splits ? "on" : "off",
                            fmt::format("a line enters {:.1f} triangles' boxes, {:.1f} times as "
                                        "large as flat ones",
                                        waste.boxes_entered, waste.ratio),
                            splits ? "" : "a build of ten times the length"});
}

}  // namespace sightline
