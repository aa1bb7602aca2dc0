#include "shade/albedo.h"

#include "shade/albedo_grid.h"
#include "shade/fresnel.h"
#include "shade/sheen.h"

namespace sightline {
namespace {

#include "albedo_tables.inc"

template <class Table, size_t size>
constexpr Table table_of(const float (&values)[size]) {
    static_assert(size == Table::size);
    return {values};
}

constexpr auto ggx_table = table_of<GgxTable>(ggx_values);
constexpr auto usual_table = table_of<UsualTable>(usual_values);
constexpr auto reflected_cosine_table = table_of<EnteringTable>(reflected_cosine_values);
constexpr auto refractable_table = table_of<EnteringTable>(refractable_values);
constexpr auto refracted_cosine_table = table_of<EnteringTable>(refracted_cosine_values);
constexpr auto leaving_table = table_of<LeavingTable>(leaving_values);
constexpr auto stretched_table = table_of<StretchedTable>(stretched_values);
constexpr auto stretched_cosine_table = table_of<StretchedTable>(stretched_cosine_values);
constexpr auto sheen_table = table_of<SheenTable>(sheen_values);
constexpr auto divided_sheen_table = table_of<SheenTable>(divided_sheen_values);

float table_alpha(float roughness) {
    return std::clamp(roughness * roughness, least_table_alpha, 1.0f);
}

bool is_denser(float eta) { return eta >= 1 || eta <= 0; }

/// The cosine that a table gives by its distance from the direction's, in units of alpha.
float moved_cosine(float cosine, float offset, float alpha) {
    return std::clamp(cosine + offset * alpha, 0.0f, 1.0f);
}

LeavingTable::Value leaving_values_at(float cosine, float roughness, float eta) {
    const float critical = std::sqrt(std::max(0.0f, 1 - eta * eta));
    return leaving_table({ior_axis(1 / eta), roughness, leaving_axis(cosine, critical)});
}

EnteringTable::Position entering_position(float cosine, float roughness, float eta) {
    return {ior_axis(std::max(eta, 1.0f)), roughness, ggx_axis(cosine, table_alpha(roughness))};
}

/// How the offset of the cosine of reflection, which the stretched table has for an index of 1.5,
/// differs for others: as that of isotropic lobes at grazing angles, from below.
float change_with_ior(float eta) {
    if (!is_denser(eta)) return 1;
    const float distance = (ior_axis(std::max(eta, 1.0f)) - ior_axis(1.5f)) * last_ior_axis;
    return 1 - (distance < 0 ? -0.9f * distance : 0.25f * std::min(distance, 0.5f));
}

}  // namespace

GgxAlbedo smooth_albedo(float cosine, float eta) {
    const float fresnel = fresnel_dielectric(cosine, eta);
    return {1, cosine, fresnel, fresnel >= 1 ? 1.0f : 0.0f};
}

float white_ggx_albedo(float cosine, float roughness) {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    return ggx_table({roughness, ggx_axis(cosine, table_alpha(roughness))})[0];
}

GgxAlbedo ggx_albedo(float cosine, float roughness, float eta) {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    const float alpha = table_alpha(roughness);
    if (eta == usual_ior) {
        const auto [albedo, offset] = usual_table({roughness, ggx_axis(cosine, alpha)});
        const float mean_cosine = moved_cosine(cosine, offset, alpha);
        return {albedo, mean_cosine, fresnel_dielectric(mean_cosine, eta), 0};
    }
    const float albedo = white_ggx_albedo(cosine, roughness);
    if (is_denser(eta)) {
        const float offset = reflected_cosine_table(entering_position(cosine, roughness, eta))[0];
        const float mean_cosine = moved_cosine(cosine, offset, alpha);
        return {albedo, mean_cosine, fresnel_dielectric(mean_cosine, eta), 0};
    }
    const auto [reflected, total, refractable, held_back] =
        leaving_values_at(cosine, roughness, eta);
    const float fresnel = std::min(reflected, 1.0f);
    return {albedo, cosine, fresnel, std::min(total, fresnel)};
}

GgxAlbedo stretched_ggx_albedo(float cosine, float cos2_along, float along, float across,
                               float eta) {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    across = std::clamp(across, least_table_alpha, 1.0f);
    const float range = along - across;
    // The roughness that the microfacets have along the direction.
    const float alpha = std::sqrt(across * across + range * (along + across) * cos2_along);
    const float strength = across < 1 ? std::sqrt(std::max(0.0f, range / (1 - across))) : 0;
    const float turn = turn_axis(alpha, along, across);
    const float roughness = stretched_axis(across);
    // Four axes leave errors of up to 0.4 %, which shall darken rather than add light.
    const float albedo =
        1.004f * stretched_table({strength, roughness, turn, ggx_axis(cosine, alpha)})[0];
    const float offset = stretched_cosine_table(
        {strength, roughness, turn, ggx_axis(cosine, std::sqrt(alpha * along))})[0];
    const float mean_cosine = moved_cosine(cosine - 0.0015f, offset * change_with_ior(eta), along);
    return {albedo, mean_cosine, fresnel_dielectric(mean_cosine, eta), 0};
}

RefractionAlbedo refraction_albedo(float cosine, float roughness, float eta) {
    cosine = std::clamp(cosine, 0.0f, 1.0f);
    if (is_denser(eta)) {
        const auto x = entering_position(cosine, roughness, eta);
        const float refractable = refractable_table(x)[0], offset = refracted_cosine_table(x)[0];
        const float mean_cosine = moved_cosine(cosine, offset, table_alpha(roughness));
        return {refractable, refractable * fresnel_dielectric(mean_cosine, eta)};
    }
    const auto [reflected, total, refractable, held_back] =
        leaving_values_at(cosine, roughness, eta);
    return {refractable, held_back};
}

float bounded_sheen_lobe(float cos_i, float cos_o, float cos_h, float roughness) {
    return sheen_lobe(cos_i, cos_o, cos_h, roughness) /
           sheen_divisor(sheen_table, cos_i, cos_o, roughness);
}

float sheen_albedo(float cosine, float roughness) {
    const SheenTable::Position x{sheen_roughness_axis(roughness), sheen_axis(cosine)};
    return std::min(1.0f, sheen_table(x)[0]) * divided_sheen_table(x)[0];
}

}  // namespace sightline
