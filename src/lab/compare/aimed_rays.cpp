#include "lab/compare/aimed_rays.h"

#include "core/error.h"
#include "exact/referee.h"
#include "lab/atlas/rng.h"

#include <algorithm>
#include <map>

namespace sightline {
namespace {

/// The triangle's vertices in world space, in double.
std::array<Vec3d, 3> corners_of(const Scene& scene, const SurfaceId& id) {
    const InstancedTriangle t = instanced_triangle(scene, id);
    const Mat4d m = t.to_world ? Mat4d(*t.to_world) : Mat4d();
    return {Vec3d(t.a) * m, Vec3d(t.b) * m, Vec3d(t.c) * m};
}

Vec3d normal_of(const std::array<Vec3d, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]); }

/// The triangles of a mesh by edge; edges are pairs of positions, as copies of a vertex may differ
/// in their normals or texture coordinates.
class EdgeMap {
  public:
    explicit EdgeMap(const Mesh& mesh) : mesh_(mesh) {
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i)
            for (size_t k = 0; k < 3; ++k) triangles_[edge(i, k)].push_back(i);
    }

    /// Another triangle at the edge from vertex k of a triangle; none: `triangle` itself.
    uint32_t neighbour(uint32_t triangle, size_t k) const {
        for (const uint32_t other : triangles_.at(edge(triangle, k)))
            if (other != triangle) return other;
        return triangle;
    }

  private:
    using Point = std::array<float, 3>;

    std::pair<Point, Point> edge(uint32_t triangle, size_t k) const {
        const auto point = [&](size_t corner) {
            const Vec3& p = mesh_.positions[mesh_.triangles[triangle][corner % 3]];
            return Point{p.x, p.y, p.z};
        };
        return std::minmax(point(k), point(k + 1), std::less<Point>());
    }

    const Mesh& mesh_;
    std::map<std::pair<Point, Point>, std::vector<uint32_t>> triangles_;
};

/// Draws rays of one scene.
class Aimer {
  public:
    Aimer(const Scene& scene, uint64_t seed) : scene_(scene), rng_(seed) {
        for (uint32_t i = 0; i < scene.instances.size(); ++i)
            for (const uint32_t mesh : scene.groups[scene.instances[i].group].meshes)
                if (!scene.meshes[mesh].triangles.empty()) meshes_.push_back({i, mesh, 0});
        for (const SurfaceId& id : meshes_)
            for (uint32_t i = 0; i < scene.meshes[id.geometry].triangles.size(); ++i)
                for (const Vec3d& p : corners_of(scene, {id.instance, id.geometry, i}))
                    if (std::isfinite(p.x + p.y + p.z)) bounds_.extendBy(p);
        if (meshes_.empty() || bounds_.isEmpty() || bounds_.min == bounds_.max)
            throw Error(scene.path + ": --aim: there are no triangles to aim at");
    }

    RecordedRay draw(AimedAt aim, bool shadow) {
        for (int attempt = 0; attempt < 64; ++attempt) {
            const auto ray = aim == AimedAt::surface ? leaving() : aimed(aim, shadow);
            if (ray) return *ray;
        }
        return *aimed(AimedAt::vertices, shadow);  // no edge of this scene has a silhouette
    }

  private:
    SurfaceId triangle() {
        SurfaceId id = meshes_[rng_.below(meshes_.size())];
        id.primitive = rng_.below(scene_.meshes[id.geometry].triangles.size());
        return id;
    }

    Vec3d origin() {
        const Vec3d half = bounds_.size() * (rng_.coin() ? 0.5 : 1.5);
        const double x = rng_.uniform(-half.x, half.x), y = rng_.uniform(-half.y, half.y);
        return bounds_.center() + Vec3d(x, y, rng_.uniform(-half.z, half.z));
    }

    std::optional<RecordedRay> aimed(AimedAt aim, bool shadow) {
        const SurfaceId id = triangle();
        const auto corners = corners_of(scene_, id);
        const Vec3d from = origin();
        const size_t k = rng_.below(3);
        if (aim == AimedAt::silhouettes && !is_silhouette(id, k, from)) return {};
        const double s = aim == AimedAt::vertices ? 0 : rng_.uniform(0, 1);
        Ray ray = aimed_ray(from, corners[k] + (corners[(k + 1) % 3] - corners[k]) * s, rng_);
        if (shadow) ray.tfar = 4;
        return RecordedRay{ray, shadow ? RayKind::shadow : RayKind::reflection};
    }

    bool is_silhouette(const SurfaceId& id, size_t k, const Vec3d& from) {
        auto known = edges_.find(id.geometry);
        if (known == edges_.end())
            known = edges_.try_emplace(id.geometry, scene_.meshes[id.geometry]).first;
        SurfaceId other = id;
        other.primitive = known->second.neighbour(id.primitive, k);
        if (other == id) return true;  // the mesh ends there
        const auto one = corners_of(scene_, id), two = corners_of(scene_, other);
        return dot(normal_of(one), one[0] - from) * dot(normal_of(two), two[0] - from) <= 0;
    }

    /// A ray from a point of a triangle, rounded to floats.
    std::optional<RecordedRay> leaving() {
        const SurfaceId id = triangle();
        const auto corners = corners_of(scene_, id);
        const double u = rng_.uniform(0, 1), v = rng_.uniform(0, 1 - u);
        const Vec3 point(corners[0] + (corners[1] - corners[0]) * u +
                         (corners[2] - corners[0]) * v);
        return RecordedRay{{point, 0, Vec3(rng_.direction())}, RayKind::reflection, -1, -1, id};
    }

    const Scene& scene_;
    Rng rng_;
    std::vector<SurfaceId> meshes_;  // instances and their meshes
    Imath::Box3d bounds_;
    std::map<uint32_t, EdgeMap> edges_;  // by mesh, made at first use
};

}  // namespace

std::vector<RecordedRay> aimed_rays(const Scene& scene, std::span<const AimedAt> aims, size_t count,
                                    uint64_t seed) {
    Aimer aimer(scene, seed);
    std::vector<RecordedRay> rays;
    rays.reserve(count);
    for (size_t i = 0; i < count; ++i)
        rays.push_back(aimer.draw(aims[i % aims.size()], i / aims.size() % 4 == 3));
    return rays;
}

}  // namespace sightline
