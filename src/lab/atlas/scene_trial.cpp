#include "lab/atlas/scene_trial.h"

#include "core/parallel.h"
#include "exact/triangle.h"
#include "intersect/engines.h"

namespace sightline {
namespace {

/// What one engine said.
struct Run {
    std::unique_ptr<Intersector> engine;
    std::vector<Hit> hits;
};

class SceneTrial : public Trial {
  public:
    SceneTrial(SceneQueries queries, EmbreeOptions embree)
        : scene_(std::move(queries.scene)),
          rays_(std::move(queries.rays)),
          coherence_(queries.coherent ? Coherence::coherent : Coherence::incoherent),
          embree_(std::move(embree)),
          referee_(scene_),
          truths_(rays_.size()),
          points_(rays_.size()),
          verdicts_(rays_.size()) {
        parallel_for(rays_.size(), [this](size_t i) {
            truths_[i] = referee_.closest(rays_[i]);
            if (!truths_[i].nearest.empty()) points_[i] = meeting_point(i, truths_[i].nearest[0]);
        });
    }

    size_t size() const override { return rays_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const std::string& method : methods) {
            const auto run = std::make_shared<Run>(
                Run{make_engine(scene_, method, embree_), std::vector<Hit>(rays_.size())});
            result.push_back({method,
                              [this, run] { run->engine->closest(rays_, run->hits, coherence_); },
                              [run](size_t i) {
                                  const Hit& hit = run->hits[i];
                                  return MethodAnswer{hit, static_cast<double>(hit.t), hit ? 1 : 0};
                              }});
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        const SurfaceId surface = surface_of(answer.hit);
        for (const auto& [known, verdict] : verdicts_[i])
            if (known == surface) return verdict;
        const Verdict verdict = referee_.judge(rays_[i], truths_[i], answer.hit);
        verdicts_[i].emplace_back(surface, verdict);
        return verdict;
    }

    Measures measure(size_t i, const MethodAnswer& answer) const override {
        if (!answer.hit) return no_measures;
        const SurfaceId surface = surface_of(answer.hit);
        const MeetingPoint point =
            surface == truths_[i].nearest[0] ? points_[i] : meeting_point(i, surface);
        Measures measures = point.errors(answer.t);
        measures[static_cast<size_t>(Measure::normal_angle)] =
            angle_between(point.normal, Vec3d(float_normal(surface)));
        return measures;
    }

    bool hits(size_t i) const override { return !truths_[i].nearest.empty(); }
    double condition(size_t i) const override { return points_[i].condition(); }

    bool decidable(size_t i) const override {
        return std::ranges::none_of(neighbours_of(rays_[i]), [&](const Ray& moved) {
            return has_exact_answer(moved) && referee_.closest(moved).nearest != truths_[i].nearest;
        });
    }

  private:
    InstancedTriangle triangle(const SurfaceId& id) const {
        const Mesh& mesh = scene_.meshes[id.geometry];
        const auto& [a, b, c] = mesh.triangles[id.primitive];
        const Instance& instance = scene_.instances[id.instance];
        return {mesh.positions[a], mesh.positions[b], mesh.positions[c],
                instance.baked ? nullptr : &instance.object_to_world};
    }

    /// As shading would compute it.
    Vec3 float_normal(const SurfaceId& id) const {
        InstancedTriangle p = triangle(id);
        if (p.to_world != nullptr)
            for (Vec3* v : {&p.a, &p.b, &p.c}) *v = transform_point(*v, *p.to_world);
        return cross(p.b - p.a, p.c - p.a);
    }

    MeetingPoint meeting_point(size_t i, const SurfaceId& id) const {
        const InstancedTriangle p = triangle(id);
        const ExactHit exact = exact_hit(rays_[i], p);
        MeetingPoint point(rays_[i], exact.t, exact.normal);
        const double weights[] = {1 - exact.u - exact.v, exact.u, exact.v};
        const Vec3 vertices[] = {p.a, p.b, p.c};
        for (int k = 0; k < 3; ++k)
            point.reach += std::abs(weights[k]) * vertex_reach(vertices[k], exact.normal, p);
        return point;
    }

    /// Σ |∂height/∂x||x| over a vertex' coordinates, or over those and the matrix' elements.
    static double vertex_reach(const Vec3& vertex, const Vec3d& normal,
                               const InstancedTriangle& p) {
        if (p.to_world == nullptr) return absolute_dot(normal, Vec3d(vertex));
        const Mat4d m(*p.to_world);
        double sum = absolute_dot(normal, Vec3d(m[3][0], m[3][1], m[3][2]));
        for (int i = 0; i < 3; ++i)
            sum += 2 * std::abs(static_cast<double>(vertex[i])) *
                   absolute_dot(normal, Vec3d(m[i][0], m[i][1], m[i][2]));
        return sum;
    }

    Scene scene_;
    std::vector<Ray> rays_;
    Coherence coherence_;
    EmbreeOptions embree_;
    Referee referee_;
    std::vector<Truth> truths_;
    std::vector<MeetingPoint> points_;
    /// Verdicts on answers that were given before: methods often err alike.
    mutable std::vector<std::vector<std::pair<SurfaceId, Verdict>>> verdicts_;
};

}  // namespace

std::vector<std::string> scene_trial_methods() {
    std::vector<std::string> names = engine_names();
    std::erase(names, "few-shapes");  // the scenes are too large for it
    return names;
}

std::unique_ptr<Trial> make_scene_trial(SceneQueries queries, const EmbreeOptions& embree) {
    return std::make_unique<SceneTrial>(std::move(queries), embree);
}

}  // namespace sightline
