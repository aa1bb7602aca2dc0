#include "lab/atlas/families.h"

namespace sightline {

const std::vector<Family>& atlas_families() {
    static const std::vector<Family> families = [] {
        std::vector<Family> all;
        for (auto* make : {triangle_families, box_families, sphere_families, implicit_families,
                           bounce_families, inside_families, refraction_families, media_families,
                           mirror_families, nesting_families, determinism_families})
            for (Family& family : make()) all.push_back(std::move(family));
        return all;
    }();
    return families;
}

std::vector<KnobValue> powers(double base, int first, int last, int step) {
    std::vector<KnobValue> values;
    for (int i = first; i <= last; i += step) values.push_back({std::pow(base, i)});
    return values;
}

std::vector<KnobValue> zero_and_powers(double base, int first, int last) {
    std::vector<KnobValue> values = powers(base, first, last);
    values.insert(values.begin(), KnobValue{0});
    return values;
}

std::vector<KnobValue> numbered(const std::vector<std::string>& labels) {
    std::vector<KnobValue> values;
    for (const std::string& label : labels)
        values.push_back({static_cast<double>(values.size()), label});
    return values;
}

}  // namespace sightline
