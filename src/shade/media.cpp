#include "shade/media.h"

#include <algorithm>

namespace sightline {

void MediumStack::enter(uint32_t m) {
    if (count < material.size()) material[count++] = static_cast<uint16_t>(m);
}

void MediumStack::leave(uint32_t m) {
    for (uint16_t i = count; i-- > 0;) {
        if (material[i] != m) continue;
        std::copy(material.begin() + i + 1, material.begin() + count, material.begin() + i);
        --count;
        return;
    }
}

MediumStack beyond(const Surface& boundary, MediumStack media) {
    boundary.front ? media.enter(boundary.material) : media.leave(boundary.material);
    return media;
}

Vec3 channel_iors(const Material& m) {
    // n_F − n_C is (n_d − 1) / V_d, and the dispersion is 20 / V_d for the Abbe number V_d.
    const float half_spread = (m.ior - 1) * m.dispersion / 40;
    if (!(half_spread > 0)) return Vec3(m.ior);
    constexpr float largest = 1000;  // its square is finite for any ior of a file
    return {std::max(m.ior - half_spread, 1.0f), m.ior, std::min(m.ior + half_spread, largest)};
}

bool absorbs(const Material& m) {
    return m.thickness_factor > 0 && std::isfinite(m.attenuation_distance) &&
           m.attenuation_distance > 0 && m.attenuation_color != Vec3(1, 1, 1);
}

std::vector<Vec3> absorption_coefficients(const Scene& scene) {
    std::vector<Vec3> result;
    for (const Material& m : scene.materials) {
        const auto coefficient = [&](float color) {
            return -std::log(std::fmax(color, 1e-6f)) / m.attenuation_distance;
        };
        const Vec3& color = m.attenuation_color;
        result.push_back(
            absorbs(m) ? Vec3(coefficient(color.x), coefficient(color.y), coefficient(color.z))
                       : Vec3(0));
    }
    return result;
}

}  // namespace sightline
