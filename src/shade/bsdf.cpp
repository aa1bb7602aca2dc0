#include "shade/bsdf.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr float inverse_pi = 1 / pi;
constexpr float smooth_alpha = smooth_roughness * smooth_roughness;

bool is_anisotropic(const Surface& s) { return s.has(feature_anisotropy) && s.anisotropy > 0; }

/// Boundaries of volumes have an isotropic lobe of the same area instead.
bool is_stretched(const Surface& s) { return is_anisotropic(s) && !s.has(feature_volume); }

bool base_is_smooth(const Surface& s) { return is_smooth(s.roughness) && !is_anisotropic(s); }

/// False if the microfacets of the base reflect nothing at any angle.
bool base_reflects(const Surface& s) {
    return s.metallic > 0 || s.specular > 0 || s.has(feature_iridescence);
}

/// 1/E of the GGX lobe is 3.26 at most, for a roughness of 1 at normal incidence.
constexpr float largest_compensation = 3.3f;

/// A film's mean reflectance over a lobe of reflection is known to this; over one of refraction to
/// somewhat more than the double.
constexpr float film_error = 0.017f;

/// GGX alphas of the base along and across the tangent, the same if it is isotropic.
struct Alphas {
    float along, across;

    /// Perceptual roughness of an isotropic lobe that is as wide on average.
    float mean_roughness() const {
        return std::sqrt(along == across ? along : std::sqrt(along * across));
    }
};

Alphas base_alphas(const Surface& s) {
    const float alpha = std::max(s.roughness * s.roughness, smooth_alpha);
    if (!is_anisotropic(s)) return {alpha, alpha};
    const float along = alpha + (1 - alpha) * s.anisotropy * s.anisotropy;
    if (is_stretched(s)) return {along, alpha};
    const float mean = std::sqrt(along * alpha);
    return {mean, mean};
}

/// Of the light that crosses a thin wall. It does not bend light, but blurs it the less, the closer
/// its ior is to that of air (KHR_materials_transmission, "Refraction"); from 1.5 on it blurs as
/// much as it does a reflection.
Alphas thin_alphas(const Surface& s) {
    const float blur = std::clamp(2 * s.ior - 2, 0.0f, 1.0f);
    const Alphas base = base_alphas(s);
    return {base.along * blur, std::max(base.across * blur, smooth_alpha)};
}

/// Between them light goes straight on, however rough the boundary.
bool separates_equal_media(const Surface& s) { return std::fabs(s.eta - 1) < 1e-3f; }

bool refraction_is_smooth(const Surface& s) {
    if (base_is_smooth(s)) return true;
    return s.has(feature_volume) ? separates_equal_media(s) : thin_alphas(s).along < smooth_alpha;
}

Ggx lobe_of(const Surface& s, Alphas alphas) {
    if (!is_stretched(s)) return Ggx(s.ns, alphas.across);
    return Ggx(s.ns, s.tangent, alphas.along, alphas.across);
}

Ggx base_lobe(const Surface& s) { return lobe_of(s, base_alphas(s)); }
Ggx thin_lobe(const Surface& s) { return lobe_of(s, thin_alphas(s)); }

Ggx coat_lobe(const Surface& s) {
    return Ggx(s.coat_normal, s.clearcoat_roughness * s.clearcoat_roughness);
}

/// For wo.
GgxAlbedo albedo_of(const Surface& s, Alphas alphas, float cos_o) {
    if (!is_stretched(s)) return ggx_albedo(cos_o, alphas.mean_roughness(), s.eta);
    const float along = dot(s.tangent, s.wo), sin2 = 1 - cos_o * cos_o;
    const float cos2_along = sin2 > 0 ? std::min(along * along / sin2, 1.0f) : 0;
    return stretched_ggx_albedo(cos_o, cos2_along, alphas.along, alphas.across, s.eta);
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

/// A thin wall transmits with the lobe of reflection, mirrored to the other side.
LobeEval eval_thin_lobe(const Surface& s, const Vec3& wi) {
    const Vec3 mirrored = wi - s.ns * (2 * dot(s.ns, wi));
    return eval_reflection_lobe(thin_lobe(s), s.ns, s.wo, mirrored, normalize(s.wo + mirrored));
}

/// Rough refraction (Walter et al. 2007, equations 17 and 21), without the factor eta² that
/// radiance gains across the boundary: it cancels between entry and exit, and nothing inside emits.
/// Also returns the microfacet normal.
LobeEval eval_refraction_lobe(const Surface& s, const Vec3& wi, Vec3& h) {
    h = normalize(s.wo + wi * s.eta);
    if (dot(h, s.ns) < 0) h = -h;
    const float cos_oh = dot(s.wo, h), cos_ih = dot(wi, h);
    if (cos_oh <= 0 || cos_ih >= 0) return {};
    const Ggx lobe = base_lobe(s);
    const float cos_o = dot(s.ns, s.wo), cos_i = -dot(s.ns, wi);
    const float denominator = cos_oh + s.eta * cos_ih;
    const float jacobian = s.eta * s.eta * -cos_ih / (denominator * denominator);
    const float smith_o = lobe.smith_term(s.wo);
    // reflection_pdf holds 1/(4 cos_oh), the Jacobian of mirroring.
    const float pdf = lobe.reflection_pdf(h, cos_o, smith_o) * 4 * cos_oh * jacobian;
    return {pdf * smith_g1(cos_i, lobe.smith_term(wi)), pdf};
}

/// A direction around the unit vector `n` with the pdf cos θ/π (Shirley and Chiu 1997, by the polar
/// map).
Vec3 sample_cosine(const Vec3& n, Vec2 u) {
    Vec3 t, b;
    complete_basis(n, t, b);
    const float r = std::sqrt(u.x), phi = 2 * pi * u.y;
    const float height = std::sqrt(std::max(0.0f, 1 - u.x));
    return normalize(t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + n * height);
}

/// True on the far side of both the shading and the geometric normal.
bool is_transmitted(const Surface& s, const Vec3& direction) {
    return dot(s.ns, direction) < 0 && dot(s.ng, direction) < 0;
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

Bsdf::Bsdf(const Surface& surface) : s_(surface) {
    if (s_.has(feature_unlit)) return;
    cos_o_ = std::clamp(dot(s_.ns, s_.wo), 0.0f, 1.0f);
    mean_roughness_ = base_alphas(s_).mean_roughness();
    prepare_layers();
    const GgxAlbedo lobe = base_albedo();
    if (s_.metallic > 0)
        metal_scale_ = metal_multiple_scattering(s_, lobe) * (s_.metallic * base_weight_);
    if (s_.metallic < 1) {
        prepare_dielectric(lobe);
        prepare_transmission();
        prepare_diffuse();
    }
    if (coat_weight_ <= 0) return;
    const float base = luminance(base_reflectance(cos_o_));
    coat_probability_ = coat_weight_ / (coat_weight_ + base);
}

GgxAlbedo Bsdf::base_albedo() const {
    if (base_is_smooth(s_)) return smooth_albedo(cos_o_, s_.eta);
    const bool plain_metal = s_.metallic >= 1 && !is_stretched(s_) && !s_.has(feature_iridescence);
    if (plain_metal) return {.albedo = white_ggx_albedo(cos_o_, mean_roughness_)};
    return albedo_of(s_, base_alphas(s_), cos_o_);
}

void Bsdf::prepare_layers() {
    if (s_.has(feature_sheen))
        base_weight_ -= max_component(s_.sheen_color) * sheen_albedo(cos_o_, s_.sheen_roughness);
    if (!s_.has(feature_clearcoat) || (s_.has(feature_volume) && !s_.front)) return;
    const float cosine = std::clamp(dot(s_.coat_normal, s_.wo), 0.0f, 1.0f);
    const GgxAlbedo lobe = coat_lobe_albedo(cosine, s_.clearcoat_roughness);
    coat_weight_ = s_.clearcoat * coat_albedo(lobe);
    base_weight_ *= 1 - coat_weight_;
    if (is_smooth(s_.clearcoat_roughness)) return;
    coat_scale_ =
        s_.clearcoat * multiple_scattering(Vec3(fresnel_dielectric(1, coat_ior)), lobe.albedo).x;
}

/// The factor that makes what a rough boundary between two media reflects and refracts add up to 1.
float Bsdf::boundary_scale(const GgxAlbedo& lobe) const {
    const RefractionAlbedo refraction = refraction_albedo(cos_o_, mean_roughness_, s_.eta);
    const float reflected = lobe.albedo * max_component(mean_dielectric_reflectance(s_, lobe));
    if (refraction.refractable <= 0) return 1 / std::max(reflected, lobe.albedo);
    const float held_back =
        largest_reflectance(s_, refraction.held_back / refraction.refractable, lobe.fresnel_cosine);
    // Errors of the tables, and of a film's mean over a rough lobe, shall darken rather than add
    // light.
    const float error = s_.has(feature_iridescence) ? 2.4f * film_error
                        : s_.eta < 1                ? 0.002f
                                                    : 0.001f;
    return (1 - error) / (reflected + refraction.refractable * (1 - held_back));
}

void Bsdf::prepare_dielectric(const GgxAlbedo& lobe) {
    const bool scatters_inwards = s_.has(feature_volume) && !refraction_is_smooth(s_);
    const Vec3 scale =
        scatters_inwards ? Vec3(boundary_scale(lobe)) : dielectric_multiple_scattering(s_, lobe);
    const Vec3 albedo = mean_dielectric_reflectance(s_, lobe) * scale * lobe.albedo;
    dielectric_scale_ = scale * ((1 - s_.metallic) * base_weight_);
    transmitted_ = (1 - s_.metallic) * std::max(0.0f, 1 - max_component(albedo));
    if (s_.has(feature_iridescence)) transmitted_ *= 1 - film_error;
    if (scatters_inwards)
        transmission_scale_ = scale.x * (1 - s_.metallic) * s_.transmission * base_weight_;
}

void Bsdf::prepare_transmission() {
    if (s_.transmission <= 0 && s_.diffuse_transmission <= 0) return;
    const float refracted = s_.transmission * max_component(s_.base_color);
    const float diffused = (1 - s_.transmission) * s_.diffuse_transmission *
                           max_component(s_.diffuse_transmission_color);
    if (diffused > 0) diffuse_probability_ = diffused / (diffused + refracted);
    const bool smooth = refraction_is_smooth(s_);
    if (s_.transmission <= 0 || (s_.has(feature_volume) && !smooth)) return;
    transmission_scale_ = transmitted_ * s_.transmission * base_weight_;
    if (!smooth) transmission_scale_ /= albedo_of(s_, thin_alphas(s_), cos_o_).albedo;
}

void Bsdf::prepare_diffuse() {
    const float share = transmitted_ * (1 - s_.transmission) * base_weight_;
    if (share > 0) diffuse_scale_ = share / std::max(mean_diffuse_share_below(), 1e-6f);
}

/// Mean of diffuse_share_below over the cosine-weighted hemisphere.
float Bsdf::mean_diffuse_share_below() const {
    float mean = 0;
    const bool plain = !s_.has(feature_specular) && !s_.has(feature_volume);
    if (!plain || s_.eta < 1 || s_.eta > last_table_ior) {
        for (size_t i = 0; i < mean_nodes; ++i)
            mean += mean_weights[i] * diffuse_share_below(mean_cosines[i]);
        return mean;
    }
    const float roughness = base_is_smooth(s_) ? 0 : mean_roughness_;
    if (!(coat_weight_ > 0) && !s_.has(feature_sheen))
        return 1 - mean_plain_albedo(roughness, s_.eta);
    NodeValues shares = mean_weights;
    const auto cover = [&](const NodeValues& albedos, float weight) {
        for (size_t i = 0; i < mean_nodes; ++i) shares[i] *= 1 - weight * albedos[i];
    };
    cover(plain_albedos(roughness, s_.eta), 1);
    if (coat_weight_ > 0) cover(coat_albedos(s_.clearcoat_roughness), s_.clearcoat);
    if (s_.has(feature_sheen))
        cover(sheen_albedos(s_.sheen_roughness), max_component(s_.sheen_color));
    for (const float weighted : shares) mean += weighted;
    return mean;
}

/// The share of light from a direction with this cosine that all boundaries above the diffuse lobes
/// let in.
float Bsdf::diffuse_share_below(float cosine) const {
    float share = 1;
    if (coat_weight_ > 0) share -= s_.clearcoat * coat_albedo(cosine, s_.clearcoat_roughness);
    if (s_.has(feature_sheen))
        share *= 1 - max_component(s_.sheen_color) * sheen_albedo(cosine, s_.sheen_roughness);
    if (s_.has(feature_volume) || !base_reflects(s_)) return share;
    return share *
           (1 - plain_albedo(s_, base_is_smooth(s_) ? smooth_albedo(cosine, s_.eta)
                                                    : ggx_albedo(cosine, mean_roughness_, s_.eta)));
}

/// What the microfacets of the base reflect, with all factors.
Vec3 Bsdf::base_reflectance(float cosine) const {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    Vec3 sum(0);
    if (s_.metallic < 1) sum = dielectric_reflectance(s_, cosine) * dielectric_scale_;
    if (s_.metallic > 0) sum += metal_reflectance(s_, cosine) * metal_scale_;
    return sum;
}

BsdfEval Bsdf::eval(const Vec3& wi) const {
    BsdfEval result;
    if (s_.has(feature_unlit)) return result;
    if (diffuse_scale_ > 0) eval_diffuse(wi, result);
    if (dot(s_.ns, wi) > 0) {
        eval_reflection(wi, result);
    } else if (transmission_scale_ > 0 && !refraction_is_smooth(s_)) {
        eval_transmission(wi, result);
    }
    return result;
}

void Bsdf::eval_diffuse(const Vec3& wi, BsdfEval& result) const {
    const float cos_i = dot(s_.diffuse_normal(), wi);
    const bool reflects = cos_i > 0;
    if (!reflects && (s_.diffuse_transmission <= 0 || dot(s_.ns, wi) > 0)) return;
    const float pdf = std::fabs(cos_i) * inverse_pi;
    const float value = diffuse_scale_ * diffuse_share_below(std::fabs(cos_i)) * pdf;
    if (reflects) {
        result.diffuse = s_.base_color * (value * (1 - s_.diffuse_transmission));
    } else {
        result.glossy = s_.diffuse_transmission_color * (value * s_.diffuse_transmission);
        result.pdf = pdf * diffuse_probability_;
    }
}

void Bsdf::eval_reflection(const Vec3& wi, BsdfEval& result) const {
    const Vec3 h = normalize(s_.wo + wi);
    if (s_.has(feature_sheen)) {
        const float cos_i = dot(s_.ns, wi);
        result.diffuse +=
            s_.sheen_color * ((1 - coat_weight_) * cos_i *
                              bounded_sheen_lobe(cos_i, cos_o_, dot(s_.ns, h), s_.sheen_roughness));
    }
    if (!base_is_smooth(s_) && base_reflects(s_)) {
        const LobeEval lobe = eval_reflection_lobe(base_lobe(s_), s_.ns, s_.wo, wi, h);
        result.glossy += base_reflectance(dot(s_.wo, h)) * lobe.value;
        result.pdf += lobe.pdf * (1 - coat_probability_);
    }
    if (coat_scale_ > 0) {
        const LobeEval lobe = eval_reflection_lobe(coat_lobe(s_), s_.coat_normal, s_.wo, wi, h);
        const float fresnel = fresnel_dielectric(std::max(dot(s_.wo, h), 0.0f), coat_ior);
        result.glossy += Vec3(lobe.value * fresnel * coat_scale_);
        result.pdf += lobe.pdf * coat_probability_;
    }
}

void Bsdf::eval_transmission(const Vec3& wi, BsdfEval& result) const {
    float scale = transmission_scale_;
    LobeEval lobe;
    if (s_.has(feature_volume)) {
        Vec3 h;
        lobe = eval_refraction_lobe(s_, wi, h);
        if (lobe.pdf <= 0) return;
        scale *= std::max(0.0f, 1 - max_component(dielectric_reflectance(s_, dot(s_.wo, h))));
    } else {
        lobe = eval_thin_lobe(s_, wi);
    }
    result.glossy += s_.base_color * (lobe.value * scale);
    result.pdf += lobe.pdf * (1 - diffuse_probability_);
}

/// The mirror direction, if the lobe that `u_lobe` chooses is smooth; two smooth lobes of one
/// normal share a sample.
bool Bsdf::sample_smooth_reflection(float u_lobe, BsdfSample& sample) const {
    const bool base_smooth = base_is_smooth(s_);
    const bool coat_smooth = coat_weight_ > 0 && is_smooth(s_.clearcoat_roughness);
    const bool samples_coat = u_lobe < coat_probability_;
    if (samples_coat ? !coat_smooth : !base_smooth) return false;
    if (coat_weight_ <= 0) {
        sample = {reflect(s_.wo, s_.ns), base_reflectance(cos_o_)};
    } else if (base_smooth && coat_smooth && s_.coat_normal == s_.ns) {
        sample = {reflect(s_.wo, s_.ns), base_reflectance(cos_o_) + Vec3(coat_weight_)};
    } else if (samples_coat) {
        sample = {reflect(s_.wo, s_.coat_normal), Vec3(coat_weight_ / coat_probability_)};
    } else {
        sample = {reflect(s_.wo, s_.ns), base_reflectance(cos_o_) / (1 - coat_probability_)};
    }
    return true;
}

bool Bsdf::sample_rough_reflection(Vec2 u, float u_lobe, BsdfSample& sample) const {
    const bool samples_coat = u_lobe < coat_probability_;
    if (!samples_coat && !base_reflects(s_)) return false;
    const Ggx lobe = samples_coat ? coat_lobe(s_) : base_lobe(s_);
    const Vec3 h = lobe.sample(s_.wo, u);
    sample.direction = reflect(s_.wo, h);
    if (coat_weight_ > 0) {
        const BsdfEval value = eval(sample.direction);
        sample.pdf = value.pdf;
        sample.weight = sample.pdf > 0 ? value.glossy / sample.pdf : Vec3(0);
        return sample.pdf > 0;
    }
    const float cos_o = dot(s_.ns, s_.wo), cos_i = dot(s_.ns, sample.direction);
    if (cos_i <= 0 || cos_o <= 0) return false;
    const float smith_o = lobe.smith_term(s_.wo), smith_i = lobe.smith_term(sample.direction);
    sample.pdf = lobe.reflection_pdf(h, cos_o, smith_o);
    const float weight = smith_reflection_weight(cos_o, smith_o, cos_i, smith_i);
    sample.weight = base_reflectance(dot(s_.wo, h)) * weight;
    return true;
}

/// Diffuse transmission or refraction.
bool Bsdf::sample_transmission(Vec2 u, BsdfSample& sample) const {
    const float diffuse = diffuse_probability_;
    if (u.x >= diffuse) {
        u.x = diffuse > 0 ? std::min((u.x - diffuse) / (1 - diffuse), 0x1.fffffep-1f) : u.x;
        return sample_refraction(u, sample);
    }
    if (diffuse_scale_ <= 0) return false;
    sample.direction = sample_cosine(-s_.diffuse_normal(), {u.x / diffuse, u.y});
    if (!is_transmitted(s_, sample.direction)) return false;
    const BsdfEval value = eval(sample.direction);
    sample.pdf = value.pdf;
    sample.weight = sample.pdf > 0 ? value.glossy / sample.pdf : Vec3(0);
    return sample.pdf > 0;
}

bool Bsdf::sample_refraction(Vec2 u, BsdfSample& sample) const {
    const bool volume = s_.has(feature_volume);
    if (refraction_is_smooth(s_)) {
        sample.direction = -s_.wo;
        sample.unbent = transmission_is_unbent(s_);
        if (!sample.unbent && !refract(s_.wo, s_.ns, s_.eta, sample.direction)) return false;
        sample.weight = s_.base_color * (transmission_scale_ / (1 - diffuse_probability_));
        return is_transmitted(s_, sample.direction);
    }
    if (volume) {
        const Vec3 h = base_lobe(s_).sample(s_.wo, u);
        if (!refract(s_.wo, h, s_.eta, sample.direction)) return false;
    } else {
        const Vec3 mirrored = reflect(s_.wo, thin_lobe(s_).sample(s_.wo, u));
        sample.direction = mirrored - s_.ns * (2 * dot(s_.ns, mirrored));
    }
    if (!is_transmitted(s_, sample.direction)) return false;
    BsdfEval value;
    if (diffuse_probability_ > 0) {
        value = eval(sample.direction);
    } else {
        eval_transmission(sample.direction, value);
    }
    sample.pdf = value.pdf;
    sample.weight = sample.pdf > 0 ? value.glossy / sample.pdf : Vec3(0);
    return sample.pdf > 0;
}

int Bsdf::sample(Vec2 u_reflect, Vec2 u_refract, float u_lobe,
                 std::array<BsdfSample, 2>& samples) const {
    if (s_.has(feature_unlit)) return 0;
    int count = 0;
    BsdfSample sample;
    if (sample_smooth_reflection(u_lobe, sample) ||
        sample_rough_reflection(u_reflect, u_lobe, sample)) {
        if (carries_light(sample) && dot(sample.direction, s_.ng) > 0)
            samples[0] = sample, count = 1;
    }
    if (transmission_scale_ > 0 || diffuse_probability_ > 0) {
        sample = {};
        if (sample_transmission(u_refract, sample) && carries_light(sample)) {
            const bool volume = s_.has(feature_volume);
            sample.refracted = true;
            sample.enters_volume = volume && s_.front;
            sample.leaves_volume = volume && !s_.front;
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
    const Vec3 passed = Bsdf(s).straight_transmission();
    (transmission_is_unbent(s) ? result.unbent : result.bent) += passed * s.alpha;
    return result;
}

bool is_rough(const Surface& s) {
    if (s.has(feature_unlit)) return false;
    return (!base_is_smooth(s) && base_reflects(s)) ||
           (s.transmission > 0 && !refraction_is_smooth(s)) || s.diffuse_transmission > 0 ||
           (s.has(feature_clearcoat) && s.clearcoat > 0 && !is_smooth(s.clearcoat_roughness));
}

bool scatters(const Surface& s) {
    return is_rough(s) || s.has(feature_sheen) ||
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
    if (m.diffuse_transmission_factor > 0)
        largest = std::max(largest, m.diffuse_transmission_factor *
                                        max_component(m.diffuse_transmission_color_factor));
    // Compensation for what rough microfacets lose makes single samples brighter than the mean.
    const bool rough =
        m.roughness_factor >= smooth_roughness || m.glossiness_texture || m.anisotropy_strength > 0;
    return std::min(rough ? largest * largest_compensation : largest, 1.0f);
}

}  // namespace sightline
