#include "render/knobs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_set>

namespace sightline {
namespace {

constexpr size_t most_triangles = 200000;

/// The ends of an edge, in an order that does not depend on the triangle's.
struct Edge {
    std::array<float, 6> ends;

    Edge(const Vec3& a, const Vec3& b) {
        std::array<std::array<float, 3>, 2> points = {{{a.x, a.y, a.z}, {b.x, b.y, b.z}}};
        std::sort(points.begin(), points.end());
        for (size_t i = 0; i < 6; ++i) ends[i] = points[i / 3][i % 3] + 0.0f;  // −0 is 0
    }
    bool operator==(const Edge&) const = default;
};

struct EdgeHash {
    size_t operator()(const Edge& edge) const {
        uint64_t hash = 0;
        for (const float x : edge.ends)
            hash = (hash ^ std::bit_cast<uint32_t>(x)) * 0x9e3779b97f4a7c15u, hash ^= hash >> 29;
        return hash;
    }
};

float largest_of(const Vec3& v) {
    return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// Goes through triangles until two share an edge.
class Survey {
  public:
    explicit Survey(double reach) : reach_(reach) {}

    void add(const Mesh& mesh) {
        for (const auto& [a, b, c] : mesh.triangles) {
            if (knobs_.shared_edges) return;
            add(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
            if (++knobs_.triangles > most_triangles) knobs_.shared_edges = true;
        }
    }
    void presume_shared() { knobs_.shared_edges = true; }

    const TriangleKnobs& knobs() const { return knobs_; }

  private:
    void add(const Vec3& a, const Vec3& b, const Vec3& c) {
        const Vec3d ab(b - a), bc(c - b), ca(a - c);
        const double shortest = std::min({ab.length(), bc.length(), ca.length()});
        const double longest = std::max({ab.length(), bc.length(), ca.length()});
        const double width = cross(ab, ca).length() / longest;
        knobs_.reach_per_edge = std::max(knobs_.reach_per_edge, reach_ / shortest);
        // Without a width, or with a NaN, it is infinitely hard.
        const double hardness =
            width > 0 ? reach_ / width : std::numeric_limits<double>::infinity();
        knobs_.reach_per_width = std::max(knobs_.reach_per_width, hardness);
        for (const Edge& edge : {Edge(a, b), Edge(b, c), Edge(c, a)})
            if (!edges_.insert(edge).second) knobs_.shared_edges = true;
    }

    double reach_;
    TriangleKnobs knobs_;
    std::unordered_set<Edge, EdgeHash> edges_;
};

}  // namespace

TriangleKnobs find_triangle_knobs(const Scene& scene, const Vec3& eye) {
    const Box3& box = scene.bounds;
    float reach = largest_of(eye);
    if (!box.isEmpty()) reach = std::max({reach, largest_of(box.min), largest_of(box.max)});
    Survey survey(static_cast<double>(reach));
    for (const Instance& instance : scene.instances)
        for (const uint32_t mesh : scene.groups[instance.group].meshes) {
            if (!instance.baked) survey.presume_shared();
            survey.add(scene.meshes[mesh]);
        }
    return survey.knobs();
}

}  // namespace sightline
