#include "lab/atlas/families.h"

namespace sightline {

std::vector<KnobValue> powers(double base, int first, int last, int step) {
    std::vector<KnobValue> values;
    for (int i = first; i <= last; i += step) values.push_back({std::pow(base, i)});
    return values;
}

const std::vector<Family>& atlas_families() {
    static const std::vector<Family> families = [] {
        std::vector<Family> result;
        add_triangle_families(result);
        add_box_families(result);
        add_sphere_families(result);
        add_implicit_families(result);
        add_bounce_families(result);
        add_inside_families(result);
        add_refraction_families(result);
        add_media_family(result);
        add_depth_family(result);
        add_nesting_family(result);
        add_determinism_family(result);
        return result;
    }();
    return families;
}

}  // namespace sightline
