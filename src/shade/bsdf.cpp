#include "shade/bsdf.h"

#include "shade/fast_math.h"
#include "shade/ggx.h"
#include "shade/sheen.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr float inverse_pi = 1 / pi;

/// What the microfacets of the base reflect, and what of the rest reaches the layer below them.
struct Split {
    Vec3 reflected{0, 0, 0};
    float below = 0;  ///< to diffuse reflection and transmission; metals have none
};

Vec3 mix(const Vec3& a, const Vec3& b, float t) { return a + (b - a) * t; }

/// The dielectric part of the base: glTF 2.0 appendix B with the exact Fresnel equations in place
/// of Schlick's fit, and KHR_materials_specular.
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

Split split(const Surface& s, float cosine) {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    if (s.metallic >= 1) return {metal_reflectance(s, cosine), 0};
    const Vec3 dielectric = dielectric_reflectance(s, cosine);
    const float below = (1 - s.metallic) * std::max(0.0f, 1 - max_component(dielectric));
    if (s.metallic <= 0) return {dielectric, below};
    return {mix(dielectric, metal_reflectance(s, cosine), s.metallic), below};
}

bool is_smooth(float roughness) { return roughness < smooth_roughness; }

bool base_is_smooth(const Surface& s) {
    return is_smooth(s.roughness) && !(s.has(feature_anisotropy) && s.anisotropy > 0);
}

/// Refraction between equal media bends nothing, however rough the boundary.
bool refraction_is_smooth(const Surface& s) {
    return base_is_smooth(s) || (s.has(feature_volume) && std::fabs(s.eta - 1) < 1e-3f);
}

/// False where the base's microfacets mirror nothing at any angle.
bool base_reflects(const Surface& s) {
    return s.metallic > 0 || s.specular > 0 || s.has(feature_iridescence);
}

Ggx base_lobe(const Surface& s) {
    const float alpha = std::max(s.roughness * s.roughness, smooth_roughness * smooth_roughness);
    if (!s.has(feature_anisotropy) || s.anisotropy <= 0) return Ggx(s.ns, alpha);
    const float along = alpha + (1 - alpha) * s.anisotropy * s.anisotropy;
    return Ggx(s.ns, s.tangent, along, alpha);
}

Ggx coat_lobe(const Surface& s) {
    return Ggx(s.coat_normal, s.clearcoat_roughness * s.clearcoat_roughness);
}

/// The layers over the base: how much of its light they let through, and what the coat reflects.
struct Layers {
    float attenuation = 1;
    float coat = 0;    ///< the coat's reflectance for this view
    float chance = 0;  ///< with which the reflected ray takes the coat's lobe
};

Layers layers(const Surface& s) {
    Layers over;
    if (s.has(feature_sheen)) {
        const float cosine = dot(s.ns, s.wo);
        over.attenuation -= max_component(s.sheen_color) * sheen_albedo(cosine, s.sheen_roughness);
        over.attenuation = std::max(over.attenuation, 0.0f);
    }
    if (!s.has(feature_clearcoat) || (s.has(feature_volume) && !s.front)) return over;
    const float cosine = std::clamp(dot(s.coat_normal, s.wo), 0.0f, 1.0f);
    over.coat = s.clearcoat * fresnel_dielectric(cosine, coat_ior);
    over.attenuation *= 1 - over.coat;
    const Vec3 base = split(s, dot(s.ns, s.wo)).reflected * over.attenuation;
    over.chance = over.coat > 0 ? over.coat / (over.coat + luminance(base)) : 0;
    return over;
}

/// A GGX lobe's reflection of unit Fresnel, times |cos|, and the density of its sampling.
struct LobeValue {
    float value = 0, pdf = 0;
};

LobeValue reflect_lobe(const Ggx& lobe, const Vec3& n, const Vec3& wo, const Vec3& wi,
                       const Vec3& h) {
    const float cos_o = dot(n, wo), cos_i = dot(n, wi);
    if (cos_o <= 0 || cos_i <= 0) return {};
    const float slant_o = lobe.slant(wo), slant_i = lobe.slant(wi);
    const float pdf = lobe.reflection_pdf(h, cos_o, slant_o);
    return {pdf * smith_reflection_weight(cos_o, slant_o, cos_i, slant_i), pdf};
}

/// Lambert's lobe below the microfacets, and the sheen above them.
Vec3 diffuse_reflection(const Surface& s, const Vec3& wi, const Vec3& h, float below,
                        const Layers& over) {
    const float cos_i = dot(s.ns, wi);
    const float share =
        below * (1 - s.transmission) * (1 - s.diffuse_transmission) * over.attenuation;
    Vec3 sum = s.base_color * (share * inverse_pi * cos_i);
    if (s.has(feature_sheen)) {
        const float cos_o = dot(s.ns, s.wo);
        sum += s.sheen_color * ((1 - over.coat) * cos_i *
                                sheen_lobe(cos_i, cos_o, dot(s.ns, h), s.sheen_roughness));
    }
    return sum;
}

void evaluate_reflection(const Surface& s, const Vec3& wi, BsdfValue& result) {
    const Layers over = layers(s);
    const Vec3 h = normalize(s.wo + wi);
    const Split base = split(s, dot(s.wo, h));
    result.diffuse = diffuse_reflection(s, wi, h, base.below, over);
    if (!base_is_smooth(s) && base_reflects(s)) {
        const LobeValue lobe = reflect_lobe(base_lobe(s), s.ns, s.wo, wi, h);
        result.glossy = base.reflected * (lobe.value * over.attenuation);
        result.glossy_pdf = lobe.pdf * (1 - over.chance);
    }
    if (over.coat > 0 && !is_smooth(s.clearcoat_roughness)) {
        const LobeValue lobe = reflect_lobe(coat_lobe(s), s.coat_normal, s.wo, wi, h);
        result.glossy += Vec3(lobe.value * over.coat);
        result.glossy_pdf += lobe.pdf * over.chance;
    }
}

/// Rough refraction of Walter et al. 2007, as radiance that keeps its value across the boundary
/// (the square of eta cancels between entry and exit, and nothing inside emits).
LobeValue refract_lobe(const Surface& s, const Vec3& wi, Vec3& h) {
    h = normalize(s.wo + wi * s.eta);
    if (dot(h, s.ns) < 0) h = -h;
    const float cos_oh = dot(s.wo, h), cos_ih = dot(wi, h);
    if (cos_oh <= 0 || cos_ih >= 0) return {};
    const Ggx lobe = base_lobe(s);
    const float cos_o = dot(s.ns, s.wo), cos_i = -dot(s.ns, wi);
    const float denominator = cos_oh + s.eta * cos_ih;
    const float jacobian = s.eta * s.eta * -cos_ih / (denominator * denominator);
    const float slant_o = lobe.slant(s.wo);
    // reflection_pdf holds 1/(4 cos_oh), the Jacobian of mirroring.
    const float pdf = lobe.reflection_pdf(h, cos_o, slant_o) * 4 * cos_oh * jacobian;
    return {pdf * smith_g1(cos_i, lobe.slant(wi)), pdf};
}

void evaluate_transmission(const Surface& s, const Vec3& wi, BsdfValue& result) {
    const Layers over = layers(s);
    if (s.has(feature_diffuse_transmission)) {
        const float cos_i = -dot(s.ns, wi);
        const Vec3 mirrored = wi + s.ns * (2 * cos_i);
        const float below = split(s, dot(s.wo, normalize(s.wo + mirrored))).below;
        result.diffuse =
            s.diffuse_transmission_color * (below * (1 - s.transmission) * s.diffuse_transmission *
                                            over.attenuation * inverse_pi * cos_i);
    }
    if (!s.has(feature_transmission) || refraction_is_smooth(s)) return;
    Vec3 h;
    LobeValue lobe;
    if (s.has(feature_volume)) {
        lobe = refract_lobe(s, wi, h);
    } else {
        // A thin wall scatters as the lobe of reflection does, mirrored to the other side.
        const Vec3 mirrored = wi - s.ns * (2 * dot(s.ns, wi));
        h = normalize(s.wo + mirrored);
        lobe = reflect_lobe(base_lobe(s), s.ns, s.wo, mirrored, h);
    }
    if (lobe.pdf <= 0) return;
    const float share = split(s, dot(s.wo, h)).below * s.transmission * over.attenuation;
    result.glossy = s.base_color * (lobe.value * share);
    result.glossy_pdf = lobe.pdf;
}

/// The reflected ray of the base and the coat together, where both are mirrors. `base`: of the
/// straight view.
bool reflect_smooth(const Surface& s, const Layers& over, const Split& base, float u_lobe,
                    SecondaryRay& ray) {
    const bool base_smooth = base_is_smooth(s);
    const bool coat_smooth = over.coat > 0 && is_smooth(s.clearcoat_roughness);
    const bool takes_coat = u_lobe < over.chance;
    if (takes_coat ? !coat_smooth : !base_smooth) return false;
    const Vec3 reflected = base.reflected * over.attenuation;
    if (over.coat <= 0) {
        ray = {reflect(s.wo, s.ns), reflected};
    } else if (base_smooth && coat_smooth && s.coat_normal == s.ns) {
        ray = {reflect(s.wo, s.ns), reflected + Vec3(over.coat)};
    } else if (takes_coat) {
        ray = {reflect(s.wo, s.coat_normal), Vec3(over.coat / over.chance)};
    } else {
        ray = {reflect(s.wo, s.ns), reflected / (1 - over.chance)};
    }
    return true;
}

bool reflect_rough(const Surface& s, const Layers& over, Vec2 u, float u_lobe, SecondaryRay& ray) {
    const bool takes_coat = u_lobe < over.chance;
    if (!takes_coat && !base_reflects(s)) return false;
    const Ggx lobe = takes_coat ? coat_lobe(s) : base_lobe(s);
    const Vec3& n = takes_coat ? s.coat_normal : s.ns;
    const Vec3 h = lobe.sample(s.wo, u);
    ray.direction = reflect(s.wo, h);
    if (over.coat > 0) {
        const BsdfValue value = evaluate_bsdf(s, ray.direction);
        ray.pdf = value.glossy_pdf;
        ray.weight = ray.pdf > 0 ? value.glossy / ray.pdf : Vec3(0);
        return ray.pdf > 0;
    }
    const float cos_o = dot(n, s.wo), cos_i = dot(n, ray.direction);
    if (cos_i <= 0 || cos_o <= 0) return false;
    const float slant_o = lobe.slant(s.wo), slant_i = lobe.slant(ray.direction);
    ray.pdf = lobe.reflection_pdf(h, cos_o, slant_o);
    const float weight = smith_reflection_weight(cos_o, slant_o, cos_i, slant_i);
    ray.weight = split(s, dot(s.wo, h)).reflected * (weight * over.attenuation);
    return true;
}

bool is_beyond(const Surface& s, const Vec3& direction) {
    return dot(s.ns, direction) < 0 && dot(s.ng, direction) < 0;
}

bool transmit_smooth(const Surface& s, const Layers& over, const Split& base, SecondaryRay& ray) {
    ray.direction = -s.wo;
    if (s.has(feature_volume) && !refract(s.wo, s.ns, s.eta, ray.direction)) return false;
    if (!is_beyond(s, ray.direction)) return false;
    ray.weight = s.base_color * (s.transmission * over.attenuation * base.below);
    return true;
}

bool transmit_rough(const Surface& s, const Layers& over, Vec2 u, SecondaryRay& ray) {
    const bool volume = s.has(feature_volume);
    const Ggx lobe = base_lobe(s);
    const Vec3 h = lobe.sample(s.wo, u);
    if (volume) {
        if (!refract(s.wo, h, s.eta, ray.direction)) return false;
    } else {
        const Vec3 mirrored = reflect(s.wo, h);
        ray.direction = mirrored - s.ns * (2 * dot(s.ns, mirrored));
    }
    if (!is_beyond(s, ray.direction)) return false;
    float weight = s.transmission * over.attenuation * split(s, dot(s.wo, h)).below;
    const float cos_o = dot(s.ns, s.wo), cos_i = -dot(s.ns, ray.direction);
    const float slant_o = lobe.slant(s.wo), slant_i = lobe.slant(ray.direction);
    ray.pdf = lobe.reflection_pdf(h, cos_o, slant_o);
    if (volume) {
        const float cos_oh = dot(s.wo, h), cos_ih = dot(ray.direction, h);
        const float denominator = cos_oh + s.eta * cos_ih;
        ray.pdf *= 4 * cos_oh * s.eta * s.eta * -cos_ih / (denominator * denominator);
        weight *= smith_g1(cos_i, slant_i);
    } else {
        weight *= smith_reflection_weight(cos_o, slant_o, cos_i, slant_i);
    }
    ray.weight = s.base_color * weight;
    return true;
}

bool carries_light(const SecondaryRay& ray) { return max_component(ray.weight) > 0; }

}  // namespace

bool refract(const Vec3& wo, const Vec3& n, float eta, Vec3& refracted) {
    const float cos_o = dot(wo, n);
    const float ratio = 1 / eta;
    const float sin2_t = ratio * ratio * std::max(0.0f, 1 - cos_o * cos_o);
    if (!(sin2_t < 1)) return false;
    refracted = normalize(n * (ratio * cos_o - std::sqrt(1 - sin2_t)) - wo * ratio);
    return true;
}

BsdfValue evaluate_bsdf(const Surface& surface, const Vec3& wi) {
    BsdfValue result;
    if (surface.has(feature_unlit)) return result;
    if (dot(surface.ns, wi) > 0) {
        evaluate_reflection(surface, wi, result);
    } else if (surface.features & (feature_transmission | feature_diffuse_transmission)) {
        evaluate_transmission(surface, wi, result);
    }
    return result;
}

int sample_secondary(const Surface& surface, Vec2 u_reflect, Vec2 u_refract, float u_lobe,
                     std::array<SecondaryRay, 2>& rays) {
    if (surface.has(feature_unlit)) return 0;
    const Layers over = layers(surface);
    const bool clear = refraction_is_smooth(surface);
    Split straight;  // which rough lobes do not ask for
    if (clear || over.coat > 0) straight = split(surface, dot(surface.ns, surface.wo));
    int count = 0;
    SecondaryRay ray;
    if (reflect_smooth(surface, over, straight, u_lobe, ray) ||
        reflect_rough(surface, over, u_reflect, u_lobe, ray)) {
        if (carries_light(ray) && dot(ray.direction, surface.ng) > 0) rays[0] = ray, count = 1;
    }
    if (surface.transmission > 0 && surface.metallic < 1) {
        ray = {};
        if ((clear ? transmit_smooth(surface, over, straight, ray)
                   : transmit_rough(surface, over, u_refract, ray)) &&
            carries_light(ray)) {
            const bool volume = surface.has(feature_volume);
            ray.refracted = true;
            ray.enters_volume = volume && surface.front;
            ray.leaves_volume = volume && !surface.front;
            rays[static_cast<size_t>(count++)] = ray;
        }
    }
    return count;
}

bool is_rough(const Surface& s) {
    if (s.has(feature_unlit)) return false;
    return (!base_is_smooth(s) && (base_reflects(s) || s.transmission > 0)) ||
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
    // At grazing angles every boundary reflects all, whatever it does to a straight view.
    float largest = metal || coat || film ? 1 : m.specular_factor;
    if (m.transmission_factor > 0) {
        largest = std::max(
            {largest, m.ior != 1 ? 1.0f : 0.0f, m.transmission_factor * max_component(base)});
    }
    return std::min(largest, 1.0f);
}

}  // namespace sightline
