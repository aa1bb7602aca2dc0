#include "exact/refraction.h"

#include "exact/dyadic.h"

namespace sightline {

ExactRefraction exact_refraction(float cos_i, float eta) {
    const Dyadic c = exact_dyadic(cos_i), n = exact_dyadic(eta);
    const Dyadic squared = n * n - Dyadic(1.0) + c * c;  // (eta · cos_t)²
    if (squared.sign() <= 0) return {true, 0, 1};
    const double g = rounded_cosine(squared, squared);  // x/√x is √x
    const double ci = exact_double(cos_i), ratio = exact_double(eta);
    const double s = (g - ci) / (g + ci);
    const double p = (ratio * ratio * ci - g) / (ratio * ratio * ci + g);
    return {false, g / ratio, 0.5 * (s * s + p * p)};
}

}  // namespace sightline
