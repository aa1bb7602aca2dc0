#include "scene/tangents.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace sightline {
namespace {

/// A vertex's position, normal and uv; MikkTSpace welds corners where all three are equal.
using PointKey = std::array<float, 8>;

struct HashPoint {
    size_t operator()(const PointKey& key) const {
        uint64_t hash = 0;
        for (const float x : key) hash = (hash ^ std::hash<float>()(x)) * 0x9e3779b97f4a7c15u;
        return hash ^ (hash >> 32);
    }
};

enum class Facing { with_uv, against_uv, undecided };

struct Triangle {
    std::array<uint32_t, 3> points{};      // welded
    std::array<uint32_t, 3> neighbours{};  // across the edge from corner i to the next
    Vec3 direction{0, 0, 0};               // of increasing u, unit
    Facing facing =
        Facing::undecided;       // undecided until a group includes a triangle without uv area
    bool has_frame = false;      // the uv area is not zero
    bool is_degenerate = false;  // two corners have the same position
};

struct GroupedTangent {
    Vec3 sum{0, 0, 0};
    Facing facing;
};

class TangentBuilder {
  public:
    TangentBuilder(Mesh& mesh, uint32_t texcoord) : mesh_(mesh), uvs_(mesh.texcoords[texcoord]) {}

    void build() {
        weld();
        measure_triangles();
        find_neighbours();
        group_corners();
        sum_tangents();
        assign_degenerate();
        write();
    }

  private:
    void weld() {
        std::unordered_map<PointKey, uint32_t, HashPoint> points;
        points.reserve(mesh_.positions.size());
        point_of_.resize(mesh_.positions.size());
        for (uint32_t v = 0; v < point_of_.size(); ++v) {
            const Vec3 &p = mesh_.positions[v], &n = mesh_.normals[v];
            const PointKey key{p.x, p.y, p.z, n.x, n.y, n.z, uvs_[v].x, uvs_[v].y};
            point_of_[v] = points.try_emplace(key, v).first->second;
        }
    }

    void measure_triangles() {
        triangles_.resize(mesh_.triangles.size());
        for (size_t t = 0; t < triangles_.size(); ++t) {
            const auto& v = mesh_.triangles[t];
            Triangle& triangle = triangles_[t];
            for (size_t i = 0; i < 3; ++i) triangle.points[i] = point_of_[v[i]];
            const Vec3 &a = mesh_.positions[v[0]], &b = mesh_.positions[v[1]];
            const Vec3& c = mesh_.positions[v[2]];
            triangle.is_degenerate = a == b || b == c || c == a;
            const Vec2 s = uvs_[v[1]] - uvs_[v[0]], r = uvs_[v[2]] - uvs_[v[0]];
            const float area = s.x * r.y - s.y * r.x;
            if (triangle.is_degenerate || !(std::abs(area) > std::numeric_limits<float>::min()))
                continue;
            const Vec3 along = (b - a) * r.y - (c - a) * s.y;
            triangle.facing = area > 0 ? Facing::with_uv : Facing::against_uv;
            triangle.direction = normalize(area > 0 ? along : -along);
            triangle.has_frame = dot(along, along) > 0;
        }
    }

    /// Sorting groups the half-edges of an edge by direction; the n-th in one direction becomes the
    /// neighbour of the n-th in the other.
    void find_neighbours() {
        struct HalfEdge {
            uint32_t low, high;
            bool rising;
            uint32_t corner;
        };
        std::vector<HalfEdge> edges;
        edges.reserve(3 * triangles_.size());
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            triangles_[t].neighbours.fill(none);
            if (triangles_[t].is_degenerate) continue;
            for (uint32_t i = 0; i < 3; ++i) {
                const uint32_t a = triangles_[t].points[i], b = triangles_[t].points[(i + 1) % 3];
                edges.push_back({std::min(a, b), std::max(a, b), a < b, 3 * t + i});
            }
        }
        const auto order = [](const HalfEdge& e) {
            return std::tuple(e.low, e.high, e.rising, e.corner);
        };
        std::ranges::sort(edges, {}, order);
        for (auto begin = edges.begin(); begin != edges.end();) {
            const auto same = [&](const HalfEdge& e) {
                return e.low == begin->low && e.high == begin->high;
            };
            const auto end = std::find_if_not(begin, edges.end(), same);
            auto rising = std::find_if(begin, end, [](const HalfEdge& e) { return e.rising; });
            for (auto falling = begin; rising != end && falling->rising == false;
                 ++falling, ++rising) {
                triangles_[rising->corner / 3].neighbours[rising->corner % 3] = falling->corner / 3;
                triangles_[falling->corner / 3].neighbours[falling->corner % 3] =
                    rising->corner / 3;
            }
            begin = end;
        }
    }

    /// Corners at one point share a tangent if they are connected by edges of triangles with the
    /// same facing.
    void group_corners() {
        group_of_.assign(3 * triangles_.size(), none);
        for (uint32_t t = 0; t < triangles_.size(); ++t) {
            if (!triangles_[t].has_frame) continue;
            for (uint32_t i = 0; i < 3; ++i)
                if (group_of_[3 * t + i] == none) start_group(t, triangles_[t].points[i]);
        }
    }

    void start_group(uint32_t first, uint32_t point) {
        const auto group = static_cast<uint32_t>(groups_.size());
        const Facing facing = triangles_[first].facing;
        groups_.push_back({Vec3(0), facing});
        std::vector<uint32_t> open{first};
        while (!open.empty()) {
            const uint32_t t = open.back();
            open.pop_back();
            Triangle& triangle = triangles_[t];
            const size_t i =
                size_t(std::ranges::find(triangle.points, point) - triangle.points.begin());
            if (group_of_[3 * t + i] != none) continue;
            if (triangle.facing == Facing::undecided) triangle.facing = facing;
            if (triangle.facing != facing) continue;
            group_of_[3 * t + i] = group;
            for (const size_t edge : {i, (i + 2) % 3})
                if (triangle.neighbours[edge] != none) open.push_back(triangle.neighbours[edge]);
        }
    }

    /// Triangles are weighted by their angle at the point, measured in the plane of the normal.
    void sum_tangents() {
        for (uint32_t corner = 0; corner < group_of_.size(); ++corner) {
            const Triangle& triangle = triangles_[corner / 3];
            if (group_of_[corner] == none || !triangle.has_frame) continue;
            const auto& v = mesh_.triangles[corner / 3];
            const uint32_t here = v[corner % 3];
            const Vec3& n = mesh_.normals[here];
            const auto flatten = [&n](const Vec3& x) { return normalize(x - n * dot(n, x)); };
            const auto edge_to = [&](uint32_t other) {
                return flatten(mesh_.positions[other] - mesh_.positions[here]);
            };
            const float cosine = dot(edge_to(v[(corner + 1) % 3]), edge_to(v[(corner + 2) % 3]));
            const float angle = std::acos(std::clamp(cosine, -1.0f, 1.0f));
            groups_[group_of_[corner]].sum += flatten(triangle.direction) * angle;
        }
    }

    /// Triangles without area get the tangents of others at the same points.
    void assign_degenerate() {
        std::vector<uint32_t> group_at(mesh_.positions.size(), none);
        for (uint32_t corner = 0; corner < group_of_.size(); ++corner) {
            uint32_t& group = group_at[triangles_[corner / 3].points[corner % 3]];
            if (group == none) group = group_of_[corner];
        }
        for (uint32_t corner = 0; corner < group_of_.size(); ++corner)
            if (group_of_[corner] == none)
                group_of_[corner] = group_at[triangles_[corner / 3].points[corner % 3]];
    }

    Vec4 tangent(uint32_t vertex, uint32_t group) const {
        const Vec3& n = mesh_.normals[vertex];
        Vec3 unit(0);
        float sign = 1;
        if (group != none) {
            unit = normalize(groups_[group].sum);
            sign = groups_[group].facing == Facing::with_uv ? -1.0f : 1.0f;
        }
        if (!(dot(unit, unit) > 0.5f))
            unit =
                normalize(std::abs(n.x) < 0.9f ? Vec3(1, 0, 0) - n * n.x : Vec3(0, 1, 0) - n * n.y);
        return {unit.x, unit.y, unit.z, sign};
    }

    /// Sets each vertex's tangent, and duplicates the vertex for each further tangent.
    void write() {
        const size_t vertices = mesh_.positions.size();
        mesh_.tangents.assign(vertices, Vec4(0));
        std::vector<std::vector<uint32_t>> copies(vertices);
        for (uint32_t corner = 0; corner < group_of_.size(); ++corner) {
            uint32_t& vertex = mesh_.triangles[corner / 3][corner % 3];
            const Vec4 corner_tangent = tangent(vertex, group_of_[corner]);
            if (mesh_.tangents[vertex].w == 0) mesh_.tangents[vertex] = corner_tangent;
            if (mesh_.tangents[vertex] == corner_tangent) continue;
            std::vector<uint32_t>& others = copies[vertex];
            const auto same = std::ranges::find_if(
                others, [&](uint32_t other) { return mesh_.tangents[other] == corner_tangent; });
            if (same == others.end()) {
                others.push_back(duplicate(vertex));
                vertex = others.back();
                mesh_.tangents[vertex] = corner_tangent;
            } else {
                vertex = *same;
            }
        }
        for (uint32_t v = 0; v < vertices; ++v)
            if (mesh_.tangents[v].w == 0) mesh_.tangents[v] = tangent(v, none);
    }

    uint32_t duplicate(uint32_t vertex) {
        const auto copy = [vertex](auto& values) {
            if (values.empty()) return;
            const auto value = values[vertex];
            values.push_back(value);
        };
        copy(mesh_.positions);
        copy(mesh_.normals);
        copy(mesh_.tangents);
        copy(mesh_.colors);
        for (auto& uvs : mesh_.texcoords) copy(uvs);
        return static_cast<uint32_t>(mesh_.positions.size() - 1);
    }

    Mesh& mesh_;
    const std::vector<Vec2> uvs_;
    std::vector<uint32_t> point_of_;  // by vertex: the first equal vertex
    std::vector<Triangle> triangles_;
    std::vector<uint32_t> group_of_;  // by corner
    std::vector<GroupedTangent> groups_;
};

}  // namespace

void compute_flat_normals(Mesh& mesh) {
    Mesh flat;
    const auto spread = [&mesh](auto& to, const auto& from) {
        if (from.empty()) return;
        to.reserve(3 * mesh.triangles.size());
        for (const auto& triangle : mesh.triangles)
            for (const uint32_t v : triangle) to.push_back(from[v]);
    };
    spread(flat.positions, mesh.positions);
    spread(flat.colors, mesh.colors);
    flat.texcoords.resize(mesh.texcoords.size());
    for (size_t i = 0; i < mesh.texcoords.size(); ++i) spread(flat.texcoords[i], mesh.texcoords[i]);
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        mesh.triangles[t] = {3 * t, 3 * t + 1, 3 * t + 2};
        const Vec3* p = &flat.positions[3 * t];
        Vec3 n(normalize(cross(Vec3d(p[1]) - Vec3d(p[0]), Vec3d(p[2]) - Vec3d(p[0]))));
        if (!(dot(n, n) > 0.5f)) n = Vec3(0, 0, 1);
        flat.normals.insert(flat.normals.end(), 3, n);
    }
    mesh.positions = std::move(flat.positions);
    mesh.normals = std::move(flat.normals);
    mesh.colors = std::move(flat.colors);
    mesh.texcoords = std::move(flat.texcoords);
    mesh.tangents.clear();
}

void compute_tangents(Mesh& mesh, uint32_t texcoord) { TangentBuilder(mesh, texcoord).build(); }

}  // namespace sightline
