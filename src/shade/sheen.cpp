#include "shade/sheen.h"

#include "core/math.h"

#include <algorithm>

namespace sightline {
namespace {

/// Smith's Λ of the distribution, as fitted in section 3 of the paper.
class Shadowing {
  public:
    explicit Shadowing(float alpha) {
        const float t = (1 - alpha) * (1 - alpha);
        const auto mix = [t](float rough, float smooth) { return rough + (smooth - rough) * t; };
        a_ = mix(21.5473f, 25.3245f);
        b_ = mix(3.82987f, 3.32435f);
        c_ = mix(0.19823f, 0.16801f);
        d_ = mix(-1.97760f, -1.27393f);
        e_ = mix(-4.32054f, -4.85967f);
    }
    float lambda(float cosine) const {
        if (cosine < 0.5f) return std::exp(logarithm(cosine));
        return std::exp(2 * logarithm(0.5f) - logarithm(1 - cosine));
    }

  private:
    float logarithm(float x) const { return a_ / (1 + b_ * std::pow(x, c_)) + d_ * x + e_; }

    float a_, b_, c_, d_, e_;
};

}  // namespace

float sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness) {
    if (!(cos_i > 0 && cos_o > 0)) return 0;
    const float alpha = std::max(roughness * roughness, 1e-3f);
    const float sin2_h = std::max(1 - cos_h * cos_h, 0.0f);
    const float inverse = 1 / alpha;
    const float d = (2 + inverse) * std::pow(sin2_h, inverse * 0.5f) / (2 * pi);
    const Shadowing shadowing(alpha);
    const float g = 1 / (1 + shadowing.lambda(cos_i) + shadowing.lambda(cos_o));
    return d * g / (4 * cos_i * cos_o);
}

}  // namespace sightline
