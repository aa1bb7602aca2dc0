// Writes the tables of src/shade/albedo.cpp as C++ initialisers to the standard output. The build
// runs it. Every value is an integral over the hemisphere, by the midpoint rule over the visible
// normals of the lobe or over directions.
#include "shade/albedo_grid.h"
#include "shade/fresnel.h"
#include "shade/ggx.h"
#include "shade/sheen.h"

#include <cstdio>
#include <vector>

namespace {

using namespace sightline;

/// A view of a lobe around +z.
struct View {
    Ggx lobe;
    Vec3 wo;
    float smith_o;
};

View isotropic_view(float cosine, float alpha) {
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    const Ggx lobe(Vec3(0, 0, 1), alpha);
    const Vec3 wo(sine, 0, cosine);
    return {lobe, wo, lobe.smith_term(wo)};
}

/// Points on the disc of visible normals. `half`: the lobe is symmetric about the plane of wo.
struct Disc {
    int radii, angles;
    bool half;
};
constexpr Disc fine_disc{128, 24, true}, usual_disc{96, 16, true}, whole_disc{64, 32, false};

/// Calls visit(h, weight) for visible normals whose weights add up to 1.
template <class Visit>
void for_visible_normals(const View& view, const Disc& disc, const Visit& visit) {
    const auto [radii, angles, half] = disc;
    for (int i = 0; i < radii; ++i) {
        // Denser at both ends of the disc, where directions come near the horizon.
        const float x = (static_cast<float>(i) + 0.5f) / static_cast<float>(radii);
        const float radius2 = x * x * (3 - 2 * x);
        const double weight = 6 * static_cast<double>(x * (1 - x)) / (radii * angles);
        for (int j = 0; j < angles; ++j) {
            const float turn = (static_cast<float>(j) + 0.5f) / static_cast<float>(angles);
            visit(view.lobe.sample(view.wo, {radius2, half ? 0.5f * turn - 0.25f : turn}), weight);
        }
    }
}

/// Weight of a reflection at a visible normal; 0 below the horizon.
double reflection_weight(const View& view, const Vec3& h) {
    const Vec3 wi = h * (2 * dot(view.wo, h)) - view.wo;
    if (wi.z <= 0) return 0;
    return static_cast<double>(
        smith_reflection_weight(view.wo.z, view.smith_o, wi.z, view.lobe.smith_term(wi)));
}

/// Weight of a refraction at a visible normal, without Fresnel's factor; 0 if there is none.
double refraction_weight(const View& view, const Vec3& h, float eta) {
    const float ratio = 1 / eta, cos_oh = dot(view.wo, h);
    const float sin2_t = ratio * ratio * std::max(0.0f, 1 - cos_oh * cos_oh);
    if (sin2_t >= 1) return 0;
    const Vec3 wi = normalize(h * (ratio * cos_oh - std::sqrt(1 - sin2_t)) - view.wo * ratio);
    if (wi.z >= 0) return 0;
    return static_cast<double>(smith_g1(-wi.z, view.lobe.smith_term(wi)));
}

double albedo(const View& view, const Disc& disc) {
    double sum = 0;
    for_visible_normals(view, disc, [&](const Vec3& h, double weight) {
        sum += weight * reflection_weight(view, h);
    });
    return sum;
}

float facet_reflectance(const View& view, const Vec3& h, float eta) {
    return fresnel_dielectric(std::clamp(dot(view.wo, h), 0.0f, 1.0f), eta);
}

/// What a lobe does to light at a boundary of index `eta`; see the tables in albedo_grid.h.
struct Shares {
    double albedo = 0, reflected = 0, totally_reflected = 0, refractable = 0, held_back = 0;
};

Shares integrate(const View& view, float eta, const Disc& disc = usual_disc) {
    Shares sum;
    for_visible_normals(view, disc, [&](const Vec3& h, double weight) {
        const auto fresnel = static_cast<double>(facet_reflectance(view, h, eta));
        const double reflection = weight * reflection_weight(view, h);
        const double refraction = weight * refraction_weight(view, h, eta);
        sum.albedo += reflection;
        sum.reflected += reflection * fresnel;
        if (fresnel >= 1) sum.totally_reflected += reflection;
        sum.refractable += refraction;
        sum.held_back += refraction * fresnel;
    });
    return sum;
}

/// The cosine at which a smooth dielectric reflects `mean`.
float cosine_of_reflectance(double mean, float eta) {
    float low = 0, high = 1;
    for (int i = 0; i < 40; ++i) {
        const float middle = 0.5f * (low + high);
        (static_cast<double>(fresnel_dielectric(middle, eta)) > mean ? low : high) = middle;
    }
    return 0.5f * (low + high);
}

double share_of(size_t node, size_t nodes) {
    return static_cast<double>(node) / static_cast<double>(nodes - 1);
}
float axis_value(size_t node, size_t nodes) { return static_cast<float>(share_of(node, nodes)); }

float table_alpha(size_t node, size_t nodes) {
    const float roughness = axis_value(node, nodes);
    return std::max(roughness * roughness, least_table_alpha);
}

/// The cosine of a node of ggx_axis, not quite grazing.
float ggx_cosine(size_t node, size_t nodes, float alpha) {
    return std::clamp(ggx_axis_cosine(axis_value(node, nodes), alpha), 1e-3f * alpha, 1.0f);
}

std::vector<double> ggx_values() {
    std::vector<double> values;
    const auto [roughnesses, cosines] = GgxTable::shape;
    for (size_t r = 0; r < roughnesses; ++r) {
        const float alpha = table_alpha(r, roughnesses);
        for (size_t c = 0; c < cosines; ++c)
            values.push_back(
                albedo(isotropic_view(ggx_cosine(c, cosines, alpha), alpha), fine_disc));
    }
    return values;
}

/// How far the cosine of a mean reflectance lies from the direction's, in units of alpha.
double cosine_offset(double mean, float eta, float cosine, float alpha) {
    return static_cast<double>((cosine_of_reflectance(mean, eta) - cosine) / alpha);
}

/// `albedos`: the GgxTable's.
std::vector<double> usual_values(const std::vector<double>& albedos) {
    std::vector<double> values;
    const auto [roughnesses, cosines] = UsualTable::shape;
    for (size_t r = 0; r < roughnesses; ++r) {
        const float alpha = table_alpha(r, roughnesses);
        for (size_t c = 0; c < cosines; ++c) {
            const float cosine = ggx_cosine(c, cosines, alpha);
            const Shares s = integrate(isotropic_view(cosine, alpha), usual_ior);
            values.push_back(albedos[r * cosines + c]);
            values.push_back(cosine_offset(s.reflected / s.albedo, usual_ior, cosine, alpha));
        }
    }
    return values;
}

struct EnteringValues {
    std::vector<double> reflected_cosines, refractable, refracted_cosines;
};

EnteringValues entering_values() {
    EnteringValues values;
    const auto [iors, roughnesses, cosines] = EnteringTable::shape;
    for (size_t i = 0; i < iors; ++i) {
        const float eta = std::max(ior_axis_eta(axis_value(i, iors)), 1.005f);
        for (size_t r = 0; r < roughnesses; ++r) {
            const float alpha = table_alpha(r, roughnesses);
            for (size_t c = 0; c < cosines; ++c) {
                const float cosine = ggx_cosine(c, cosines, alpha);
                const Shares s = integrate(isotropic_view(cosine, alpha), eta);
                const auto offset = [&](double mean) {
                    return cosine_offset(mean, eta, cosine, alpha);
                };
                values.reflected_cosines.push_back(offset(s.reflected / s.albedo));
                values.refractable.push_back(s.refractable);
                values.refracted_cosines.push_back(offset(s.held_back / s.refractable));
            }
        }
    }
    return values;
}

/// The limit of a smooth boundary.
Shares smooth_shares(float cosine, float eta) {
    Shares s;
    s.albedo = 1;
    s.reflected = static_cast<double>(fresnel_dielectric(cosine, eta));
    s.totally_reflected = s.reflected >= 1 ? 1 : 0;
    s.refractable = 1 - s.totally_reflected;
    s.held_back = s.refractable * s.reflected;
    return s;
}

std::vector<double> leaving_values() {
    std::vector<double> values;
    const auto [iors, roughnesses, cosines] = LeavingTable::shape;
    for (size_t i = 0; i < iors; ++i) {
        const float eta = 1 / std::max(ior_axis_eta(axis_value(i, iors)), 1.005f);
        const float critical = std::sqrt(1 - eta * eta);
        for (size_t r = 0; r < roughnesses; ++r) {
            for (size_t c = 0; c < cosines; ++c) {
                const float cosine =
                    std::clamp(leaving_axis_cosine(axis_value(c, cosines), critical), 1e-6f, 1.0f);
                const float alpha = table_alpha(r, roughnesses);
                const Shares s = r == 0 ? smooth_shares(cosine, eta)
                                        : integrate(isotropic_view(cosine, alpha), eta, fine_disc);
                for (const double v : {s.reflected / s.albedo, s.totally_reflected / s.albedo,
                                       s.refractable, s.held_back})
                    values.push_back(v);
            }
        }
    }
    return values;
}

/// Node `k` of a StretchedTable, whose cosines have their detail where `scale(alpha, along)` has
/// it; also returns the larger alpha.
template <class Scale>
View stretched_view(size_t k, const Scale& scale, float& along) {
    const auto [strengths, roughnesses, turns, cosines] = StretchedTable::shape;
    const float across =
        stretched_axis_alpha(axis_value(k / (turns * cosines) % roughnesses, roughnesses));
    const float strength = axis_value(k / (turns * cosines * roughnesses), strengths);
    along = across + (1 - across) * strength * strength;
    const float alpha = turn_axis_alpha(axis_value(k / cosines % turns, turns), along, across);
    const float cosine = ggx_cosine(k % cosines, cosines, scale(alpha, along));
    // alpha² = along² cos²φ + across² sin²φ.
    const float range = along * along - across * across;
    const float cos2 = range > 0 ? (alpha * alpha - across * across) / range : 0;
    const float sine = std::sqrt(1 - cosine * cosine);
    const Vec3 wo(sine * std::sqrt(cos2), sine * std::sqrt(std::max(0.0f, 1 - cos2)), cosine);
    const Ggx lobe(Vec3(0, 0, 1), Vec3(1, 0, 0), along, across);
    return {lobe, wo, lobe.smith_term(wo)};
}

std::vector<double> stretched_values() {
    std::vector<double> values;
    float along;
    for (size_t k = 0; k < StretchedTable::size; ++k)
        values.push_back(albedo(stretched_view(
                                    k, [](float alpha, float) { return alpha; }, along),
                                whole_disc));
    return values;
}

std::vector<double> stretched_cosine_values() {
    std::vector<double> values;
    float along;
    const auto scale = [](float alpha, float larger) { return std::sqrt(alpha * larger); };
    for (size_t k = 0; k < StretchedTable::size; ++k) {
        const View view = stretched_view(k, scale, along);
        const Shares s = integrate(view, 1.5f, whole_disc);
        const float mean_cosine = cosine_of_reflectance(s.reflected / s.albedo, 1.5f);
        values.push_back(static_cast<double>((mean_cosine - view.wo.z) / along));
    }
    return values;
}

/// Calls visit(cos_i, cos_h, weight) for the hemisphere; a weight includes cos_i.
template <class Visit>
void for_directions(float cos_o, const Visit& visit) {
    constexpr int steps = 96, angles = 32;
    const float sin_o = std::sqrt(1 - cos_o * cos_o);
    for (int i = 0; i < steps; ++i) {
        // Denser near the horizon, where the lobe is narrow.
        const float x = (static_cast<float>(i) + 0.5f) / steps, cos_i = x * x;
        const float sin_i = std::sqrt(1 - cos_i * cos_i);
        for (int j = 0; j < angles; ++j) {
            const float phi = pi * (static_cast<float>(j) + 0.5f) / angles;
            const float cosine = sin_o * sin_i * std::cos(phi) + cos_o * cos_i;
            visit(cos_i, (cos_i + cos_o) / std::sqrt(2 + 2 * cosine),
                  static_cast<double>(4 * pi * x * cos_i) / (steps * angles));
        }
    }
}

/// `raw`: null for the table of the lobe as it is, or that table.
std::vector<double> sheen_values(const float* raw) {
    std::vector<double> values;
    const auto [roughnesses, cosines] = SheenTable::shape;
    for (size_t r = 0; r < roughnesses; ++r) {
        const float roughness = sheen_axis_roughness(axis_value(r, roughnesses));
        for (size_t c = 0; c < cosines; ++c) {
            const float cos_o = std::max(sheen_axis_cosine(axis_value(c, cosines)), 1e-4f);
            double sum = 0;
            for_directions(cos_o, [&](float cos_i, float cos_h, double weight) {
                float lobe = sheen_lobe(cos_i, cos_o, cos_h, roughness);
                if (raw) lobe /= sheen_divisor({raw}, cos_i, cos_o, roughness);
                sum += weight * static_cast<double>(lobe);
            });
            // The bend where the albedo reaches 1 is left to min() in sheen_albedo.
            if (raw) sum /= std::min(1.0, static_cast<double>(raw[values.size()]));
            values.push_back(raw && !(sum < 1) ? 1 : sum);
        }
    }
    return values;
}

void print(const char* name, const std::vector<double>& values) {
    std::printf("constexpr float %s[] = {", name);
    for (size_t i = 0; i < values.size(); ++i)
        std::printf("%s%.6ff,", i % 8 ? " " : "\n    ", values[i]);
    std::printf("};\n\n");
}

}  // namespace

int main() {
    const std::vector<double> ggx = ggx_values();
    print("ggx_values", ggx);
    print("usual_values", usual_values(ggx));
    const EnteringValues entering = entering_values();
    print("reflected_cosine_values", entering.reflected_cosines);
    print("refractable_values", entering.refractable);
    print("refracted_cosine_values", entering.refracted_cosines);
    print("leaving_values", leaving_values());
    print("stretched_values", stretched_values());
    print("stretched_cosine_values", stretched_cosine_values());
    const std::vector<double> raw = sheen_values(nullptr);
    print("sheen_values", raw);
    const std::vector<float> raw_floats(raw.begin(), raw.end());
    print("divided_sheen_values", sheen_values(raw_floats.data()));
    return 0;
}
