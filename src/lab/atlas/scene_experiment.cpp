#include "lab/atlas/scene_experiment.h"

#include "exact/triangle.h"
#include "intersect/engines.h"
#include "lab/compare/answers.h"
#include "lab/compare/triangle_file.h"

namespace sightline {
namespace {

struct SceneTruth {
    Truth exact;
    SurfaceCrossing crossing;  ///< of the first of the nearest surfaces
    /// Verdicts on answers so far: methods often make the same errors.
    mutable std::vector<std::pair<Hit, Verdict>> verdicts = {};
};

std::vector<RecordedRay> recorded(std::span<const Ray> rays) {
    std::vector<RecordedRay> result;
    for (const Ray& ray : rays) result.push_back({ray, RayKind::camera});
    return result;
}

SurfaceCrossing crossing_of(const Scene& scene, const Ray& ray, const SurfaceId& id) {
    const InstancedTriangle triangle = instanced_triangle(scene, id);
    const ExactHit exact = exact_hit(ray, triangle);
    SurfaceCrossing crossing(ray, exact.t, exact.normal);
    crossing.input_sensitivity = absolute_dot(
        exact.normal, movement_by_own_size(ray, triangle, {exact.t, exact.u, exact.v}));
    return crossing;
}

/// The normal as shading computes it.
Vec3 float_normal(const Scene& scene, const SurfaceId& id) {
    InstancedTriangle t = instanced_triangle(scene, id);
    if (t.to_world != nullptr)
        for (Vec3* vertex : {&t.a, &t.b, &t.c}) *vertex = transform_point(*vertex, *t.to_world);
    return cross(t.b - t.a, t.c - t.a);
}

SceneTruth solve(const RefereedScene& s, const Ray& ray) {
    SceneTruth truth{s.referee.closest(ray), {}};
    if (!truth.exact.nearest.empty())
        truth.crossing = crossing_of(s.scene, ray, truth.exact.nearest[0]);
    return truth;
}

bool is_same(const Hit& a, const Hit& b) {
    return surface_of(a) == surface_of(b) && a.t == b.t && a.u == b.u && a.v == b.v;
}

Verdict verdict_on(const RefereedScene& s, const Ray& ray, const SceneTruth& truth,
                   const Hit& hit) {
    for (const auto& [known, verdict] : truth.verdicts)
        if (is_same(known, hit)) return verdict;
    const Verdict verdict = s.referee.judge(ray, truth.exact, hit);
    truth.verdicts.emplace_back(hit, verdict);
    return verdict;
}

Measures measures_of(const Scene& scene, const Ray& ray, const SceneTruth& truth,
                     const MethodAnswer& answer) {
    if (!answer.hit) return {};
    const SurfaceId surface = surface_of(answer.hit);
    const SurfaceCrossing crossing =
        surface == truth.exact.nearest[0] ? truth.crossing : crossing_of(scene, ray, surface);
    return crossing.measure(answer.t, Vec3d(float_normal(scene, surface)));
}

bool is_decidable(const Referee& referee, const Ray& ray, const SceneTruth& truth) {
    return std::ranges::none_of(neighbours_of(ray), [&](const Ray& moved) {
        return has_exact_answer(moved) && referee.closest(moved).nearest != truth.exact.nearest;
    });
}

MethodRun run_engine(std::unique_ptr<Intersector> built, std::span<const Ray> rays) {
    struct State {
        std::unique_ptr<Intersector> engine;
        std::vector<Hit> hits;
    };
    const auto state =
        std::make_shared<State>(State{std::move(built), std::vector<Hit>(rays.size())});
    return {[state, rays] { state->engine->closest(rays, state->hits, Coherence::coherent); },
            [state](size_t i) {
                const Hit& hit = state->hits[i];
                return MethodAnswer{hit, static_cast<double>(hit.t), hit ? 1 : 0};
            }};
}

}  // namespace

std::vector<std::string> scene_methods() {
    std::vector<std::string> names = engine_names();
    std::erase(names, "few-shapes");  // limited to eight primitives
    return names;
}

Experiment make_scene_experiment(SceneRays input, const EmbreeOptions& embree) {
    const auto s = std::make_shared<const RefereedScene>(std::move(input.scene));
    Problem<Ray, SceneTruth> problem{
        .methods = {},
        .solve = [s](const Ray& ray) { return solve(*s, ray); },
        .is_hit = [](const SceneTruth& truth) { return !truth.exact.nearest.empty(); },
        .is_decidable =
            [s](const Ray& ray, const SceneTruth& truth) {
                return is_decidable(s->referee, ray, truth);
            },
        .condition = [](const Ray&, const SceneTruth& truth) { return truth.crossing.condition(); },
        .measure =
            [s](const Ray& ray, const SceneTruth& truth, const MethodAnswer& answer) {
                return measures_of(s->scene, ray, truth, answer);
            },
        .verdict =
            [s](const Ray& ray, const SceneTruth& truth, const MethodAnswer& answer) {
                return verdict_on(*s, ray, truth, answer.hit);
            }};
    for (const std::string& name : scene_methods())
        problem.methods.push_back({name, [s, name, embree](std::span<const Ray> rays) {
                                       return run_engine(make_engine(s->scene, name, embree), rays);
                                   }});
    const auto rays = std::make_shared<const std::vector<Ray>>(input.rays);
    Experiment experiment = make_experiment(std::move(problem), std::move(input.rays));
    experiment.dump = [s, rays](const std::string& stem) {
        write_triangles(stem + ".triangles", s->scene);
        write_rays(stem + ".rays", recorded(*rays), s->scene);
    };
    experiment.replay = [s, rays](const std::string& name, const std::string& path) {
        RayFile file;
        file.rays = recorded(*rays);
        file.hash = hash_rays(file.rays);
        return run_engine(read_answers(name, path, s->scene, file).intersector, *rays);
    };
    return experiment;
}

}  // namespace sightline
