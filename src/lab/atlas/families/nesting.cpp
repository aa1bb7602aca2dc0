#include "lab/atlas/families.h"

#include "exact/triangle.h"
#include "lab/atlas/meshes.h"
#include "scene/gltf/nodes.h"

namespace sightline {
namespace {

/// A triangle under a chain of nodes, the innermost first.
struct Nest {
    std::array<Vec3, 3> corners;
    std::vector<Mat4> nodes;
};

/// The triangle as a method transforms it to world space.
struct TransformedTriangle {
    std::array<Vec3, 3> corners;
    std::optional<Mat4> to_world;

    InstancedTriangle triangle() const {
        return {corners[0], corners[1], corners[2], to_world ? &*to_world : nullptr};
    }
};

/// The product of the matrices as the importer computes it.
Mat4d imported_matrix(const Nest& nest) {
    Document document;
    const size_t count = nest.nodes.size();
    document.nodes.resize(count);
    for (uint32_t i = 0; i < count; ++i) {
        GltfNode& node = document.nodes[i];
        node.has_matrix = true;
        node.matrix = Mat4d(nest.nodes[i]);
        if (i > 0) node.children = {i - 1};
        if (i + 1 < count) node.parent = i + 1;
    }
    return world_matrices(document)[0];
}

/// As the importer transforms meshes with one instance.
TransformedTriangle baked(const Nest& nest) {
    const Mat4d matrix = imported_matrix(nest);
    TransformedTriangle result{nest.corners, std::nullopt};
    for (Vec3& p : result.corners) p = Vec3(transform_point(Vec3d(p), matrix));
    return result;
}

/// As the importer transforms meshes with several instances.
TransformedTriangle instanced(const Nest& nest) {
    return {nest.corners, Mat4(imported_matrix(nest))};
}

TransformedTriangle by_float_product(const Nest& nest) {
    Mat4 matrix;
    for (const Mat4& node : nest.nodes) matrix = matrix * node;
    return {nest.corners, matrix};
}

TransformedTriangle by_float_steps(const Nest& nest) {
    TransformedTriangle result{nest.corners, std::nullopt};
    for (Vec3& p : result.corners)
        for (const Mat4& node : nest.nodes) p = transform_point(p, node);
    return result;
}

struct TransformMethod {
    const char* name;
    TransformedTriangle (*transform)(const Nest&);
};
constexpr TransformMethod transform_methods[] = {{"nodes-baked", baked},
                                                 {"nodes-instanced", instanced},
                                                 {"nodes-float-product", by_float_product},
                                                 {"nodes-float-steps", by_float_steps}};

struct NestCase {
    Ray ray;
    size_t nest;  ///< its index
};

/// Nests and the triangles that their exact products give.
struct Nests {
    std::vector<Nest> nests;
    std::vector<NestedTriangle> triangles;

    const NestedTriangle& triangle(const NestCase& c) const { return triangles[c.nest]; }
    bool is_hit(const NestCase& c, const Ray& ray) const {
        return triangle(c).crossing(ray) == Crossing::hit;
    }
};

/// The hit on a transformed triangle is computed exactly: only the transform is under test.
MethodAnswer exact_answer(const Ray& ray, const InstancedTriangle& triangle) {
    if (exact_crossing(ray, triangle) != Crossing::hit) return {};
    return answer_of(true, exact_hit(ray, triangle).t, 1);
}

/// Transforms each nest once, for all of its rays. Ray i belongs to nest i % nests.
Method<NestCase> nest_method(const TransformMethod& method, const std::shared_ptr<const Nests>& s) {
    return {method.name, [s, transform = method.transform](std::span<const NestCase> cases) {
                const auto answers = std::make_shared<std::vector<MethodAnswer>>(cases.size());
                const auto run = [s, transform, cases, answers] {
                    const size_t count = s->nests.size();
                    for (size_t nest = 0; nest < std::min(count, cases.size()); ++nest) {
                        const TransformedTriangle transformed = transform(s->nests[nest]);
                        for (size_t i = nest; i < cases.size(); i += count)
                            (*answers)[i] = exact_answer(cases[i].ray, transformed.triangle());
                    }
                };
                return MethodRun{run, [answers](size_t i) { return (*answers)[i]; }};
            }};
}

/// The inputs are the ray and the corners in world space; nesting excuses no further error.
SurfaceCrossing crossing_of(const NestedTriangle& triangle, const Ray& ray) {
    const ExactHit exact = triangle.hit(ray);
    SurfaceCrossing crossing(ray, exact.t, exact.normal);
    const auto corners = triangle.corners();
    const double weights[] = {1 - exact.u - exact.v, exact.u, exact.v};
    for (size_t k = 0; k < 3; ++k)
        crossing.input_sensitivity += std::abs(weights[k]) * absolute_dot(exact.normal, corners[k]);
    return crossing;
}

Problem<NestCase, bool> nesting_problem(const std::shared_ptr<const Nests>& s) {
    std::vector<Method<NestCase>> methods;
    for (const TransformMethod& method : transform_methods)
        methods.push_back(nest_method(method, s));
    return {.methods = std::move(methods),
            .solve = [s](const NestCase& c) { return s->is_hit(c, c.ray); },
            .is_hit = std::identity(),
            .is_decidable =
                [s](const NestCase& c, bool truth) {
                    return std::ranges::all_of(neighbours_of(c.ray), [&](const Ray& moved) {
                        return s->is_hit(c, moved) == truth;
                    });
                },
            .condition =
                [s](const NestCase& c, bool truth) {
                    return truth ? crossing_of(s->triangle(c), c.ray).condition() : not_measured;
                },
            .measure =
                [s](const NestCase& c, bool truth, const MethodAnswer& answer) {
                    return truth ? crossing_of(s->triangle(c), c.ray).measure(answer.t)
                                 : Measures();
                }};
}

/// A triangle rotated, scaled and translated `depth` times. Its middle stays close to the origin,
/// so that only the depth makes the nest difficult.
Nest random_nest(size_t depth, Rng& rng) {
    Nest nest;
    for (Vec3& p : nest.corners) p = Vec3(rng.direction());
    Vec3d middle(0, 0, 0);
    double stretch = 1;
    for (size_t i = 0; i < depth; ++i) {
        stretch = i % 2 == 0 ? rng.uniform(0.5, 2) : 1 / stretch;
        const Mat4d turn =
            random_rotation(rng) * scale_and_translate(Vec3d(stretch, stretch, stretch), {0, 0, 0});
        const Vec3d next = rng.in_cube(1);
        const Vec3d move = next - transform_point(middle, turn);
        nest.nodes.emplace_back(turn * scale_and_translate({1, 1, 1}, move));
        middle = transform_point(middle, Mat4d(nest.nodes.back()));
    }
    return nest;
}

/// A ray through a point next to an edge, eight ulps of 1 inside or outside of the triangle.
Ray beside_an_edge(const std::array<Vec3d, 3>& corners, Rng& rng) {
    const uint32_t first = rng.below(3);
    const Vec3d &a = corners[first], &b = corners[(first + 1) % 3], &c = corners[(first + 2) % 3];
    const Vec3d normal = normalize(cross(b - a, c - a)), inwards = normalize(cross(normal, b - a));
    const double gap = rng.sign() * 0x1p-20;
    const Vec3d target = a + (b - a) * rng.uniform(0.1, 0.9) + inwards * gap;
    const Vec3d back = normal * rng.sign() + rng.in_cube(0.7);
    return aimed_ray(target + back, target, rng);
}

Experiment nested(const ExperimentRequest& request) {
    Rng rng(request.seed);
    constexpr size_t nest_count = 32;
    const auto s = std::make_shared<Nests>();
    for (size_t i = 0; i < nest_count; ++i) {
        const Nest& nest =
            s->nests.emplace_back(random_nest(static_cast<size_t>(request.knob), rng));
        s->triangles.emplace_back(nest.corners, nest.nodes);
    }
    std::vector<NestCase> cases;
    for (size_t i = 0; i < request.rays; ++i) {
        const size_t nest = i % nest_count;
        cases.push_back({beside_an_edge(s->triangles[nest].corners(), rng), nest});
    }
    return make_experiment(nesting_problem(s), std::move(cases));
}

}  // namespace

std::vector<Family> nesting_families() {
    return {{"X2", "nested nodes, with rays beside the edges of their triangle", "depth of nesting",
             powers(4, 0, 4), names_of(transform_methods), nested}};
}

}  // namespace sightline
