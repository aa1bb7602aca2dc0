#include "render/direct_light.h"

namespace sightline {

namespace {

constexpr uint32_t lighting_stream = 0x9e3779b9;  // of the light that the ground sends up

}  // namespace

void DirectLighting::add(const LitVertex& vertex, const LightSamples& samples,
                         SampleBuffer& buffer) {
    add_punctual(vertex, buffer);
    const LayerNames& names = context_.layers.names;
    if (samples.environment) {
        ++buffer.counters->environment_samples;
        const EnvironmentSample& s = *samples.environment;
        add_sampled(vertex,
                    {s.wi, std::numeric_limits<float>::infinity(), light_from(vertex, s), s.pdf},
                    names.environment);
    }
    if (context_.needs.area_lights && !context_.area_lights.empty()) {
        ++buffer.counters->area_light_samples;
        const Vec3& p = vertex.bsdf.surface().position;
        const auto light = context_.area_lights.sample(p, samples.emitter, samples.which_emitter);
        if (light && !context_.ground.blocks(p, *light))
            add_sampled(vertex, *light, names.emission);
    }
}

// What comes from the direction of an environment sample: of it, or of the ground.
Vec3 DirectLighting::light_from(const LitVertex& vertex, const EnvironmentSample& sample) const {
    const Ground& ground = context_.ground;
    if (!ground.exists() || !ground.is_surface()) return sample.radiance;
    const Ray ray{vertex.bsdf.surface().position, 0, sample.wi};
    const float distance = ground.distance(ray);
    return std::isfinite(distance) ? ground.radiance(ground.point(ray, distance)) : sample.radiance;
}

void DirectLighting::trace(Coherence coherence, GroundShadows& ground, SampleBuffer& buffer) {
    punctual_shadows_.trace(coherence, buffer);
    if (!context_.ground.exists()) return sampled_shadows_.trace(Coherence::incoherent, buffer);
    const auto arrive = [&](size_t i, const Vec3& arrived) {
        if (is_black(arrived)) return;
        const uint32_t slot = sampled_shadows_.slot(i);
        buffer.add_radiance(slot, sampled_shadows_.light_group(i), arrived);
        const Ray& ray = sampled_shadows_.ray(i);
        const float distance = context_.ground.distance(ray);
        if (sampled_shadows_.is_endless(i) && std::isfinite(distance))
            ground.add({.slot = slot,
                        .stream = lighting_stream,
                        .point = context_.ground.point(ray, distance),
                        .seen = arrived,
                        .as = SeenAs::radiance});
    };
    sampled_shadows_.trace(Coherence::incoherent, buffer, arrive);
}

void DirectLighting::add_punctual(const LitVertex& vertex, const SampleBuffer& buffer) {
    const Surface& surface = vertex.bsdf.surface();
    for (size_t i = 0; i < context_.scene.lights.size(); ++i) {
        const auto light = sample_punctual(context_.scene.lights[i], surface.position);
        if (!light || context_.ground.blocks(surface.position, *light)) continue;
        const BsdfEval f = vertex.bsdf.eval(light->wi);
        const uint16_t group =
            buffer.light_groups ? context_.layers.names.group_of_light[i] : uint16_t{0};
        const Vec3 radiance = vertex.throughput * ((f.diffuse + f.glossy) * light->radiance);
        punctual_shadows_.add(surface, *light,
                              {.alone = radiance, .shared = Vec3(0), .through_backs = radiance},
                              vertex.slot, group, vertex.media);
    }
}

void DirectLighting::add_sampled(const LitVertex& vertex, const LightSample& light,
                                 uint16_t light_group) {
    if (!(light.pdf > 0) || is_black(light.radiance)) return;
    const BsdfEval f = vertex.bsdf.eval(light.wi);
    const Vec3 radiance = vertex.throughput * light.radiance * (1 / light.pdf);
    const Vec3 diffuse = radiance * f.diffuse;
    const bool alone = vertex.glossy == GlossyEstimator::lights_only;
    const Vec3 glossy = radiance * f.glossy * (alone ? 1 : mis_weight(light.pdf, f.pdf));
    const DirectLight arriving = vertex.glossy == GlossyEstimator::lights_and_rays
                                     ? DirectLight{diffuse, glossy, diffuse}
                                     : DirectLight{diffuse + glossy, Vec3(0), diffuse};
    sampled_shadows_.add(vertex.bsdf.surface(), light, arriving, vertex.slot, light_group,
                         vertex.media);
}

}  // namespace sightline
