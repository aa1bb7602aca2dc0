#pragma once
// The makers of the families; each file appends its own.
#include "lab/atlas/atlas.h"
#include "lab/atlas/dice.h"

namespace sightline {

void add_triangle_families(std::vector<Family>& families);
void add_box_families(std::vector<Family>& families);
void add_sphere_families(std::vector<Family>& families);
void add_implicit_families(std::vector<Family>& families);
void add_bounce_families(std::vector<Family>& families);
void add_inside_families(std::vector<Family>& families);
void add_refraction_families(std::vector<Family>& families);
void add_media_family(std::vector<Family>& families);
void add_depth_family(std::vector<Family>& families);
void add_nesting_family(std::vector<Family>& families);
void add_determinism_family(std::vector<Family>& families);

/// Powers of `base` from base^first to base^last.
std::vector<KnobValue> powers(double base, int first, int last, int step = 1);

/// Trials of as many cases as rays are asked for, each made of the knob's value and the dice.
template <class CaseTrial, class Case>
auto trials_of(Case (*make_case)(double knob, Dice& dice)) {
    return [make_case](const TrialRequest& request) {
        Dice dice(request.seed);
        std::vector<Case> cases;
        for (size_t i = 0; i < request.rays; ++i) cases.push_back(make_case(request.knob, dice));
        return std::make_unique<CaseTrial>(std::move(cases));
    };
}

}  // namespace sightline
