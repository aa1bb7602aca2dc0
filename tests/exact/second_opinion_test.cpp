// A second judge of rays and triangles, written from docs/truth.md. It shares no code with
// src/exact: rational numbers of GMP instead of dyadic ones, Cramer's rule instead of edge
// functions, and every triangle is tested. SIGHTLINE_SECOND_OPINION_RAYS sets the number of rays.
#include "core/parallel.h"
#include "exact/rational.h"
#include "exact/referee.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>

namespace sightline {
namespace {

using rational::Number;
using rational::number;
using rational::Point;
using rational::point;

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// The determinant of a matrix with these columns.
Number determinant(const Point& a, const Point& b, const Point& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/// A triangle of the world and its ids.
struct Face {
    std::array<Point, 3> corners;
    std::array<uint32_t, 3> id;  // instance, geometry, primitive
};

/// p · m
Point placed(const Vec3& p, const Mat4& m) {
    Point result;
    for (int j = 0; j < 3; ++j) {
        result[static_cast<size_t>(j)] = number(m[3][j]);
        for (int i = 0; i < 3; ++i)
            result[static_cast<size_t>(j)] += number(p[i]) * number(m[i][j]);
    }
    return result;
}

std::vector<Face> faces_of(const Scene& scene) {
    std::vector<Face> faces;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (const uint32_t mesh : scene.groups[scene.instances[i].group].meshes)
            for (uint32_t k = 0; k < scene.meshes[mesh].triangles.size(); ++k) {
                Face face{{}, {i, mesh, k}};
                for (size_t c = 0; c < 3; ++c) {
                    const Vec3& p =
                        scene.meshes[mesh].positions[scene.meshes[mesh].triangles[k][c]];
                    face.corners[c] = scene.instances[i].baked
                                          ? point(p)
                                          : placed(p, scene.instances[i].object_to_world);
                }
                faces.push_back(face);
            }
    return faces;
}

/// The t at which the ray hits the closed triangle, if it does: from o + t d = a + u ab + v ac;
/// `back` is −d.
std::optional<Number> hit(const Ray& ray, const Point& o, const Point& back, const Face& face) {
    const Point ab = minus(face.corners[1], face.corners[0]),
                ac = minus(face.corners[2], face.corners[0]), s = minus(o, face.corners[0]);
    const Number whole = determinant(ab, ac, back);
    if (whole == 0) return {};
    const Number u = determinant(s, ac, back) / whole;
    if (u < 0 || u > 1) return {};
    const Number v = determinant(ab, s, back) / whole;
    if (v < 0 || u + v > 1) return {};
    const Number t = determinant(ab, ac, s) / whole;
    if (t <= number(ray.tnear) || (!std::isinf(ray.tfar) && t > number(ray.tfar))) return {};
    return t;
}

/// What a ray hits first.
struct Opinion {
    std::vector<SurfaceId> nearest;
    Number t;
};

Opinion judge(const Ray& ray, const std::vector<Face>& faces) {
    Opinion opinion;
    const Point o = point(ray.origin), back = point(-ray.direction);
    for (const Face& face : faces) {
        const auto t = hit(ray, o, back, face);
        if (!t || (!opinion.nearest.empty() && *t > opinion.t)) continue;
        if (opinion.nearest.empty() || *t < opinion.t) opinion.nearest.clear();
        opinion.t = *t;
        opinion.nearest.push_back({face.id[0], face.id[1], face.id[2]});
    }
    std::sort(opinion.nearest.begin(), opinion.nearest.end());
    return opinion;
}

/// Draws scenes and rays that are difficult for floats.
class Adversary {
  public:
    explicit Adversary(unsigned seed) : random_(seed) {}

    /// Triangles on a lattice, so that edges, vertices and whole faces coincide; slivers; copies
    /// of the mesh that are sheared, mirrored, almost flat and far away.
    Scene scene() {
        Mesh mesh;
        for (int i = 0; i < 8; ++i)
            for (int k = 0; k < 3; ++k)
                mesh.positions.push_back(k == 2 && i % 4 == 0
                                             ? mesh.positions.back() + Vec3(0x1p-20f, 0, 0x1p-22f)
                                             : lattice());
        for (uint32_t i = 0; i < 8; ++i) mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        mesh.triangles.push_back(mesh.triangles[1]);
        mesh.triangles.push_back({0, 0, 1});
        SceneBuilder builder;
        builder.add_instance(builder.add_group({mesh}));
        const uint32_t group = builder.add_mesh(mesh);
        Mat4 sheared, mirrored, thin, far;
        sheared[1][0] = 1.5f;
        sheared[2][1] = 0x1p-3f;
        mirrored[0][0] = -1;
        mirrored[3][0] = 0.5f;
        thin[2][2] = 0x1p-23f;
        thin[0][2] = 0x1p-12f;
        far[3][1] = 0x1p20f;
        far[0][0] = 0x1p10f;
        for (const Mat4& m : {sheared, mirrored, thin, far}) builder.add_instance(group, m);
        return builder.finish();
    }

    /// Through a vertex, along an edge, within a plane, or through a lattice point.
    Ray ray(const Scene& scene) {
        const Mesh& mesh = scene.meshes[0];
        const auto& triangle = mesh.triangles[random_() % mesh.triangles.size()];
        const Vec3 a = mesh.positions[triangle[0]], b = mesh.positions[triangle[1]],
                   c = mesh.positions[triangle[2]];
        const size_t how = random_() % 6;
        const Mat4& m = scene.instances[random_() % scene.instances.size()].object_to_world;
        const Vec3 target = (how == 0   ? a
                             : how == 1 ? (a + b) * 0.5f
                             : how == 2 ? a * 0.25f + b * 0.75f
                             : how == 3 ? (a + b * 2 + c) * 0.25f
                                        : lattice()) *
                            m;
        const Vec3 origin = how == 4 ? a : how == 5 ? (b + c) * 0.5f : lattice() * 3;
        Ray ray{origin, 0, target - origin, INFINITY};
        if (random_() % 4 == 0) ray.tfar = 1;
        if (random_() % 4 == 0) ray.tnear = 0.5f;
        if (random_() % 8 == 0) ray.direction[random_() % 3] = 0;
        if (ray.direction == Vec3(0, 0, 0)) ray.direction.x = 1;
        return ray;
    }

  private:
    Vec3 lattice() {
        const auto coordinate = [&] { return static_cast<float>(random_() % 9) * 0.25f - 1; };
        const float x = coordinate(), y = coordinate();
        return {x, y, coordinate()};
    }

    std::mt19937 random_;
};

TEST(SecondOpinion, AgreesWithTheRefereeOnEveryAdversarialRay) {
    const int rays = rational::wanted_rays(10000);
    constexpr int rays_of_a_scene = 500;
    std::atomic<size_t> hits = 0, ties = 0;
    parallel_for(static_cast<size_t>(rays / rays_of_a_scene), [&](size_t block) {
        Adversary adversary(static_cast<unsigned>(block * rays_of_a_scene));
        const Scene scene = adversary.scene();
        const auto faces = faces_of(scene);
        const Referee referee(scene);
        for (int i = 0; i < rays_of_a_scene; ++i) {
            const Ray ray = adversary.ray(scene);
            const Opinion opinion = judge(ray, faces);
            const Truth truth = referee.closest(ray);
            ASSERT_EQ(truth.nearest, opinion.nearest) << "scene " << block << ", ray " << i;
            if (opinion.nearest.empty()) continue;
            ASSERT_EQ(truth.t, rational::nearest_double(opinion.t))
                << "scene " << block << ", ray " << i;
            ++hits;
            ties += opinion.nearest.size() > 1;
        }
    });
    RecordProperty("hits", static_cast<int>(hits));
    EXPECT_GT(hits, static_cast<size_t>(rays) / 4);
    EXPECT_GT(ties, static_cast<size_t>(rays) / 50);
}

}  // namespace
}  // namespace sightline
