// Inside or outside of a closed mesh, from points close to it by rays at its vertices and edges.
#include "intersect/methods/inside.h"
#include "core/parallel.h"
#include "intersect/methods/triangle_methods.h"
#include "lab/atlas/families.h"
#include "lab/atlas/mesh_making.h"

namespace sightline {
namespace {

/// A point; `direction` leads to a vertex or an edge of the mesh, where parity counts twice.
using Question = Ray;

class InsideTrial : public Trial {
  public:
    /// The mesh must be convex about the origin.
    InsideTrial(Mesh mesh, std::vector<Question> questions)
        : scene_(scene_of_meshes({std::move(mesh)})),
          questions_(std::move(questions)),
          referee_(scene_),
          truths_(questions_.size()) {
        parallel_for(size(), [this](size_t i) { truths_[i] = inside(questions_[i].origin); });
    }

    size_t size() const override { return questions_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const std::string& name : methods) {
            const auto found = std::make_shared<std::vector<uint8_t>>(size());
            std::function<bool(const Question&)> decide;
            if (name == "parity")
                decide = [this](const Question& q) { return inside_by_parity(mesh(), q.origin); };
            else if (name == "winding-number")
                decide = [this](const Question& q) {
                    return winding_number(mesh(), q.origin) > 0.5;
                };
            else
                decide = counting(name);
            result.push_back({name,
                              [this, found, decide] {
                                  for (size_t i = 0; i < size(); ++i)
                                      (*found)[i] = decide(questions_[i]);
                              },
                              [found](size_t i) {
                                  MethodAnswer answer;
                                  if ((*found)[i]) answer.hit.geometry = 0;
                                  return answer;
                              }});
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        if (bool(answer.hit) == hits(i)) return Verdict::same;
        if (!decidable(i)) return Verdict::undecidable;
        return hits(i) ? Verdict::missed : Verdict::false_hit;
    }
    Measures measure(size_t, const MethodAnswer&) const override { return no_measures; }
    bool hits(size_t i) const override { return truths_[i] != 0; }
    double condition(size_t) const override { return not_measured; }

    bool decidable(size_t i) const override {
        for (int axis = 0; axis < 3; ++axis)
            for (const float end : {-INFINITY, INFINITY}) {
                Vec3 moved = questions_[i].origin;
                moved[axis] = std::nextafter(moved[axis], end);
                if (inside(moved) != hits(i)) return false;
            }
        return true;
    }

  private:
    const Mesh& mesh() const { return scene_.meshes[0]; }

    /// The segment from the middle to the point crosses the convex mesh where the point is outside.
    bool inside(const Vec3& point) const { return !referee_.occluded({{0, 0, 0}, 0, point, 1}); }

    /// The lecture's way: an odd number of triangles hit.
    std::function<bool(const Question&)> counting(const std::string& method) const {
        std::vector<Corners<float>> triangles;
        for (const auto& [a, b, c] : mesh().triangles)
            triangles.push_back({mesh().positions[a], mesh().positions[b], mesh().positions[c]});
        const std::shared_ptr<TriangleSet> set = triangle_method(method).prepare(triangles);
        const auto count = static_cast<uint32_t>(triangles.size());
        return [set, count](const Question& q) {
            bool odd = false;
            for (uint32_t i = 0; i < count; ++i) odd ^= set->test(q, i).has_value();
            return odd;
        };
    }

    Scene scene_;
    std::vector<Question> questions_;
    Referee referee_;
    std::vector<uint8_t> truths_;
};

std::unique_ptr<Trial> close_points(const TrialRequest& request) {
    Dice dice(request.seed);
    Mesh mesh = closed_globe(8, random_rotation(dice));
    std::vector<Question> questions;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d near = aimed_point(mesh, Target::inside, dice);
        const double side = dice.sign(), distance = dice.between(0.5, 1) / request.knob;
        const Vec3d target = aimed_point(mesh, i % 2 ? Target::edge : Target::vertex, dice);
        questions.push_back(aimed_ray(near * (1 + side * distance), target, dice));
    }
    return std::make_unique<InsideTrial>(std::move(mesh), std::move(questions));
}

}  // namespace

void add_inside_families(std::vector<Family>& families) {
    std::vector<std::string> methods = {"parity", "winding-number"};
    for (const TriangleMethod& method : triangle_methods()) methods.push_back(method.name);
    families.push_back({"P1", "inside or outside close to a mesh, rays at its vertices and edges",
                        "size / distance", powers(10, 1, 6), methods, close_points});
}

}  // namespace sightline
