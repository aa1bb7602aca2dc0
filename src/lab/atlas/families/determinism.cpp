// The same rays on different instruction sets and builds: the hashes of results tell them apart.
#include "lab/atlas/families.h"
#include "lab/atlas/mesh_making.h"
#include "lab/atlas/scene_trial.h"

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

/// Vertices, edges and anything between of a closed mesh, from within.
std::unique_ptr<Trial> closed_mesh(const TrialRequest& request) {
    Dice dice(request.seed);
    std::vector<Mesh> meshes;
    meshes.push_back(closed_globe(64, random_rotation(dice)));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d origin = dice.vector(0.3);
        const Vec3d target = aimed_point(meshes[0], static_cast<Target>(i % 3), dice);
        rays.push_back(aimed_ray(origin, target, dice));
    }
    return make_scene_trial({scene_of_meshes(std::move(meshes)), std::move(rays)},
                            builds()[static_cast<size_t>(request.knob)].options);
}

}  // namespace

void add_determinism_family(std::vector<Family>& families) {
    std::vector<KnobValue> values;
    for (const Build& build : builds())
        values.push_back({static_cast<double>(values.size()), build.label});
    families.push_back(
        {"V1",
         "instruction sets, threads and builds",
         "build",
         values,
         {"embree", "embree-default", "embree-single", "embree-default-single", "exact"},
         closed_mesh});
}

}  // namespace sightline
