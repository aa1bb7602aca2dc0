#include "shade/fresnel.h"

#include "shade/fast_math.h"

#include <algorithm>

namespace sightline {
namespace {

float schlick(float f0, float cosine) { return f0 + (1 - f0) * pow5(1 - cosine); }

float normal_reflectance(float n1, float n2) {
    const float r = (n2 - n1) / (n2 + n1);
    return r * r;
}

/// One Gaussian of the Fourier transform of a colour matching function; the optical path difference
/// is phase/2π metres.
float gaussian(float value, float position, float variance, float phase, float shift) {
    return value * std::sqrt(2 * pi * variance) * std::cos(position * phase + shift) *
           std::exp(-variance * phase * phase);
}

/// Response in linear Rec. 709 to interference at the optical path difference `opd` (nm), with a
/// phase shift per channel: the Gaussian fit to CIE XYZ of Belcour and Barla (equation 10,
/// supplement).
Vec3 sensitivity(float opd, const Vec3& shift) {
    const float phase = 2 * pi * opd * 1e-9f;
    const float x = gaussian(5.4856e-13f, 1.6810e6f, 4.3278e9f, phase, shift.x) +
                    gaussian(9.7470e-14f, 2.2399e6f, 4.5282e9f, phase, shift.x);
    const float y = gaussian(4.4201e-13f, 1.7953e6f, 9.3046e9f, phase, shift.y);
    const float z = gaussian(5.2481e-13f, 2.2084e6f, 6.6121e9f, phase, shift.z);
    const Vec3 xyz = Vec3(x, y, z) / 1.0685e-7f;
    return {3.2404542f * xyz.x - 1.5371385f * xyz.y - 0.4985314f * xyz.z,
            -0.9692660f * xyz.x + 1.8760108f * xyz.y + 0.0415560f * xyz.z,
            0.0556434f * xyz.x - 0.2040259f * xyz.y + 1.0572252f * xyz.z};
}

}  // namespace

Vec3 fresnel_thin_film(float cos_i, float film_ior, float thickness, const Vec3& f0) {
    // A film that thins out to nothing becomes air.
    const float x = std::clamp(thickness / 0.03f, 0.0f, 1.0f);
    const float film = 1 + (film_ior - 1) * (x * x * (3 - 2 * x));
    const float cos2_squared = 1 - (1 - cos_i * cos_i) / (film * film);
    if (cos2_squared < 0) return Vec3(1);
    const float cos2 = std::sqrt(cos2_squared);

    const float r12 = schlick(normal_reflectance(1, film), cos_i), t121 = 1 - r12;
    const float phi21 = film < 1 ? 0 : pi;
    const float opd = 2 * film * thickness * cos2;
    Vec3 constant, amplitude, phase, reflected;
    for (int i = 0; i < 3; ++i) {
        const float root = std::sqrt(std::clamp(f0[i], 0.0f, 0.9999f));
        const float base = (1 + root) / (1 - root);
        const float r23 = schlick(normal_reflectance(film, base), cos2);
        phase[i] = phi21 + (base < film ? pi : 0);
        amplitude[i] = std::sqrt(std::clamp(r12 * r23, 1e-5f, 0.9999f));
        constant[i] = t121 * t121 * r23 / (1 - amplitude[i] * amplitude[i]);
        reflected[i] = r12 + constant[i];
    }
    Vec3 weight = constant - Vec3(t121);
    for (int m = 1; m <= 2; ++m) {
        const auto order = static_cast<float>(m);
        weight *= amplitude;
        reflected += weight * sensitivity(order * opd, phase * order) * 2.0f;
    }
    for (int i = 0; i < 3; ++i) reflected[i] = std::clamp(reflected[i], 0.0f, 1.0f);
    return reflected;
}

}  // namespace sightline
