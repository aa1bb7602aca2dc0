// Nodes nested in nodes: what is left of a triangle's place when their matrices are multiplied.
#include "core/parallel.h"
#include "exact/triangle.h"
#include "lab/atlas/families.h"
#include "lab/atlas/mesh_making.h"
#include "scene/gltf/nodes.h"

#include <algorithm>

namespace sightline {
namespace {

/// A triangle under a chain of nodes, the innermost first.
struct Nest {
    std::array<Vec3, 3> corners;
    std::vector<Mat4> nodes;
};

/// The triangle as a method places it in the world.
struct NestPlacement {
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

/// As renders place what stands once.
NestPlacement baked(const Nest& nest) {
    const Mat4d matrix = imported_matrix(nest);
    NestPlacement placed{nest.corners, std::nullopt};
    for (Vec3& p : placed.corners) p = Vec3(transform_point(Vec3d(p), matrix));
    return placed;
}

/// As renders place what stands several times.
NestPlacement instanced(const Nest& nest) { return {nest.corners, Mat4(imported_matrix(nest))}; }

NestPlacement by_float_product(const Nest& nest) {
    Mat4 matrix;
    for (const Mat4& node : nest.nodes) matrix = matrix * node;
    return {nest.corners, matrix};
}

NestPlacement by_float_steps(const Nest& nest) {
    NestPlacement placed{nest.corners, std::nullopt};
    for (Vec3& p : placed.corners)
        for (const Mat4& node : nest.nodes) p = transform_point(p, node);
    return placed;
}

struct Placing {
    const char* name;
    NestPlacement (*place)(const Nest&);
};
constexpr Placing placings[] = {{"nodes-baked", baked},
                                {"nodes-instanced", instanced},
                                {"nodes-float-product", by_float_product},
                                {"nodes-float-steps", by_float_steps}};

/// Where the ray meets the triangle as it was placed is decided exactly: only the place is in
/// question.
MethodAnswer answer_of(const Ray& ray, const InstancedTriangle& triangle) {
    MethodAnswer answer;
    if (exact_crossing(ray, triangle) != Crossing::hit) return answer;
    answer.hit.geometry = 0;
    answer.t = exact_hit(ray, triangle).t;
    answer.count = 1;
    return answer;
}

class NestingTrial : public Trial {
  public:
    /// Ray i is for nest i % nests.
    NestingTrial(std::vector<Nest> nests, std::vector<NestedTriangle> exact, std::vector<Ray> rays)
        : nests_(std::move(nests)),
          exact_(std::move(exact)),
          rays_(std::move(rays)),
          hits_(rays_.size()) {
        parallel_for(size(), [this](size_t i) { hits_[i] = is_hit(i, rays_[i]); });
    }

    size_t size() const override { return rays_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const Placing& placing : placings) {
            if (std::find(methods.begin(), methods.end(), placing.name) == methods.end()) continue;
            const auto answers = std::make_shared<std::vector<MethodAnswer>>(size());
            result.push_back({placing.name,
                              [this, answers, place = placing.place] {
                                  for (size_t i = 0; i < std::min(nests_.size(), size()); ++i) {
                                      const NestPlacement placed = place(nests_[i]);
                                      for (size_t k = i; k < size(); k += nests_.size())
                                          (*answers)[k] = answer_of(rays_[k], placed.triangle());
                                  }
                              },
                              [answers](size_t i) { return (*answers)[i]; }});
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        if (bool(answer.hit) == hits(i)) return Verdict::same;
        if (!decidable(i)) return Verdict::undecidable;
        return hits(i) ? Verdict::missed : Verdict::false_hit;
    }

    Measures measure(size_t i, const MethodAnswer& answer) const override {
        return hits(i) ? meeting_point(i).errors(answer.t) : no_measures;
    }
    bool hits(size_t i) const override { return hits_[i] != 0; }
    double condition(size_t i) const override {
        return hits(i) ? meeting_point(i).condition() : not_measured;
    }

    bool decidable(size_t i) const override {
        return std::ranges::all_of(neighbours_of(rays_[i]),
                                   [&](const Ray& moved) { return is_hit(i, moved) == hits(i); });
    }

  private:
    const NestedTriangle& triangle(size_t i) const { return exact_[i % exact_.size()]; }
    bool is_hit(size_t i, const Ray& ray) const {
        return triangle(i).crossing(ray) == Crossing::hit;
    }

    /// Its inputs are the ray and the corners in the world: nesting has no other excuse.
    MeetingPoint meeting_point(size_t i) const {
        const ExactHit exact = triangle(i).hit(rays_[i]);
        MeetingPoint point(rays_[i], exact.t, exact.normal);
        const auto corners = triangle(i).corners();
        const double weights[] = {1 - exact.u - exact.v, exact.u, exact.v};
        for (size_t k = 0; k < 3; ++k)
            point.reach += std::abs(weights[k]) * absolute_dot(exact.normal, corners[k]);
        return point;
    }

    std::vector<Nest> nests_;
    std::vector<NestedTriangle> exact_;
    std::vector<Ray> rays_;
    std::vector<uint8_t> hits_;
};

/// Turned, stretched and moved `depth` times, with its middle never far from the origin: nothing
/// is hard about it but the depth.
Nest random_nest(size_t depth, Dice& dice) {
    Nest nest;
    for (Vec3& p : nest.corners) p = Vec3(dice.direction());
    Vec3d middle(0, 0, 0);
    double stretch = 1;
    for (size_t i = 0; i < depth; ++i) {
        stretch = i % 2 == 0 ? dice.between(0.5, 2) : 1 / stretch;
        const Mat4d turn =
            random_rotation(dice) * scale_and_offset(Vec3d(stretch, stretch, stretch), {0, 0, 0});
        const Vec3d next = dice.vector(1);
        const Vec3d move = next - transform_point(middle, turn);
        nest.nodes.emplace_back(turn * scale_and_offset({1, 1, 1}, move));
        middle = transform_point(middle, Mat4d(nest.nodes.back()));
    }
    return nest;
}

/// At a point of an edge, eight ulps of 1 within the triangle or without.
Ray beside_an_edge(const std::array<Vec3d, 3>& corners, Dice& dice) {
    const uint32_t first = dice.below(3);
    const Vec3d a = corners[first], b = corners[(first + 1) % 3], c = corners[(first + 2) % 3];
    const Vec3d normal = normalize(cross(b - a, c - a)), inwards = normalize(cross(normal, b - a));
    const double gap = dice.sign() * 0x1p-20;
    const Vec3d target = a + (b - a) * dice.between(0.1, 0.9) + inwards * gap;
    const Vec3d back = normal * dice.sign() + dice.vector(0.7);
    return aimed_ray(target + back, target, dice);
}

std::unique_ptr<Trial> nested(const TrialRequest& request) {
    Dice dice(request.seed);
    constexpr size_t nest_count = 32;
    std::vector<Nest> nests;
    std::vector<NestedTriangle> exact;
    for (size_t i = 0; i < nest_count; ++i) {
        const Nest& nest = nests.emplace_back(random_nest(static_cast<size_t>(request.knob), dice));
        exact.emplace_back(nest.corners, nest.nodes);
    }
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i)
        rays.push_back(beside_an_edge(exact[i % nest_count].corners(), dice));
    return std::make_unique<NestingTrial>(std::move(nests), std::move(exact), std::move(rays));
}

}  // namespace

void add_nesting_family(std::vector<Family>& families) {
    std::vector<std::string> methods;
    for (const Placing& placing : placings) methods.push_back(placing.name);
    families.push_back({"X2", "nodes nested in nodes, rays beside the edges of what they place",
                        "depth of nesting", powers(4, 0, 4), methods, nested});
}

}  // namespace sightline
