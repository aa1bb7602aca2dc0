#include "intersect/embree/robust_choice.h"

#include "intersect/ray_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <unordered_set>

namespace sightline {

extern const char* const breakdown_json;  // breakdown.json as a string

namespace {

using nlohmann::json;

constexpr size_t max_triangles = 200000;
constexpr double max_knob_step = 100;
constexpr const char* default_mode = "embree-default";

/// The ends of an edge, in an order that does not depend on the triangle's.
struct Edge {
    std::array<float, 6> ends;

    Edge(const Vec3& a, const Vec3& b) {
        std::array<std::array<float, 3>, 2> points = {{{a.x, a.y, a.z}, {b.x, b.y, b.z}}};
        std::sort(points.begin(), points.end());
        for (size_t i = 0; i < 6; ++i) ends[i] = points[i / 3][i % 3] + 0.0f;  // −0 equals 0
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

/// Examines triangles until two share an edge.
class TriangleSurvey {
  public:
    explicit TriangleSurvey(double max_coordinate) : max_coordinate_(max_coordinate) {}

    void add(const Mesh& mesh) {
        for (const auto& [a, b, c] : mesh.triangles) {
            if (stats.shared_edges) return;
            add(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
            if (++stats.triangles > max_triangles) stats.shared_edges = true;
        }
    }

    TriangleStats stats;

  private:
    void add(const Vec3& a, const Vec3& b, const Vec3& c) {
        const Vec3d ab(b - a), bc(c - b), ca(a - c);
        const double shortest = std::min({ab.length(), bc.length(), ca.length()});
        const double longest = std::max({ab.length(), bc.length(), ca.length()});
        const double height = cross(ab, ca).length() / longest;
        stats.max_coordinate_over_min_edge =
            std::max(stats.max_coordinate_over_min_edge, max_coordinate_ / shortest);
        // No height, or a NaN, counts as infinitely thin.
        const double thinness =
            height > 0 ? max_coordinate_ / height : std::numeric_limits<double>::infinity();
        stats.max_coordinate_over_min_height =
            std::max(stats.max_coordinate_over_min_height, thinness);
        for (const Edge& edge : {Edge(a, b), Edge(b, c), Edge(c, a)})
            if (!edges_.insert(edge).second) stats.shared_edges = true;
    }

    double max_coordinate_;
    std::unordered_set<Edge, EdgeHash> edges_;
};

/// The family's entry of breakdown.json; empty if there is none for the method.
const json& find_entry(const std::string& family, const std::string& method) {
    static const json families = json::parse(breakdown_json).at("families");
    static const json nothing = json::object();
    const auto found = families.find(family);
    return found != families.end() && found->at("breakdown").contains(method) ? *found : nothing;
}

bool has_only_baked_triangles(const Scene& scene) {
    return std::all_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& i) {
        return i.baked && scene.groups[i.group].shapes.empty();
    });
}

RobustChoice choose_mode(const Scene& scene, const Vec3& eye) {
    if (!has_only_baked_triangles(scene))
        return {true, "shapes or instances, on which the default mode has not been measured"};
    const TriangleStats stats = triangle_stats(scene, eye);
    if (stats.shared_edges)
        return {true,
                fmt::format("triangles share edges; coordinate / edge is {:.3g}, and the default "
                            "mode fails from {:.3g} on (atlas T1e)",
                            stats.max_coordinate_over_min_edge,
                            first_failing_value("T1e", default_mode))};
    const double limit = max_safe_value("T2", default_mode);
    return {!(stats.max_coordinate_over_min_height <= limit),
            fmt::format("no shared edges; coordinate / height is {:.3g}, and the default mode is "
                        "safe up to {:.3g} (atlas T2)",
                        stats.max_coordinate_over_min_height, limit)};
}

}  // namespace

RobustChoice choose_robust(const Scene& scene, const Vec3& eye) {
    RobustChoice choice = choose_mode(scene, eye);
    if (choice.robust) return choice;
    choice.overlap = overlap_stats(scene);
    choice.quality =
        spatial_splits_pay_off(choice.overlap) ? BuildQuality::high : BuildQuality::medium;
    return choice;
}

TriangleStats triangle_stats(const Scene& scene, const Vec3& eye) {
    const Box3& box = scene.bounds;
    float max_coordinate = max_abs_component(eye);
    if (!box.isEmpty())
        max_coordinate =
            std::max({max_coordinate, max_abs_component(box.min), max_abs_component(box.max)});
    TriangleSurvey survey(static_cast<double>(max_coordinate));
    for (const Instance& instance : scene.instances)
        for (const uint32_t mesh : scene.groups[instance.group].meshes) {
            if (!instance.baked) survey.stats.shared_edges = true;
            survey.add(scene.meshes[mesh]);
        }
    return survey.stats;
}

double max_safe_value(const std::string& family, const std::string& method) {
    const json& entry = find_entry(family, method);
    if (entry.empty()) return 0;
    const json& breakdown = entry["breakdown"][method];
    return breakdown.is_null() ? entry["largest"].get<double>()
                               : breakdown.get<double>() / max_knob_step;
}

double first_failing_value(const std::string& family, const std::string& method) {
    const json& entry = find_entry(family, method);
    if (entry.empty()) return 0;
    const json& breakdown = entry["breakdown"][method];
    return breakdown.is_null() ? std::numeric_limits<double>::infinity() : breakdown.get<double>();
}

}  // namespace sightline
