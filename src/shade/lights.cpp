#include "shade/lights.h"

#include "shade/hit_geometry.h"

#include <algorithm>
#include <tuple>

namespace sightline {
namespace {

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

AreaLights::AreaLights(const Scene& scene, const Surfaces& surfaces, unsigned threads)
    : scene_(scene), surfaces_(surfaces), mesh_of_geometry_(scene.meshes.size(), none) {
    for (uint32_t instance = 0; instance < scene.instances.size(); ++instance) {
        const uint32_t group = scene.instances[instance].group;
        if (group >= scene.groups.size()) continue;
        std::vector<uint32_t> meshes = scene.groups[group].meshes;
        std::sort(meshes.begin(), meshes.end());  // find() is a binary search
        for (const uint32_t geometry : meshes) {
            if (surfaces.may_emit(scene.meshes[geometry].material))
                add_emitter(instance, geometry, threads);
        }
    }
    prepare_meshes(threads);
    keep_emitters_with_weight();
}

void AreaLights::add_emitter(uint32_t instance, uint32_t geometry, unsigned threads) {
    uint32_t& mesh = mesh_of_geometry_[geometry];
    if (mesh == none) {
        mesh = static_cast<uint32_t>(meshes_.size());
        meshes_.emplace_back(scene_, surfaces_, instance, geometry, threads);
    }
    const Material& material = scene_.materials[scene_.meshes[geometry].material];
    emitters_.push_back({instance, geometry, mesh, !culls_back_faces(material)});
}

/// Of all emitting sides.
EmissiveMesh::Integral AreaLights::integral(const Emitter& emitter) const {
    EmissiveMesh::Integral sum = meshes_[emitter.mesh].over(scene_.instances[emitter.instance]);
    const double sides = emitter.double_sided ? 2 : 1;
    return {sum.emission * sides, sum.potential * sides, sum.weight * sides};
}

// Sets up the meshes' distributions.
void AreaLights::prepare_meshes(unsigned threads) {
    double emission = 0, potential = 0;
    std::vector<EmissiveMesh::Integral> integrals;
    for (const Emitter& emitter : emitters_) {
        integrals.push_back(integral(emitter));
        emission += integrals.back().emission;
        potential += integrals.back().potential;
    }
    // The samples that are spent on what the estimates take for black.
    constexpr double spent_on_black = 0.05;
    constexpr double cells = 4096;
    double floor = 0;
    if (potential > 0) floor = emission > 0 ? spent_on_black * emission / potential : 1;
    floor = std::clamp(floor, 1e-12, 1.0);
    const double sum = emission + floor * potential;
    std::vector<double> weights(meshes_.size(), 0);
    for (size_t i = 0; i < emitters_.size(); ++i)
        weights[emitters_[i].mesh] += integrals[i].emission + floor * integrals[i].potential;
    for (size_t i = 0; i < meshes_.size(); ++i) {
        if (weights[i] > 0)
            meshes_[i].prepare(static_cast<float>(floor), cells * weights[i] / sum, threads);
    }
}

// Removes the emitters that cannot be picked; sets up the distribution of the others.
void AreaLights::keep_emitters_with_weight() {
    std::vector<Emitter> kept;
    std::vector<double> weights;
    for (const Emitter& emitter : emitters_) {
        const EmissiveMesh::Integral sum = integral(emitter);
        if (!(sum.weight > 0)) continue;
        kept.push_back(emitter);
        weights.push_back(sum.weight);
        power_ += static_cast<double>(pi) * sum.emission;
    }
    emitters_ = std::move(kept);
    if (!weights.empty()) pick_ = DiscreteDistribution(weights);
}

uint64_t AreaLights::count() const {
    uint64_t count = 0;
    for (const Emitter& emitter : emitters_) count += meshes_[emitter.mesh].count();
    return count;
}

std::optional<LightSample> AreaLights::sample(const Vec3& p, Vec2 u, Vec2 pick) const {
    if (emitters_.empty()) return std::nullopt;
    // One number of 48 bits: 24 would not tell the triangles of large meshes apart.
    double remaining = static_cast<double>(pick.x) + static_cast<double>(pick.y) * 0x1p-24;
    const Emitter& emitter = emitters_[pick_.sample(remaining)];
    const EmissiveMesh::Point point = meshes_[emitter.mesh].sample(remaining, u);
    Hit hit;
    hit.u = point.u;
    hit.v = point.v;
    hit.geometry = emitter.geometry;
    hit.instance = emitter.instance;
    hit.primitive = point.triangle;
    const HitGeometry g = hit_geometry(scene_, hit, nullptr, true);
    const Vec3 towards = g.position - p;
    const float distance2 = dot(towards, towards);
    if (!(distance2 > 0)) return std::nullopt;
    const float distance = std::sqrt(distance2);
    const Vec3 wi = towards / distance;
    return light(emitter, hit, g, wi, distance);
}

std::optional<LightSample> AreaLights::light(const Emitter& emitter, const Hit& hit,
                                             const HitGeometry& g, const Vec3& wi,
                                             float distance) const {
    const float cosine = -dot(g.outward, wi);
    if (emitter.double_sided ? cosine == 0 : cosine <= 0) return std::nullopt;
    if (!(g.area2 > 0)) return std::nullopt;
    const auto index = static_cast<size_t>(&emitter - emitters_.data());
    const double per_area = pick_.probability(index) * 2 / static_cast<double>(g.area2) *
                            meshes_[emitter.mesh].density({hit.primitive, hit.u, hit.v});
    const auto pdf =
        static_cast<float>(per_area * static_cast<double>(distance * distance / std::fabs(cosine)));
    return LightSample{wi, distance, surfaces_.emission(g, hit, {Vec3(0), 0, wi, distance}), pdf};
}

const AreaLights::Emitter* AreaLights::find(const Hit& hit) const {
    const auto key = [](const auto& e) { return std::tuple(e.instance, e.geometry); };
    const auto found =
        std::lower_bound(emitters_.begin(), emitters_.end(), key(hit),
                         [&](const Emitter& e, const auto& wanted) { return key(e) < wanted; });
    return found != emitters_.end() && key(*found) == key(hit) ? &*found : nullptr;
}

std::optional<LightSample> AreaLights::at(const Ray& ray, const Hit& hit) const {
    const Emitter* emitter = find(hit);
    if (!emitter) return std::nullopt;
    const float length = ray.direction.length();
    return light(*emitter, hit, hit_geometry(scene_, hit, nullptr, true), ray.direction / length,
                 hit.t * length);
}

}  // namespace sightline
