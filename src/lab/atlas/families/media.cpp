#include "lab/atlas/families.h"

#include "intersect/engines.h"
#include "intersect/methods/inside.h"
#include "lab/atlas/meshes.h"
#include "lab/atlas/scene_experiment.h"
#include "scene/scene_builder.h"
#include "shade/media.h"
#include "shade/surface.h"

namespace sightline {
namespace {

/// The media that contain a point, as bits. The index of a bit is that of the mesh, and one less
/// than that of the material.
using MediaSet = int;
constexpr MediaSet glass = 1, liquid = 2;

/// A segment, t ≤ 1, from the air to the point in question.
using Segment = Ray;

Vec3 end_of(const Segment& segment) { return segment.origin + segment.direction; }

/// A shell of glass with radii 1 and 2, and the liquid in it.
struct Vessel {
    Mesh outer, inner, content;
};

/// Materials 1 and 2. The shell's inner side has the opposite winding of its content's surface.
Scene scene_of(const Vessel& vessel) {
    Mesh shell = vessel.outer, filling = vessel.content;
    const auto first = static_cast<uint32_t>(shell.positions.size());
    shell.positions.insert(shell.positions.end(), vessel.inner.positions.begin(),
                           vessel.inner.positions.end());
    for (const auto& [a, b, c] : vessel.inner.triangles)
        shell.triangles.push_back({first + a, first + c, first + b});
    SceneBuilder builder;
    shell.material = builder.add_material({});
    filling.material = builder.add_material({});
    builder.add_instance(builder.add_group({std::move(shell), std::move(filling)}));
    return builder.finish();
}

/// The rest of a segment behind a hit.
using Continue = Ray (*)(const Surface&, const Ray&, const Hit&);

/// As renders continue.
Ray from_bound(const Surface& surface, const Ray& ray, const Hit& hit) {
    return spawn_ray(surface, ray.direction, ray.tfar - hit.t);
}
Ray from_t(const Surface&, const Ray& ray, const Hit& hit) {
    Ray rest = ray;
    rest.tnear = hit.t;
    return rest;
}
Ray from_epsilon(const Surface&, const Ray& ray, const Hit& hit) {
    Ray rest = ray;
    rest.tnear = hit.t + 1e-4f;
    return rest;
}

struct WalkMethod {
    const char* name;
    const char* engine;
    Continue continue_behind;
};
constexpr WalkMethod walks[] = {{"walk-rendered", "embree", from_bound},
                                {"walk-exact-tree", "exact", from_bound},
                                {"walk-tnear", "exact", from_t},
                                {"walk-tnear-1e-4", "exact", from_epsilon}};

/// What methods work with; neither copied nor moved, since its members point to each other.
struct VesselScene {
    const Scene scene;
    const Surfaces surfaces{scene, false, 1};
    const RefereedScene outer, inner, content;

    explicit VesselScene(const Vessel& vessel)
        : scene(scene_of(vessel)),
          outer(scene_of_meshes({vessel.outer})),
          inner(scene_of_meshes({vessel.inner})),
          content(scene_of_meshes({vessel.content})) {}

    /// Each part is convex about the origin: the segment from there to a point crosses the part's
    /// surface if the point is outside.
    MediaSet media_at(const Vec3& point) const {
        const auto holds = [&](const RefereedScene& part) {
            return !part.referee.occluded({{0, 0, 0}, 0, point, 1});
        };
        return (holds(outer) && !holds(inner) ? glass : 0) | (holds(content) ? liquid : 0);
    }
};

template <class Solve>
Method<Segment> media_method(std::string name, Solve solve) {
    return case_method<Segment>(std::move(name), solve, [](const Segment&, MediaSet media) {
        return answer_of(media != 0, 0, media);
    });
}

/// Tests the end point against each mesh, independently of the surfaces on the way.
template <class Inside>
Method<Segment> point_method(std::string name, const std::shared_ptr<const VesselScene>& s,
                             Inside inside) {
    return media_method(std::move(name), [s, inside](const Segment& segment) {
        MediaSet media = 0;
        for (size_t k = 0; k < 2; ++k)
            if (inside(s->scene.meshes[k], end_of(segment))) media |= 1 << k;
        return media;
    });
}

/// Goes from hit to hit and keeps a list of the media entered, as renders do.
MediaSet walk(const VesselScene& s, const Intersector& engine, Continue continue_behind,
              const Segment& segment) {
    MediumStack media;
    Ray ray = segment;
    for (int step = 0; step < 32 && ray.tnear < ray.tfar; ++step) {
        Hit hit;
        engine.closest({&ray, 1}, {&hit, 1}, Coherence::incoherent);
        if (!hit) break;
        const Surface surface = s.surfaces.at(ray, hit, 0);
        surface.front ? media.enter(surface.material) : media.leave(surface.material);
        ray = continue_behind(surface, ray, hit);
    }
    MediaSet result = 0;
    for (uint16_t i = 0; i < media.count; ++i) result |= 1 << (media.material[i] - 1);
    return result;
}

Method<Segment> walk_method(const WalkMethod& method, const std::shared_ptr<const VesselScene>& s) {
    return {method.name, [method, s](std::span<const Segment> segments) {
                const std::shared_ptr<Intersector> engine = make_engine(s->scene, method.engine);
                return media_method(method.name,
                                    [s, engine, method](const Segment& segment) {
                                        return walk(*s, *engine, method.continue_behind, segment);
                                    })
                    .prepare(segments);
            }};
}

/// A medium that lacks counts as missed, one too many as a false hit.
Verdict media_verdict(const Segment&, MediaSet truth, const MethodAnswer& answer) {
    const MediaSet lost = truth & ~answer.count, added = answer.count & ~truth;
    if (lost != 0) return added != 0 ? Verdict::wrong_primitive : Verdict::missed;
    return added != 0 ? Verdict::false_hit : Verdict::same;
}

/// All cases are decidable: the points are far from all surfaces.
Problem<Segment, MediaSet> media_problem(const Vessel& vessel) {
    const auto s = std::make_shared<const VesselScene>(vessel);
    std::vector<Method<Segment>> methods = {
        point_method("parity", s, inside_by_parity),
        point_method("winding-number", s,
                     [](const Mesh& m, const Vec3& p) { return winding_number(m, p) > 0.5; })};
    for (const WalkMethod& method : walks) methods.push_back(walk_method(method, s));
    return {.methods = std::move(methods),
            .solve = [s](const Segment& segment) { return s->media_at(end_of(segment)); },
            .is_hit = [](MediaSet truth) { return truth != 0; },
            .verdict = media_verdict};
}

/// The liquid's radius is larger than the hole's by `change`; 1e-9 does not change its floats. Rays
/// pass vertices, edges and other points of the hole on their way to points in the liquid, in the
/// glass behind it and in the air behind that.
Experiment touching_media(const ExperimentRequest& request, double change) {
    Rng rng(request.seed);
    const Mat4d turn = random_rotation(rng);
    const auto globe = [&](double radius) {
        return closed_globe(8,
                            scale_and_translate(Vec3d(radius, radius, radius), {0, 0, 0}) * turn);
    };
    const Vessel vessel{globe(2), globe(1), globe(1 + change)};
    std::vector<Segment> segments;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d gate = random_target(vessel.inner, static_cast<Target>(i % 3), rng);
        const double distances[] = {0, 1.35, 4};
        const Vec3d end = gate * -distances[i / 3 % 3] + rng.in_cube(0.15);
        const Vec3 from(gate * 6 - end * 5), to(end);
        segments.push_back({from, 0, to - from, 1});
    }
    return make_experiment(media_problem(vessel), std::move(segments));
}

}  // namespace

std::vector<Family> media_families() {
    std::vector<std::string> methods = {"parity", "winding-number"};
    for (const WalkMethod& method : walks) methods.push_back(method.name);
    return {{"R3g", "the medium behind glass and liquid with a gap between them", "size / gap",
             powers(10, 1, 9, 2), methods,
             [](const ExperimentRequest& r) { return touching_media(r, -1 / r.knob); }},
            {"R3o", "the medium behind glass and liquid that overlap", "size / overlap",
             powers(10, 1, 9, 2), methods,
             [](const ExperimentRequest& r) { return touching_media(r, 1 / r.knob); }}};
}

}  // namespace sightline
