#include "shade/ggx_energy.h"

#include "shade/ggx.h"

#include <algorithm>
#include <array>

namespace sightline {
namespace {

constexpr int cells = 16;   // of the table, in roughness and in cosine
constexpr int strata = 16;  // of the integration, in each dimension

/// Directional albedo of a white lobe: the mean weight of rays sampled by visible normals.
float albedo(float cos_o, float roughness) {
    const Vec3 n(0, 0, 1), wo(std::sqrt(std::max(0.0f, 1 - cos_o * cos_o)), 0, cos_o);
    const Ggx lobe(n, roughness * roughness);
    float sum = 0;
    for (int i = 0; i < strata * strata; ++i) {
        const Vec2 u((static_cast<float>(i % strata) + 0.5f) / strata,
                     (static_cast<float>(i / strata) + 0.5f) / strata);
        const Vec3 h = lobe.sample(wo, u);
        const Vec3 wi = h * (2 * dot(wo, h)) - wo;
        if (wi.z > 0) sum += smith_reflection_weight(cos_o, lobe.slant(wo), wi.z, lobe.slant(wi));
    }
    return sum / (strata * strata);
}

/// (1 − E)/E at the corners of the cells; the first column stands just above the horizon.
class Table {
  public:
    Table() {
        for (int r = 0; r <= cells; ++r) {
            for (int c = 0; c <= cells; ++c) {
                const float roughness = std::max(static_cast<float>(r) / cells, 0.01f);
                const float e = albedo(std::max(static_cast<float>(c) / cells, 0.005f), roughness);
                values_[static_cast<size_t>(r * (cells + 1) + c)] = (1 - e) / e;
            }
        }
    }

    float at(float cos_o, float roughness) const {
        const float x = std::clamp(cos_o, 0.0f, 1.0f) * cells;
        const float y = std::clamp(roughness, 0.0f, 1.0f) * cells;
        const int c = std::min(static_cast<int>(x), cells - 1);
        const int r = std::min(static_cast<int>(y), cells - 1);
        const float fx = x - static_cast<float>(c), fy = y - static_cast<float>(r);
        const float* row = &values_[static_cast<size_t>(r * (cells + 1) + c)];
        const float* next = row + cells + 1;
        return (row[0] * (1 - fx) + row[1] * fx) * (1 - fy) +
               (next[0] * (1 - fx) + next[1] * fx) * fy;
    }

  private:
    std::array<float, (cells + 1) * (cells + 1)> values_;
};

}  // namespace

float missing_energy(float cos_o, float roughness) {
    static const Table table;
    return table.at(cos_o, roughness);
}

}  // namespace sightline
