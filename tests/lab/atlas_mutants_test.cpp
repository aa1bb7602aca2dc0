// Mutants of the watertight test: what the atlas must catch. The healthy one passes.
#include "lab/atlas/mesh_making.h"
#include "lab/atlas/scene_trial.h"
#include "support/mutants.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// Wrong answers and hits lost on rays at the edges and vertices of a patch that faces z.
struct Caught {
    size_t wrong = 0, missed = 0;
};

Caught caught(Mutant mutant, double size) {
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
        answer.hit = trace_mutant(mesh, rays[i], mutant);
        const Verdict verdict = trial->judge(i, answer);
        result.missed += verdict == Verdict::missed;
        result.wrong += verdict == Verdict::missed || verdict == Verdict::false_hit ||
                        verdict == Verdict::wrong_primitive;
    }
    return result;
}

TEST(AtlasMutants, TheHealthyTestLosesNothing) {
    EXPECT_EQ(caught(Mutant::healthy, 1).missed, 0u);
    EXPECT_EQ(caught(Mutant::healthy, 1e-3).missed, 0u);
}

TEST(AtlasMutants, AFlippedSignIsCaught) {
    EXPECT_GT(caught(Mutant::flipped_sign, 1).wrong, 2000u);
}

TEST(AtlasMutants, AnEpsilonIsCaughtWhereThingsAreSmall) {
    EXPECT_EQ(caught(Mutant::epsilon, 1e-3).missed, 4000u);
}

TEST(AtlasMutants, ContractionIsCaught) {
    EXPECT_GT(caught(Mutant::contraction, 1).missed, 4u);  // 177 of 20,000 edge rays elsewhere
}

}  // namespace
}  // namespace sightline
