// Mutants of the watertight test: what the atlas must catch. The healthy one passes.
#include "lab/atlas/mesh_making.h"
#include "lab/atlas/scene_trial.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sightline {
namespace {

enum class Mutation { none, flipped_sign, epsilon, contracted };

/// As a compiler that contracts would compute a·b − c·d.
float edge_function(Mutation mutation, float a, float b, float c, float d) {
    return mutation == Mutation::contracted ? std::fma(a, b, -(c * d)) : a * b - c * d;
}

/// Woop, Benthin and Wald's test along z for rays that are given in a frame where they mostly run
/// along z, so without their choice of axes; in floats, zeros in doubles.
bool sheared_test(Mutation mutation, const Ray& ray, Vec3 a, Vec3 b, Vec3 c, float& t) {
    const float sx = ray.direction.x / ray.direction.z, sy = ray.direction.y / ray.direction.z;
    for (Vec3* p : {&a, &b, &c}) {
        *p -= ray.origin;
        *p = {p->x - sx * p->z, p->y - sy * p->z, p->z};
    }
    float u = edge_function(mutation, c.x, b.y, c.y, b.x);
    float v = edge_function(mutation, a.x, c.y, a.y, c.x);
    float w = edge_function(mutation, b.x, a.y, b.y, a.x);
    if (u == 0 || v == 0 || w == 0) {
        const auto wide = [](float p, float q, float r, float s) {
            return static_cast<float>(double(p) * double(q) - double(r) * double(s));
        };
        u = wide(c.x, b.y, c.y, b.x), v = wide(a.x, c.y, a.y, c.x), w = wide(b.x, a.y, b.y, a.x);
    }
    if (mutation == Mutation::flipped_sign) w = -w;
    const float slack = mutation == Mutation::epsilon ? -1e-6f : 0;
    const float least = std::min({u, v, w}), most = std::max({u, v, w});
    if (least < -slack && most > slack) return false;
    const float sum = u + v + w;
    if (sum == 0 || (mutation == Mutation::epsilon && std::abs(sum) < 1e-6f)) return false;
    t = (u * a.z + v * b.z + w * c.z) / (ray.direction.z * sum);
    return t > 0;
}

/// Wrong answers and hits lost on rays at the edges and vertices of a patch that faces z.
struct Caught {
    size_t wrong = 0, missed = 0;
};

Caught caught(Mutation mutation, double size) {
    Dice dice(5);
    const Mat4d scaled = scale_and_offset(Vec3d(size, size, size), {0, 0, 0});
    const Mesh mesh = bumpy_patch(8, 1, scaled, dice);
    SceneQueries queries{scene_of_meshes({mesh}), {}};
    for (int i = 0; i < 4000; ++i) {
        const uint32_t cell = (2 + dice.below(4)) * 8 + 2;
        const uint32_t triangle = 2 * (cell + dice.below(4));
        const Vec3d target =
            aimed_point(mesh, triangle, i % 2 ? Target::edge : Target::vertex, dice);
        const Vec3d from = target + (Vec3d(0, 0, 5) + dice.vector(1)) * size;
        queries.rays.push_back(aimed_ray(from, target, dice));
    }
    const std::vector<Ray> rays = queries.rays;
    const auto trial = make_scene_trial(std::move(queries));
    Caught result;
    for (size_t i = 0; i < rays.size(); ++i) {
        MethodAnswer answer;
        for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
            const auto& [a, b, c] = mesh.triangles[k];
            float t = 0;
            if (sheared_test(mutation, rays[i], mesh.positions[a], mesh.positions[b],
                             mesh.positions[c], t) &&
                t < answer.hit.t)
                answer.hit = {t, 0, 0, k, 0, 0};
        }
        const Verdict verdict = trial->judge(i, answer);
        result.missed += verdict == Verdict::missed;
        result.wrong += verdict == Verdict::missed || verdict == Verdict::false_hit ||
                        verdict == Verdict::wrong_primitive;
    }
    return result;
}

TEST(AtlasMutants, TheHealthyTestLosesNothing) {
    EXPECT_EQ(caught(Mutation::none, 1).missed, 0u);
    EXPECT_EQ(caught(Mutation::none, 1e-3).missed, 0u);
}

TEST(AtlasMutants, AFlippedSignIsCaught) {
    EXPECT_GT(caught(Mutation::flipped_sign, 1).wrong, 2000u);
}

TEST(AtlasMutants, AnEpsilonIsCaughtWhereThingsAreSmall) {
    EXPECT_EQ(caught(Mutation::epsilon, 1e-3).missed, 4000u);
}

TEST(AtlasMutants, ContractionIsCaught) {
    EXPECT_GT(caught(Mutation::contracted, 1).missed, 4u);  // 177 of 20,000 edge rays elsewhere
}

}  // namespace
}  // namespace sightline
