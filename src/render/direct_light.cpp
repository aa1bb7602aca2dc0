#include "render/direct_light.h"

namespace sightline {

void DirectLighting::add(const LitVertex& vertex, const LightSamples& samples,
                         SampleBuffer& buffer) {
    add_punctual(vertex, buffer);
    const LayerNames& names = context_.layers.names;
    if (samples.environment) {
        ++buffer.counters->environment_samples;
        const EnvironmentSample& s = *samples.environment;
        add_sampled(vertex, {s.wi, std::numeric_limits<float>::infinity(), s.radiance, s.pdf},
                    names.environment);
    }
    if (context_.needs.area_lights && !context_.area_lights.empty()) {
        ++buffer.counters->area_light_samples;
        if (const auto light = context_.area_lights.sample(vertex.bsdf.surface().position,
                                                           samples.emitter, samples.which_emitter))
            add_sampled(vertex, *light, names.emission);
    }
}

void DirectLighting::trace(Coherence coherence, SampleBuffer& buffer) {
    punctual_shadows_.trace(coherence, buffer);
    sampled_shadows_.trace(Coherence::incoherent, buffer);
}

void DirectLighting::add_punctual(const LitVertex& vertex, const SampleBuffer& buffer) {
    const Surface& surface = vertex.bsdf.surface();
    for (size_t i = 0; i < context_.scene.lights.size(); ++i) {
        const auto light = sample_punctual(context_.scene.lights[i], surface.position);
        if (!light) continue;
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
