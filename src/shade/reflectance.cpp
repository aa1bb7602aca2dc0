#include "shade/reflectance.h"

#include "shade/albedo_grid.h"
#include "shade/fast_math.h"
#include "shade/fresnel.h"

#include <algorithm>
#include <array>

namespace sightline {
namespace {

Vec3 mix(const Vec3& a, const Vec3& b, float t) { return a + (b - a) * t; }

/// Reflectance of the dielectric with index `eta` along the normal.
float normal_reflectance(float eta) {
    const float r = (eta - 1) / (eta + 1);
    return r * r;
}

/// KHR_materials_specular's reflectance along the normal.
Vec3 specular_f0(const Surface& s) {
    Vec3 f0 = s.specular_color * normal_reflectance(s.eta);
    for (int i = 0; i < 3; ++i) f0[i] = std::min(f0[i], 1.0f) * s.specular;
    return f0;
}

/// How far the exact reflectance has gone from its value along the normal to 1 at grazing angles;
/// Schlick's fit for an infinite index, whose exact reflectance is 1 everywhere.
float towards_grazing(float eta, float fresnel, float cosine) {
    const float normal = normal_reflectance(eta);
    return normal < 1 ? (fresnel - normal) / (1 - normal) : pow5(1 - cosine);
}

/// `width` values by index and roughness, which `values` computes from both; two nodes of the index
/// are enough for what does not depend on it.
template <size_t iors, size_t roughnesses, size_t width>
class NodeTable {
  public:
    template <class Values>
    explicit NodeTable(const Values& values) {
        auto next = values_.begin();
        for (size_t i = 0; i < iors; ++i) {
            for (size_t r = 0; r < roughnesses; ++r) {
                const std::array<float, width> at_node =
                    values(share(r, roughnesses), ior_axis_eta(share(i, iors)));
                next = std::copy(at_node.begin(), at_node.end(), next);
            }
        }
    }

    std::array<float, width> operator()(float roughness, float eta) const {
        return Table{values_.data()}({ior_axis(eta), roughness});
    }

  private:
    using Table = AlbedoTable<width, iors, roughnesses>;

    static float share(size_t node, size_t nodes) {
        return static_cast<float>(node) / static_cast<float>(nodes - 1);
    }

    std::array<float, Table::size> values_{};
};

/// albedo(cosine) at mean_cosines.
template <class Albedo>
NodeValues at_mean_cosines(const Albedo& albedo) {
    NodeValues values;
    std::ranges::transform(mean_cosines, values.begin(), albedo);
    return values;
}

}  // namespace

Vec3 dielectric_reflectance(const Surface& s, float cosine) {
    const float exact = fresnel_dielectric(cosine, s.eta);
    if (!s.has(feature_specular) && !s.has(feature_iridescence)) return Vec3(exact);
    if (exact >= 1 && s.eta > 0 && s.eta < 1) return Vec3(1);
    const Vec3 f0 = specular_f0(s);
    const Vec3 plain = mix(f0, Vec3(s.specular), towards_grazing(s.eta, exact, cosine));
    if (!s.has(feature_iridescence)) return plain;
    return mix(plain, fresnel_thin_film(cosine, s.iridescence_ior, s.iridescence_thickness, f0),
               s.iridescence);
}

Vec3 metal_reflectance(const Surface& s, float cosine) {
    const Vec3 plain = mix(s.base_color, Vec3(1), pow5(1 - cosine));
    if (!s.has(feature_iridescence)) return plain;
    const Vec3 film =
        fresnel_thin_film(cosine, s.iridescence_ior, s.iridescence_thickness, s.base_color);
    return mix(plain, film, s.iridescence);
}

Vec3 mean_dielectric_reflectance(const Surface& s, const GgxAlbedo& lobe) {
    if (!s.has(feature_specular) && !s.has(feature_iridescence)) return Vec3(lobe.fresnel);
    const float partly = 1 - lobe.totally_reflected;
    if (partly <= 0) return Vec3(1);
    const float fresnel = (lobe.fresnel - lobe.totally_reflected) / partly;
    const Vec3 f0 = specular_f0(s);
    Vec3 mean = mix(f0, Vec3(s.specular), towards_grazing(s.eta, fresnel, lobe.fresnel_cosine));
    if (s.has(feature_iridescence)) {
        const Vec3 film =
            fresnel_thin_film(lobe.fresnel_cosine, s.iridescence_ior, s.iridescence_thickness, f0);
        mean = mix(mean, film, s.iridescence);
    }
    return Vec3(lobe.totally_reflected) + mean * partly;
}

Vec3 dielectric_multiple_scattering(const Surface& s, const GgxAlbedo& lobe) {
    if (s.has(feature_iridescence))
        return multiple_scattering(mean_dielectric_reflectance(s, lobe), lobe.albedo);
    return multiple_scattering(
        s.has(feature_specular) ? specular_f0(s) : Vec3(normal_reflectance(s.eta)), lobe.albedo);
}

Vec3 metal_multiple_scattering(const Surface& s, const GgxAlbedo& lobe) {
    const bool film = s.has(feature_iridescence);
    return multiple_scattering(film ? metal_reflectance(s, lobe.fresnel_cosine) : s.base_color,
                               lobe.albedo);
}

float largest_reflectance(const Surface& s, float fresnel, float cosine) {
    if (!s.has(feature_specular)) return fresnel;
    const float f0 = max_component(specular_f0(s));
    return f0 + (s.specular - f0) * towards_grazing(s.eta, fresnel, cosine);
}

float plain_albedo(const Surface& s, const GgxAlbedo& lobe) {
    const float f0 =
        s.has(feature_specular) ? max_component(specular_f0(s)) : normal_reflectance(s.eta);
    return largest_reflectance(s, lobe.fresnel, lobe.fresnel_cosine) *
           (lobe.albedo + f0 * (1 - lobe.albedo));
}

NodeValues plain_albedos(float roughness, float eta) {
    static const NodeTable<96, 32, mean_nodes> table([](float r, float index) {
        Surface s;
        s.eta = index;
        return at_mean_cosines(
            [&](float cosine) { return plain_albedo(s, ggx_albedo(cosine, r, index)); });
    });
    return table(roughness, eta);
}

float mean_plain_albedo(float roughness, float eta) {
    static const NodeTable<96, 32, 1> table([](float r, float index) {
        const NodeValues albedos = plain_albedos(r, index);
        float mean = 0;
        for (size_t i = 0; i < mean_nodes; ++i) mean += mean_weights[i] * albedos[i];
        return std::array{mean};
    });
    return table(roughness, eta)[0];
}

NodeValues coat_albedos(float roughness) {
    static const NodeTable<2, 64, mean_nodes> table([](float r, float) {
        return at_mean_cosines([r](float cosine) { return coat_albedo(cosine, r); });
    });
    return table(roughness, coat_ior);
}

NodeValues sheen_albedos(float roughness) {
    static const NodeTable<2, 128, mean_nodes> table([](float r, float) {
        return at_mean_cosines([r](float cosine) { return sheen_albedo(cosine, r); });
    });
    return table(roughness, coat_ior);
}

GgxAlbedo coat_lobe_albedo(float cosine, float roughness) {
    return is_smooth(roughness) ? smooth_albedo(cosine, coat_ior)
                                : ggx_albedo(cosine, roughness, coat_ior);
}

float coat_albedo(const GgxAlbedo& lobe) {
    return lobe.fresnel * (lobe.albedo + normal_reflectance(coat_ior) * (1 - lobe.albedo));
}

}  // namespace sightline
