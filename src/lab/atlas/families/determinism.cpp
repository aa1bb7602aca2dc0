#include "lab/atlas/families.h"

#include "lab/atlas/meshes.h"
#include "lab/atlas/scene_experiment.h"

namespace sightline {
namespace {

struct Build {
    std::string label;
    EmbreeOptions options;
};

bool processor_has(const std::string& isa) {
    __builtin_cpu_init();
    return isa == "sse2" || (isa == "sse4.2" && __builtin_cpu_supports("sse4.2")) ||
           (isa == "avx" && __builtin_cpu_supports("avx")) ||
           (isa == "avx2" && __builtin_cpu_supports("avx2")) ||
           (isa == "avx512" && __builtin_cpu_supports("avx512dq"));
}

const std::vector<Build>& builds() {
    static const std::vector<Build> all = [] {
        std::vector<Build> result;
        for (const char* isa : {"sse2", "sse4.2", "avx", "avx2", "avx512"})
            if (processor_has(isa)) result.push_back({isa, {.isa = isa, .threads = 1}});
        result.push_back({"all threads", {}});
        result.push_back({"again", {}});
        result.push_back({"low quality", {.quality = BuildQuality::low}});
        result.push_back({"high quality", {.quality = BuildQuality::high}});
        return result;
    }();
    return all;
}

/// Rays from inside a closed mesh to its vertices, its edges and the insides of its triangles.
Experiment closed_mesh(const ExperimentRequest& request) {
    Rng rng(request.seed);
    std::vector<Mesh> meshes;
    meshes.push_back(closed_globe(64, random_rotation(rng)));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d origin = rng.in_cube(0.3);
        const Vec3d target = random_target(meshes[0], static_cast<Target>(i % 3), rng);
        rays.push_back(aimed_ray(origin, target, rng));
    }
    return make_scene_experiment({scene_of_meshes(std::move(meshes)), std::move(rays)},
                                 builds()[static_cast<size_t>(request.knob)].options);
}

}  // namespace

std::vector<Family> determinism_families() {
    std::vector<std::string> labels;
    for (const Build& build : builds()) labels.push_back(build.label);
    return {{"V1",
             "instruction sets, threads and builds",
             "build",
             numbered(labels),
             {"embree", "embree-default", "embree-single", "embree-default-single", "exact"},
             closed_mesh}};
}

}  // namespace sightline
