// Traces rays to a sphere of triangles with two engines, counts the rays on which their hits
// differ, and checks these with the exact referee.
//
// The rays are aimed at vertices and at edges, where float arithmetic decides what is hit. Names of
// other engines: `sightline compare --help`.
#include "exact/referee.h"
#include "intersect/engines.h"
#include "scene/mesh_makers.h"
#include "scene/scene_builder.h"

#include <fmt/format.h>

#include <array>
#include <random>
#include <string>
#include <vector>

using namespace sightline;

namespace {

/// Rays from near the centre to the vertices (every other ray) and the edges of a mesh.
std::vector<Ray> rays_to_vertices_and_edges(const Mesh& mesh, size_t count) {
    std::mt19937 random(1);
    const auto between = [&](float low, float high) {
        return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
    };
    std::vector<Ray> rays(count);
    for (size_t i = 0; i < count; ++i) {
        const auto& triangle = mesh.triangles[random() % mesh.triangles.size()];
        const Vec3 a = mesh.positions[triangle[0]], b = mesh.positions[triangle[1]];
        const Vec3 target = i % 2 == 0 ? a : a + (b - a) * between(0, 1);
        for (int axis = 0; axis < 3; ++axis) rays[i].origin[axis] = between(-0.3f, 0.3f);
        rays[i].direction = target - rays[i].origin;
    }
    return rays;
}

bool is_right(Verdict verdict) { return verdict == Verdict::same || verdict == Verdict::tie; }

}  // namespace

int main() {
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(sphere_mesh(48, 96)));
    const Scene scene = builder.finish();
    const std::vector<Ray> rays = rays_to_vertices_and_edges(scene.meshes[0], 5000);

    const std::array<std::string, 2> names = {"embree-default", "exact"};
    const std::vector<Engine> engines = make_engines(scene, names);
    std::array<std::vector<Hit>, 2> hits;
    for (size_t e = 0; e < 2; ++e) {
        hits[e].resize(rays.size());
        engines[e].intersector->closest(rays, hits[e], Coherence::incoherent);
    }

    const Referee referee(scene);
    size_t different = 0;
    std::array<size_t, 2> right{};
    for (size_t i = 0; i < rays.size(); ++i) {
        if (surface_of(hits[0][i]) == surface_of(hits[1][i])) continue;
        ++different;
        for (size_t e = 0; e < 2; ++e) right[e] += is_right(referee.judge(rays[i], hits[e][i]));
    }
    fmt::print("{} of {} hits differ.\n", different, rays.size());
    for (size_t e = 0; e < 2; ++e)
        fmt::print("{} is right in {} of them.\n", engines[e].name, right[e]);
}
