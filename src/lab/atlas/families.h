#pragma once
// The families of the atlas: each is one way to be difficult, with a knob for how difficult. The
// sources in families/ implement one kind each.
#include "lab/atlas/experiment.h"
#include "lab/atlas/rng.h"

namespace sightline {

struct KnobValue {
    double value;
    std::string label = {};  ///< empty: the number
};

struct ExperimentRequest {
    double knob;
    size_t rays;
    uint64_t seed;
};

struct Family {
    std::string name, title;
    std::string knob;                  ///< what its values mean; difficulty grows with the value
    std::vector<KnobValue> values;     ///< ascending
    std::vector<std::string> methods;  ///< that apply
    std::function<Experiment(const ExperimentRequest&)> make;
    bool false_hits_are_wrong = true;  ///< false: they cost time only, as with bounding boxes
};

/// T1 to T7 and X1: rays against triangle meshes, by every engine.
std::vector<Family> triangle_families();
/// B1 to B4: a ray against one axis-aligned box.
std::vector<Family> box_families();
/// S1 to S5: a ray against one sphere, or two about the same centre.
std::vector<Family> sphere_families();
/// Q1 to Q3, I1 and I2: all roots of a ray on a torus and on a heart.
std::vector<Family> implicit_families();
/// N1 and N2: a ray that leaves a triangle must not hit it again, and should start close to it.
std::vector<Family> bounce_families();
/// P1: inside or outside of a closed mesh.
std::vector<Family> inside_families();
/// R1 and R2: reflectance and total reflection, from a cosine and a refractive index.
std::vector<Family> refraction_families();
/// R3g and R3o: the medium behind surfaces of glass and liquid in contact.
std::vector<Family> media_families();
/// R4: light between two parallel mirrors, a geometric series that renders end.
std::vector<Family> mirror_families();
/// X2: the accuracy of a triangle whose matrix is a product of many.
std::vector<Family> nesting_families();
/// V1: the same rays on several instruction sets and builds, for comparison by hash.
std::vector<Family> determinism_families();

/// All of them, in the order of docs/atlas.md.
const std::vector<Family>& atlas_families();

/// Powers of `base` from base^first to base^last.
std::vector<KnobValue> powers(double base, int first, int last, int step = 1);

/// The same after a value of 0.
std::vector<KnobValue> zero_and_powers(double base, int first, int last);

/// 0, 1, 2, … with these labels, for knobs that number cases.
std::vector<KnobValue> numbered(const std::vector<std::string>& labels);

/// The names of methods, or of anything else that has a `name`.
template <class List>
std::vector<std::string> names_of(const List& list) {
    std::vector<std::string> names;
    for (const auto& item : list) names.emplace_back(item.name);
    return names;
}

/// A family whose experiments have as many random cases as requested.
template <class Case, class Truth>
Family random_family(std::string name, std::string title, std::string knob,
                     std::vector<KnobValue> values, const Problem<Case, Truth>& problem,
                     Case (*random_case)(double knob, Rng& rng)) {
    const auto make = [problem, random_case](const ExperimentRequest& request) {
        Rng rng(request.seed);
        std::vector<Case> cases;
        for (size_t i = 0; i < request.rays; ++i) cases.push_back(random_case(request.knob, rng));
        return make_experiment(problem, std::move(cases));
    };
    return {std::move(name),   std::move(title),          std::move(knob),
            std::move(values), names_of(problem.methods), make};
}

}  // namespace sightline
