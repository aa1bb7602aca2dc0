// The atlas must detect mutants of the watertight test; the healthy test passes.
#include "lab/atlas/meshes.h"
#include "lab/atlas/scene_experiment.h"
#include "support/mutants.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

/// Wrong answers and missed hits of rays at the edges and vertices of a patch that faces z.
struct MutantErrors {
    size_t wrong = 0, missed = 0;
};

MutantErrors errors_of(Mutant mutant, double size) {
    Rng rng(5);
    const Mat4d scaled = scale_and_translate(Vec3d(size, size, size), {0, 0, 0});
    const Mesh mesh = bumpy_patch(8, 1, scaled, rng);
    SceneRays input{scene_of_meshes({mesh}), {}};
    for (int i = 0; i < 4000; ++i) {
        const uint32_t cell = (2 + rng.below(4)) * 8 + 2;
        const uint32_t triangle = 2 * (cell + rng.below(4));
        const Vec3d target =
            random_target(mesh, triangle, i % 2 ? Target::edge : Target::vertex, rng);
        const Vec3d from = target + (Vec3d(0, 0, 5) + rng.in_cube(1)) * size;
        input.rays.push_back(aimed_ray(from, target, rng));
    }
    const std::vector<Ray> rays = input.rays;
    const Experiment experiment = make_scene_experiment(std::move(input));
    MutantErrors result;
    for (size_t i = 0; i < rays.size(); ++i) {
        MethodAnswer answer;
        answer.hit = trace_mutant(mesh, rays[i], mutant);
        const Verdict verdict = experiment.verdict(i, answer);
        result.missed += verdict == Verdict::missed;
        result.wrong += is_wrong(verdict);
    }
    return result;
}

TEST(AtlasMutants, TheHealthyTestLosesNothing) {
    EXPECT_EQ(errors_of(Mutant::healthy, 1).missed, 0u);
    EXPECT_EQ(errors_of(Mutant::healthy, 1e-3).missed, 0u);
}

TEST(AtlasMutants, AFlippedSignIsDetected) {
    EXPECT_GT(errors_of(Mutant::flipped_sign, 1).wrong, 2000u);
}

TEST(AtlasMutants, AnEpsilonIsDetectedOnSmallMeshes) {
    EXPECT_EQ(errors_of(Mutant::epsilon, 1e-3).missed, 4000u);
}

TEST(AtlasMutants, ContractionIsDetected) {
    EXPECT_GT(errors_of(Mutant::contraction, 1).missed, 4u);  // 177 of 20,000 edge rays elsewhere
}

}  // namespace
}  // namespace sightline
