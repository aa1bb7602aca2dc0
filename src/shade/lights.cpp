#include "shade/lights.h"

#include "shade/hit_geometry.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace sightline {
namespace {

constexpr size_t max_emitters = 1000000;

float cone_falloff(const Light& light, float cosine) {
    const float outer = std::cos(light.outer_cone_angle);
    const float span = std::max(0.001f, std::cos(light.inner_cone_angle) - outer);
    const float t = std::clamp((cosine - outer) / span, 0.0f, 1.0f);
    return t * t;
}

float range_falloff(float distance, float range) {
    if (!std::isfinite(range) || range <= 0) return 1;
    const float ratio = distance / range, squared = ratio * ratio;
    return std::clamp(1 - squared * squared, 0.0f, 1.0f);
}

}  // namespace

std::optional<LightSample> sample_punctual(const Light& light, const Vec3& p) {
    const Vec3 power = light.color * light.intensity;
    if (light.kind == LightKind::directional) {
        return LightSample{-light.direction, std::numeric_limits<float>::infinity(), power, 0};
    }
    const Vec3 towards = light.position - p;
    const float distance2 = dot(towards, towards);
    if (!(distance2 > 0)) return std::nullopt;
    const float distance = std::sqrt(distance2);
    const Vec3 wi = towards / distance;
    float falloff = range_falloff(distance, light.range) / distance2;
    if (light.kind == LightKind::spot) falloff *= cone_falloff(light, -dot(light.direction, wi));
    if (!(falloff > 0)) return std::nullopt;
    return LightSample{wi, distance, power * falloff, 0};
}

AreaLights::AreaLights(const Scene& scene, const Surfaces& surfaces)
    : scene_(scene), surfaces_(surfaces) {
    std::vector<float> powers;
    for (uint32_t instance = 0; instance < scene.instances.size(); ++instance) {
        const uint32_t group = scene.instances[instance].group;
        if (group >= scene.groups.size()) continue;
        std::vector<uint32_t> meshes = scene.groups[group].meshes;
        std::sort(meshes.begin(), meshes.end());  // find() is a binary search
        for (const uint32_t geometry : meshes) {
            add_mesh(instance, geometry, powers);
        }
    }
    keep_strongest(powers);
    double sum = 0;
    for (const float power : powers) sum += static_cast<double>(power);
    power_ = static_cast<float>(sum);
    double cumulative = 0;
    cdf_.reserve(powers.size());
    for (size_t i = 0; i < powers.size(); ++i) {
        cumulative += static_cast<double>(powers[i]);
        cdf_.push_back(static_cast<float>(cumulative / sum));
        emitters_[i].density *= static_cast<float>(static_cast<double>(powers[i]) / sum);
    }
    size_t emitter = 0;
    for (size_t part = 0; part < cdf_.size(); ++part) {
        // Slightly below the begin of the part, so that rounding leads no pick past its emitter.
        const float begin = static_cast<float>(part) / static_cast<float>(cdf_.size()) - 0x1p-22f;
        while (emitter + 1 < cdf_.size() && cdf_[emitter] <= begin) ++emitter;
        guide_.push_back(static_cast<uint32_t>(emitter));
    }
}

void AreaLights::add_mesh(uint32_t instance, uint32_t geometry, std::vector<float>& powers) {
    const Mesh& mesh = scene_.meshes[geometry];
    const Material& material = scene_.materials[mesh.material];
    if (material.unlit || max_component(material.emissive_factor) <= 0) return;
    Hit hit;
    hit.u = hit.v = 1.0f / 3;
    hit.geometry = geometry;
    hit.instance = instance;
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        hit.primitive = i;
        const HitGeometry g = hit_geometry(scene_, hit, nullptr, false);
        const float area = 0.5f * g.area2;
        if (!(area > 0)) continue;
        const float mean = luminance(surfaces_.emission(hit, 1.5f * std::sqrt(area)));
        const float sides = material.double_sided ? 2 : 1;
        const float power = pi * area * mean * sides;
        if (!(power > 0) || !std::isfinite(power)) continue;
        const Vec3 corner = g.position - (g.edge1 + g.edge2) / 3;
        emitters_.push_back({corner, g.edge1, g.edge2, g.outward, 1 / area, instance, geometry, i,
                             material.double_sided});
        powers.push_back(power);
    }
}

void AreaLights::keep_strongest(std::vector<float>& powers) {
    if (emitters_.size() <= max_emitters) return;
    std::vector<uint32_t> order(emitters_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::nth_element(order.begin(), order.begin() + max_emitters, order.end(),
                     [&](uint32_t a, uint32_t b) {
                         return powers[a] != powers[b] ? powers[a] > powers[b] : a < b;
                     });
    order.resize(max_emitters);
    std::sort(order.begin(), order.end());
    for (size_t i = 0; i < order.size(); ++i) {
        emitters_[i] = emitters_[order[i]];
        powers[i] = powers[order[i]];
    }
    emitters_.resize(max_emitters);
    powers.resize(max_emitters);
}

std::optional<LightSample> AreaLights::sample(const Vec3& p, Vec2 u, float pick) const {
    if (emitters_.empty()) return std::nullopt;
    const auto part = static_cast<size_t>(pick * static_cast<float>(guide_.size()));
    size_t index = guide_[std::min(part, guide_.size() - 1)];
    while (index + 1 < cdf_.size() && cdf_[index] <= pick) ++index;
    const Emitter& emitter = emitters_[index];
    // Folding the unit square along its diagonal gives uniform points on the triangle.
    Hit hit;
    hit.u = u.x + u.y > 1 ? 1 - u.x : u.x;
    hit.v = u.x + u.y > 1 ? 1 - u.y : u.y;
    const Vec3 towards = emitter.a + emitter.ab * hit.u + emitter.ac * hit.v - p;
    const float distance2 = dot(towards, towards);
    if (!(distance2 > 0)) return std::nullopt;
    const float distance = std::sqrt(distance2);
    const Vec3 wi = towards / distance;
    const float cosine = -dot(emitter.normal, wi);
    if (emitter.double_sided ? cosine == 0 : cosine <= 0) return std::nullopt;
    hit.geometry = emitter.geometry;
    hit.instance = emitter.instance;
    hit.primitive = emitter.primitive;
    const float pdf = emitter.density * distance2 / std::fabs(cosine);
    return LightSample{wi, distance, surfaces_.emission(hit, 0), pdf};
}

const AreaLights::Emitter* AreaLights::find(const Hit& hit) const {
    const auto key = [](const auto& e) { return std::tuple(e.instance, e.geometry, e.primitive); };
    const auto found =
        std::lower_bound(emitters_.begin(), emitters_.end(), key(hit),
                         [&](const Emitter& e, const auto& wanted) { return key(e) < wanted; });
    return found != emitters_.end() && key(*found) == key(hit) ? &*found : nullptr;
}

float AreaLights::pdf(const Ray& ray, const Hit& hit) const {
    const Emitter* emitter = find(hit);
    if (!emitter) return 0;
    const float length2 = dot(ray.direction, ray.direction);
    const float cosine = -dot(emitter->normal, ray.direction) / std::sqrt(length2);
    if (emitter->double_sided ? cosine == 0 : cosine <= 0) return 0;
    return emitter->density * hit.t * hit.t * length2 / std::fabs(cosine);
}

}  // namespace sightline
