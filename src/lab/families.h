#pragma once
// The makers of the families; each file appends its own.
#include "lab/atlas.h"

namespace sightline {

void add_triangle_families(std::vector<Family>& families);
void add_box_families(std::vector<Family>& families);
void add_sphere_families(std::vector<Family>& families);
void add_implicit_families(std::vector<Family>& families);
void add_bounce_families(std::vector<Family>& families);
void add_inside_families(std::vector<Family>& families);
void add_refraction_families(std::vector<Family>& families);
void add_determinism_family(std::vector<Family>& families);

/// Powers of `base` from base^first to base^last.
std::vector<KnobValue> powers(double base, int first, int last, int step = 1);

}  // namespace sightline
