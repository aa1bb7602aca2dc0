#include "shade/sheen.h"

#include "core/math.h"

#include <algorithm>
#include <array>

namespace sightline {
namespace {

/// Directional albedo over roughness and cosine, integrated once by the midpoint rule.
class AlbedoTable {
  public:
    AlbedoTable() {
        for (int r = 0; r < size; ++r) {
            for (int c = 0; c < size; ++c) at(r, c) = integrate(coordinate(c), coordinate(r));
        }
    }

    float lookup(float cosine, float roughness) const {
        const float x = std::clamp(cosine, 0.0f, 1.0f) * (size - 1);
        const float y = std::clamp(roughness, 0.0f, 1.0f) * (size - 1);
        const int x0 = std::min(static_cast<int>(x), size - 2);
        const int y0 = std::min(static_cast<int>(y), size - 2);
        const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
        const float low = value(y0, x0) * (1 - fx) + value(y0, x0 + 1) * fx;
        const float high = value(y0 + 1, x0) * (1 - fx) + value(y0 + 1, x0 + 1) * fx;
        return low * (1 - fy) + high * fy;
    }

  private:
    static constexpr int size = 24;
    static float coordinate(int i) { return std::max(static_cast<float>(i) / (size - 1), 0.02f); }
    float& at(int r, int c) { return values_[static_cast<size_t>(r * size + c)]; }
    float value(int r, int c) const { return values_[static_cast<size_t>(r * size + c)]; }

    static float integrate(float cos_o, float roughness) {
        constexpr int steps = 32;
        const float sin_o = std::sqrt(1 - cos_o * cos_o);
        float sum = 0;
        for (int i = 0; i < steps; ++i) {
            const float cos_i = (static_cast<float>(i) + 0.5f) / steps;
            const float sin_i = std::sqrt(1 - cos_i * cos_i);
            for (int j = 0; j < steps; ++j) {
                const float phi = pi * (static_cast<float>(j) + 0.5f) / steps;
                const float cosine = sin_o * sin_i * std::cos(phi) + cos_o * cos_i;
                const float cos_h = (cos_i + cos_o) / std::sqrt(2 + 2 * cosine);
                sum += sheen_lobe(cos_i, cos_o, cos_h, roughness) * cos_i;
            }
        }
        return std::min(1.0f, sum * 2 * pi / (steps * steps));
    }

    std::array<float, static_cast<size_t>(size) * size> values_{};
};

}  // namespace

float sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness) {
    const float alpha = std::max(roughness * roughness, 1e-3f);
    const float sin2_h = std::max(1 - cos_h * cos_h, 0.0f);
    const float inverse = 1 / alpha;
    const float d = (2 + inverse) * std::pow(sin2_h, inverse * 0.5f) / (2 * pi);
    return d / (4 * (cos_i + cos_o - cos_i * cos_o));
}

float sheen_albedo(float cos_o, float roughness) {
    static const AlbedoTable table;
    return table.lookup(cos_o, roughness);
}

}  // namespace sightline
