#include "lab/atlas/families.h"

#include "intersect/methods/inside.h"
#include "intersect/methods/triangle_methods.h"
#include "lab/atlas/meshes.h"
#include "lab/atlas/scene_experiment.h"

namespace sightline {
namespace {

/// The origin is the point in question. The direction leads to a vertex or an edge of the mesh,
/// where several triangles may count as hit.
using Query = Ray;

template <class Inside>
Method<Query> inside_method(std::string name, Inside inside) {
    return case_method<Query>(std::move(name), inside,
                              [](const Query&, bool found) { return answer_of(found); });
}

/// The lecture's way: the point is inside if its ray hits an odd number of triangles.
Method<Query> counting_method(const TriangleMethod& method, const Mesh& mesh) {
    std::vector<Corners<float>> triangles;
    for (const auto& [a, b, c] : mesh.triangles)
        triangles.push_back({mesh.positions[a], mesh.positions[b], mesh.positions[c]});
    const std::shared_ptr<TriangleSet> set = method.prepare(triangles);
    const auto count = static_cast<uint32_t>(triangles.size());
    return inside_method(method.name, [set, count](const Query& q) {
        bool odd = false;
        for (uint32_t i = 0; i < count; ++i) odd ^= set->test(q, i).has_value();
        return odd;
    });
}

/// The mesh must be convex about the origin: the segment from there to a point crosses the mesh if
/// the point is outside.
bool is_inside(const Referee& mesh, const Vec3& point) {
    return !mesh.occluded({{0, 0, 0}, 0, point, 1});
}

bool is_decidable(const Referee& mesh, const Query& query, bool truth) {
    const auto coordinates = [](Vec3& p) { return std::array{&p.x, &p.y, &p.z}; };
    return std::ranges::all_of(ulp_neighbours(query.origin, coordinates),
                               [&](const Vec3& moved) { return is_inside(mesh, moved) == truth; });
}

Problem<Query, bool> inside_problem(const Mesh& convex_mesh) {
    const auto s = std::make_shared<const RefereedScene>(scene_of_meshes({convex_mesh}));
    const Mesh& mesh = s->scene.meshes[0];
    std::vector<Method<Query>> methods = {
        inside_method("parity",
                      [s, &mesh](const Query& q) { return inside_by_parity(mesh, q.origin); }),
        inside_method("winding-number",
                      [s, &mesh](const Query& q) { return winding_number(mesh, q.origin) > 0.5; })};
    for (const TriangleMethod& method : triangle_methods())
        methods.push_back(counting_method(method, mesh));
    return {.methods = std::move(methods),
            .solve = [s](const Query& q) { return is_inside(s->referee, q.origin); },
            .is_hit = std::identity(),
            .is_decidable = [s](const Query& q,
                                bool truth) { return is_decidable(s->referee, q, truth); }};
}

Experiment close_points(const ExperimentRequest& request) {
    Rng rng(request.seed);
    const Mesh mesh = closed_globe(8, random_rotation(rng));
    std::vector<Query> queries;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d surface = random_target(mesh, Target::inside, rng);
        const double side = rng.sign(), distance = rng.uniform(0.5, 1) / request.knob;
        const Vec3d target = random_target(mesh, i % 2 ? Target::edge : Target::vertex, rng);
        queries.push_back(aimed_ray(surface * (1 + side * distance), target, rng));
    }
    return make_experiment(inside_problem(mesh), std::move(queries));
}

}  // namespace

std::vector<Family> inside_families() {
    std::vector<std::string> methods = {"parity", "winding-number"};
    for (const std::string& name : names_of(triangle_methods())) methods.push_back(name);
    return {{"P1", "inside or outside close to a mesh, rays at its vertices and edges",
             "size / distance", powers(10, 1, 6), methods, close_points}};
}

}  // namespace sightline
