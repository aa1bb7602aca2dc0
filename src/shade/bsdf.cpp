#include "shade/bsdf.h"

#include "shade/fast_math.h"
#include "shade/ggx.h"
#include "shade/sheen.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr float inverse_pi = 1 / pi;

/// How the microfacets of the base split light.
struct FresnelSplit {
    Vec3 reflected{0, 0, 0};
    float transmitted = 0;  ///< to the diffuse layer or through the surface; 0 for metals
};

Vec3 mix(const Vec3& a, const Vec3& b, float t) { return a + (b - a) * t; }

/// glTF 2.0 appendix B with the exact Fresnel equations in place of Schlick's fit, and
/// KHR_materials_specular.
Vec3 dielectric_reflectance(const Surface& s, float cosine) {
    const float exact = fresnel_dielectric(cosine, s.eta);
    if (!s.has(feature_specular) && !s.has(feature_iridescence)) return Vec3(exact);
    if (exact >= 1) return Vec3(1);
    const float r = (s.eta - 1) / (s.eta + 1), normal = r * r;
    Vec3 f0 = s.specular_color * normal;
    for (int i = 0; i < 3; ++i) f0[i] = std::min(f0[i], 1.0f) * s.specular;
    const float towards_grazing = normal < 1 ? (exact - normal) / (1 - normal) : 1;
    const Vec3 plain = mix(f0, Vec3(s.specular), towards_grazing);
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

FresnelSplit split_fresnel(const Surface& s, float cosine) {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    if (s.metallic >= 1) return {metal_reflectance(s, cosine), 0};
    const Vec3 dielectric = dielectric_reflectance(s, cosine);
    const float transmitted = (1 - s.metallic) * std::max(0.0f, 1 - max_component(dielectric));
    if (s.metallic <= 0) return {dielectric, transmitted};
    return {mix(dielectric, metal_reflectance(s, cosine), s.metallic), transmitted};
}

bool is_smooth(float roughness) { return roughness < smooth_roughness; }

bool base_is_smooth(const Surface& s) {
    return is_smooth(s.roughness) && !(s.has(feature_anisotropy) && s.anisotropy > 0);
}

/// Between equal media light goes straight on, however rough the boundary.
bool separates_equal_media(const Surface& s) { return std::fabs(s.eta - 1) < 1e-3f; }

/// A thin wall does not bend light, but blurs it the less, the closer its ior is to that of air
/// (KHR_materials_transmission, "Refraction"); from 1.5 on it blurs as much as it does a
/// reflection.
float blur_of_thin_wall(const Surface& s) {
    return s.has(feature_volume) ? 1 : std::clamp(2 * s.ior - 2, 0.0f, 1.0f);
}

/// False if the microfacets of the base reflect nothing at any angle.
bool base_reflects(const Surface& s) {
    return s.metallic > 0 || s.specular > 0 || s.has(feature_iridescence);
}

constexpr float smooth_alpha = smooth_roughness * smooth_roughness;

bool is_anisotropic(const Surface& s) { return s.has(feature_anisotropy) && s.anisotropy > 0; }

/// The larger alpha of the base's lobe.
float base_alpha_along(const Surface& s) {
    const float alpha = s.roughness * s.roughness;
    return is_anisotropic(s) ? alpha + (1 - alpha) * s.anisotropy * s.anisotropy : alpha;
}

/// The lobe of the base with its alphas times `factor`.
Ggx base_lobe(const Surface& s, float factor = 1) {
    const float alpha = std::max(s.roughness * s.roughness * factor, smooth_alpha);
    if (!is_anisotropic(s)) return Ggx(s.ns, alpha);
    return Ggx(s.ns, s.tangent, std::max(base_alpha_along(s) * factor, smooth_alpha), alpha);
}

Ggx transmission_lobe(const Surface& s) { return base_lobe(s, blur_of_thin_wall(s)); }

bool refraction_is_smooth(const Surface& s) {
    return base_is_smooth(s) ||
           (s.has(feature_volume) ? separates_equal_media(s)
                                  : base_alpha_along(s) * blur_of_thin_wall(s) < smooth_alpha);
}

Ggx coat_lobe(const Surface& s) {
    return Ggx(s.coat_normal, s.clearcoat_roughness * s.clearcoat_roughness);
}

/// Sheen and clear coat, for one wo.
struct TopLayers {
    float base_weight = 1;       ///< factor of all light of the base
    float coat_weight = 0;       ///< reflectance of the coat
    float coat_probability = 0;  ///< of sampling the coat's lobe instead of the base's
};

TopLayers top_layers(const Surface& s) {
    TopLayers top;
    if (s.has(feature_sheen)) {
        const float cosine = dot(s.ns, s.wo);
        top.base_weight -= max_component(s.sheen_color) * sheen_albedo(cosine, s.sheen_roughness);
        top.base_weight = std::max(top.base_weight, 0.0f);
    }
    if (!s.has(feature_clearcoat) || (s.has(feature_volume) && !s.front)) return top;
    const float cosine = std::clamp(dot(s.coat_normal, s.wo), 0.0f, 1.0f);
    top.coat_weight = s.clearcoat * fresnel_dielectric(cosine, coat_ior);
    top.base_weight *= 1 - top.coat_weight;
    const Vec3 base = split_fresnel(s, dot(s.ns, s.wo)).reflected * top.base_weight;
    top.coat_probability =
        top.coat_weight > 0 ? top.coat_weight / (top.coat_weight + luminance(base)) : 0;
    return top;
}

/// A GGX lobe with a Fresnel reflectance of 1, times |cos|, and the pdf of its sampling.
struct LobeEval {
    float value = 0, pdf = 0;
};

LobeEval eval_reflection_lobe(const Ggx& lobe, const Vec3& n, const Vec3& wo, const Vec3& wi,
                              const Vec3& h) {
    const float cos_o = dot(n, wo), cos_i = dot(n, wi);
    if (cos_o <= 0 || cos_i <= 0) return {};
    const float smith_o = lobe.smith_term(wo), smith_i = lobe.smith_term(wi);
    const float pdf = lobe.reflection_pdf(h, cos_o, smith_o);
    return {pdf * smith_reflection_weight(cos_o, smith_o, cos_i, smith_i), pdf};
}

/// The Lambertian lobe below the microfacets and the sheen above them, times |cos|.
Vec3 eval_diffuse_reflection(const Surface& s, const Vec3& wi, const Vec3& h, float transmitted,
                             const TopLayers& top) {
    const float cos_i = dot(s.ns, wi);
    const float share =
        transmitted * (1 - s.transmission) * (1 - s.diffuse_transmission) * top.base_weight;
    Vec3 sum = s.base_color * (share * inverse_pi * cos_i);
    if (s.has(feature_sheen)) {
        const float cos_o = dot(s.ns, s.wo);
        sum += s.sheen_color * ((1 - top.coat_weight) * cos_i *
                                sheen_lobe(cos_i, cos_o, dot(s.ns, h), s.sheen_roughness));
    }
    return sum;
}

void eval_reflection(const Surface& s, const Vec3& wi, BsdfEval& result) {
    const TopLayers top = top_layers(s);
    const Vec3 h = normalize(s.wo + wi);
    const FresnelSplit base = split_fresnel(s, dot(s.wo, h));
    result.diffuse = eval_diffuse_reflection(s, wi, h, base.transmitted, top);
    if (!base_is_smooth(s) && base_reflects(s)) {
        const LobeEval lobe = eval_reflection_lobe(base_lobe(s), s.ns, s.wo, wi, h);
        result.glossy = base.reflected * (lobe.value * top.base_weight);
        result.pdf = lobe.pdf * (1 - top.coat_probability);
    }
    if (top.coat_weight > 0 && !is_smooth(s.clearcoat_roughness)) {
        const LobeEval lobe = eval_reflection_lobe(coat_lobe(s), s.coat_normal, s.wo, wi, h);
        result.glossy += Vec3(lobe.value * top.coat_weight);
        result.pdf += lobe.pdf * top.coat_probability;
    }
}

/// Rough refraction (Walter et al. 2007, equations 17 and 21), without the factor eta² that
/// radiance gains across the boundary: it cancels between entry and exit, and nothing inside emits.
/// Also returns the microfacet normal.
LobeEval eval_refraction_lobe(const Surface& s, const Vec3& wi, Vec3& h) {
    h = normalize(s.wo + wi * s.eta);
    if (dot(h, s.ns) < 0) h = -h;
    const float cos_oh = dot(s.wo, h), cos_ih = dot(wi, h);
    if (cos_oh <= 0 || cos_ih >= 0) return {};
    const Ggx lobe = transmission_lobe(s);
    const float cos_o = dot(s.ns, s.wo), cos_i = -dot(s.ns, wi);
    const float denominator = cos_oh + s.eta * cos_ih;
    const float jacobian = s.eta * s.eta * -cos_ih / (denominator * denominator);
    const float smith_o = lobe.smith_term(s.wo);
    // reflection_pdf holds 1/(4 cos_oh), the Jacobian of mirroring.
    const float pdf = lobe.reflection_pdf(h, cos_o, smith_o) * 4 * cos_oh * jacobian;
    return {pdf * smith_g1(cos_i, lobe.smith_term(wi)), pdf};
}

void eval_transmission(const Surface& s, const Vec3& wi, BsdfEval& result) {
    const TopLayers top = top_layers(s);
    if (s.has(feature_diffuse_transmission)) {
        const float cos_i = -dot(s.ns, wi);
        const Vec3 mirrored = wi + s.ns * (2 * cos_i);
        const float transmitted =
            split_fresnel(s, dot(s.wo, normalize(s.wo + mirrored))).transmitted;
        result.diffuse = s.diffuse_transmission_color *
                         (transmitted * (1 - s.transmission) * s.diffuse_transmission *
                          top.base_weight * inverse_pi * cos_i);
    }
    if (!s.has(feature_transmission) || refraction_is_smooth(s)) return;
    Vec3 h;
    LobeEval lobe;
    if (s.has(feature_volume)) {
        lobe = eval_refraction_lobe(s, wi, h);
    } else {
        // A thin wall transmits with the lobe of reflection, mirrored to the other side.
        const Vec3 mirrored = wi - s.ns * (2 * dot(s.ns, wi));
        h = normalize(s.wo + mirrored);
        lobe = eval_reflection_lobe(transmission_lobe(s), s.ns, s.wo, mirrored, h);
    }
    if (lobe.pdf <= 0) return;
    const float share =
        split_fresnel(s, dot(s.wo, h)).transmitted * s.transmission * top.base_weight;
    result.glossy = s.base_color * (lobe.value * share);
    result.pdf = lobe.pdf;
}

/// The mirror direction, if the lobe that `u_lobe` chooses is smooth; two smooth lobes of one
/// normal share a sample. `base`: the split at the shading normal.
bool sample_smooth_reflection(const Surface& s, const TopLayers& top, const FresnelSplit& base,
                              float u_lobe, BsdfSample& sample) {
    const bool base_smooth = base_is_smooth(s);
    const bool coat_smooth = top.coat_weight > 0 && is_smooth(s.clearcoat_roughness);
    const bool samples_coat = u_lobe < top.coat_probability;
    if (samples_coat ? !coat_smooth : !base_smooth) return false;
    const Vec3 reflected = base.reflected * top.base_weight;
    if (top.coat_weight <= 0) {
        sample = {reflect(s.wo, s.ns), reflected};
    } else if (base_smooth && coat_smooth && s.coat_normal == s.ns) {
        sample = {reflect(s.wo, s.ns), reflected + Vec3(top.coat_weight)};
    } else if (samples_coat) {
        sample = {reflect(s.wo, s.coat_normal), Vec3(top.coat_weight / top.coat_probability)};
    } else {
        sample = {reflect(s.wo, s.ns), reflected / (1 - top.coat_probability)};
    }
    return true;
}

bool sample_rough_reflection(const Surface& s, const TopLayers& top, Vec2 u, float u_lobe,
                             BsdfSample& sample) {
    const bool samples_coat = u_lobe < top.coat_probability;
    if (!samples_coat && !base_reflects(s)) return false;
    const Ggx lobe = samples_coat ? coat_lobe(s) : base_lobe(s);
    const Vec3& n = samples_coat ? s.coat_normal : s.ns;
    const Vec3 h = lobe.sample(s.wo, u);
    sample.direction = reflect(s.wo, h);
    if (top.coat_weight > 0) {
        const BsdfEval value = eval_bsdf(s, sample.direction);
        sample.pdf = value.pdf;
        sample.weight = sample.pdf > 0 ? value.glossy / sample.pdf : Vec3(0);
        return sample.pdf > 0;
    }
    const float cos_o = dot(n, s.wo), cos_i = dot(n, sample.direction);
    if (cos_i <= 0 || cos_o <= 0) return false;
    const float smith_o = lobe.smith_term(s.wo), smith_i = lobe.smith_term(sample.direction);
    sample.pdf = lobe.reflection_pdf(h, cos_o, smith_o);
    const float weight = smith_reflection_weight(cos_o, smith_o, cos_i, smith_i);
    sample.weight = split_fresnel(s, dot(s.wo, h)).reflected * (weight * top.base_weight);
    return true;
}

/// True on the far side of both the shading and the geometric normal.
bool is_transmitted(const Surface& s, const Vec3& direction) {
    return dot(s.ns, direction) < 0 && dot(s.ng, direction) < 0;
}

/// The weight of transmission in one direction.
Vec3 smooth_transmission(const Surface& s, const TopLayers& top, const FresnelSplit& base) {
    return s.base_color * (s.transmission * top.base_weight * base.transmitted);
}

bool sample_smooth_transmission(const Surface& s, const TopLayers& top, const FresnelSplit& base,
                                BsdfSample& sample) {
    sample.direction = -s.wo;
    sample.unbent = transmission_is_unbent(s);
    if (!sample.unbent && !refract(s.wo, s.ns, s.eta, sample.direction)) return false;
    if (!is_transmitted(s, sample.direction)) return false;
    sample.weight = smooth_transmission(s, top, base);
    return true;
}

bool sample_rough_transmission(const Surface& s, const TopLayers& top, Vec2 u, BsdfSample& sample) {
    const bool volume = s.has(feature_volume);
    const Ggx lobe = transmission_lobe(s);
    const Vec3 h = lobe.sample(s.wo, u);
    if (volume) {
        if (!refract(s.wo, h, s.eta, sample.direction)) return false;
    } else {
        const Vec3 mirrored = reflect(s.wo, h);
        sample.direction = mirrored - s.ns * (2 * dot(s.ns, mirrored));
    }
    if (!is_transmitted(s, sample.direction)) return false;
    float weight = s.transmission * top.base_weight * split_fresnel(s, dot(s.wo, h)).transmitted;
    const float cos_o = dot(s.ns, s.wo), cos_i = -dot(s.ns, sample.direction);
    const float smith_o = lobe.smith_term(s.wo), smith_i = lobe.smith_term(sample.direction);
    sample.pdf = lobe.reflection_pdf(h, cos_o, smith_o);
    if (volume) {
        const float cos_oh = dot(s.wo, h), cos_ih = dot(sample.direction, h);
        const float denominator = cos_oh + s.eta * cos_ih;
        sample.pdf *= 4 * cos_oh * s.eta * s.eta * -cos_ih / (denominator * denominator);
        weight *= smith_g1(cos_i, smith_i);
    } else {
        weight *= smith_reflection_weight(cos_o, smith_o, cos_i, smith_i);
    }
    sample.weight = s.base_color * weight;
    return true;
}

bool carries_light(const BsdfSample& sample) { return max_component(sample.weight) > 0; }

}  // namespace

bool refract(const Vec3& wo, const Vec3& n, float eta, Vec3& refracted) {
    const float cos_o = dot(wo, n);
    const float ratio = 1 / eta;
    const float sin2_t = ratio * ratio * std::max(0.0f, 1 - cos_o * cos_o);
    if (!(sin2_t < 1)) return false;
    refracted = normalize(n * (ratio * cos_o - std::sqrt(1 - sin2_t)) - wo * ratio);
    return true;
}

BsdfEval eval_bsdf(const Surface& surface, const Vec3& wi) {
    BsdfEval result;
    if (surface.has(feature_unlit)) return result;
    if (dot(surface.ns, wi) > 0) {
        eval_reflection(surface, wi, result);
    } else if (surface.features & (feature_transmission | feature_diffuse_transmission)) {
        eval_transmission(surface, wi, result);
    }
    return result;
}

int sample_bsdf(const Surface& surface, Vec2 u_reflect, Vec2 u_refract, float u_lobe,
                std::array<BsdfSample, 2>& samples) {
    if (surface.has(feature_unlit)) return 0;
    const TopLayers top = top_layers(surface);
    const bool smooth_refraction = refraction_is_smooth(surface);
    FresnelSplit view_split;  // at the shading normal; unused if all lobes are rough
    if (smooth_refraction || top.coat_weight > 0)
        view_split = split_fresnel(surface, dot(surface.ns, surface.wo));
    int count = 0;
    BsdfSample sample;
    if (sample_smooth_reflection(surface, top, view_split, u_lobe, sample) ||
        sample_rough_reflection(surface, top, u_reflect, u_lobe, sample)) {
        if (carries_light(sample) && dot(sample.direction, surface.ng) > 0)
            samples[0] = sample, count = 1;
    }
    if (surface.transmission > 0 && surface.metallic < 1) {
        sample = {};
        if ((smooth_refraction ? sample_smooth_transmission(surface, top, view_split, sample)
                               : sample_rough_transmission(surface, top, u_refract, sample)) &&
            carries_light(sample)) {
            const bool volume = surface.has(feature_volume);
            sample.refracted = true;
            sample.enters_volume = volume && surface.front;
            sample.leaves_volume = volume && !surface.front;
            samples[static_cast<size_t>(count++)] = sample;
        }
    }
    return count;
}

bool transmission_is_unbent(const Surface& s) {
    return s.has(feature_volume) ? separates_equal_media(s) : refraction_is_smooth(s);
}

LayerTransmittance layer_transmittance(const Surface& s) {
    LayerTransmittance result{Vec3(1 - s.alpha)};
    if (s.alpha <= 0 || !(s.transmission > 0) || s.metallic >= 1) return result;
    const Vec3 passed = smooth_transmission(s, top_layers(s), split_fresnel(s, dot(s.ns, s.wo)));
    (transmission_is_unbent(s) ? result.unbent : result.bent) += passed * s.alpha;
    return result;
}

bool is_rough(const Surface& s) {
    if (s.has(feature_unlit)) return false;
    return (!base_is_smooth(s) && base_reflects(s)) ||
           (s.transmission > 0 && !refraction_is_smooth(s)) ||
           (s.has(feature_clearcoat) && s.clearcoat > 0 && !is_smooth(s.clearcoat_roughness));
}

bool scatters(const Surface& s) {
    return is_rough(s) || s.has(feature_sheen) || s.has(feature_diffuse_transmission) ||
           (s.metallic < 1 && s.transmission < 1 && !s.has(feature_unlit));
}

float max_reflectance(const Material& m) {
    if (m.unlit) return 0;
    const Vec3 base(m.base_color_factor.x, m.base_color_factor.y, m.base_color_factor.z);
    const bool metal = m.metallic_factor > 0;
    const bool coat = m.clearcoat_factor > 0, film = m.iridescence_factor > 0;
    // At grazing angles every boundary reflects everything, whatever its f0.
    float largest = metal || coat || film ? 1 : m.specular_factor;
    if (m.transmission_factor > 0) {
        largest = std::max(
            {largest, m.ior != 1 ? 1.0f : 0.0f, m.transmission_factor * max_component(base)});
    }
    return std::min(largest, 1.0f);
}

}  // namespace sightline
