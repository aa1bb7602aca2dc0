#include "render/ground_shadows.h"

#include "core/sampler.h"

namespace sightline {
namespace {

// Other than those of WaveTracer.
constexpr uint32_t sky_dimension = 100, emitter_dimension = 101, which_emitter_dimension = 102;

}  // namespace

SeenAs seen_as(Background background) {
    if (background == Background::environment) return SeenAs::radiance;
    return background == Background::color ? SeenAs::shown : SeenAs::transparent;
}

void GroundShadows::trace(SampleBuffer& buffer) {
    if (views_.empty()) return;
    shadows_.clear();
    given_.clear();
    if (context_.ground.sky()) sample_sky(buffer);
    for (uint32_t view = 0; view < views_.size(); ++view) add_lights(view);
    if (context_.needs.area_lights && context_.ground.is_surface()) sample_emitters(buffer);
    shadows_.trace(Coherence::incoherent, buffer, [&](size_t i, const Vec3& arrived) {
        if (arrived != given_[i].light) lose(given_[i], given_[i].light - arrived, buffer);
    });
}

void GroundShadows::generate_samples(uint32_t dimension, const SampleBuffer& buffer) {
    const size_t count = views_.size();
    indices_.resize(count);
    seeds_.resize(count);
    x_.resize(count);
    y_.resize(count);
    for (size_t i = 0; i < count; ++i) {
        const SampleRequest& request = buffer.requests[views_[i].slot];
        const uint32_t pixel =
            hash_combine(static_cast<uint32_t>(request.x), static_cast<uint32_t>(request.y));
        indices_[i] = request.index;
        seeds_[i] = hash_combine(pixel, context_.settings.seed) ^ views_[i].stream;
    }
    sample_2d(indices_, seeds_, dimension, x_, y_);
}

void GroundShadows::sample_sky(const SampleBuffer& buffer) {
    generate_samples(sky_dimension, buffer);
    sky_.resize(views_.size());
    context_.ground.sky()->sample(x_, y_, sky_);
}

// What a surface sends on of emitters comes on top of the light without shadows.
void GroundShadows::sample_emitters(SampleBuffer& buffer) {
    generate_samples(emitter_dimension, buffer);
    emitter_x_ = x_;
    emitter_y_ = y_;
    generate_samples(which_emitter_dimension, buffer);
    for (uint32_t i = 0; i < views_.size(); ++i) {
        const GroundView& view = views_[i];
        if (is_black(view.albedo)) continue;
        ++buffer.counters->area_light_samples;
        const auto light =
            context_.area_lights.sample(view.point, {emitter_x_[i], emitter_y_[i]}, {x_[i], y_[i]});
        if (!light || !(light->wi.y > 0 && light->pdf > 0)) continue;
        const Vec3 sent = view.albedo * light->radiance * (light->wi.y / (pi * light->pdf));
        if (is_black(sent)) continue;
        given_.push_back({i, Vec3(0), context_.layers.names.emission});
        // Ends short of the emitter, as rays from surfaces do.
        shadows_.add({view.point, 0, light->wi, light->distance * (1 - 0x1p-12f)},
                     {.alone = sent, .shared = Vec3(0), .through_backs = sent}, view.slot);
    }
}

void GroundShadows::add_lights(uint32_t view) {
    const Vec3& p = views_[view].point;
    const Vec3 all = context_.ground.irradiance(p);
    const auto share = [&](const Vec3& irradiance) {
        Vec3 result(0, 0, 0);
        for (int c = 0; c < 3; ++c)
            if (all[c] > 0) result[c] = irradiance[c] / all[c];
        return result;
    };
    if (context_.ground.sky() && sky_[view].pdf > 0) {
        const EnvironmentSample& s = sky_[view];
        add_ray(view, {s.wi, std::numeric_limits<float>::infinity(), s.radiance, s.pdf},
                share(s.radiance * (1 / s.pdf)));
    }
    for (const Light& light : context_.scene.lights)
        if (const auto sample = sample_punctual(light, p))
            add_ray(view, *sample, share(sample->radiance * sample->wi.y));
}

void GroundShadows::add_ray(uint32_t view, const LightSample& light, const Vec3& share) {
    const GroundView& from = views_[view];
    if (light.wi.y <= 0 || !context_.ground.may_meet_scene(from.point, light.wi)) return;
    const Vec3 light_seen = share * from.seen;
    if (is_black(light_seen)) return;
    given_.push_back({view, light_seen, context_.layers.names.environment});
    shadows_.add({from.point, 0, light.wi, light.distance},
                 {.alone = light_seen, .shared = Vec3(0), .through_backs = light_seen}, from.slot);
}

void GroundShadows::lose(const Given& given, const Vec3& loss, SampleBuffer& buffer) const {
    const GroundView& view = views_[given.view];
    take(view.slot, view.as, given.light_group, loss, buffer);
    if (view.mirrored > 0) buffer.samples[view.slot].ground -= loss * (1 / view.mirrored);
}

void GroundShadows::take(uint32_t slot, SeenAs as, uint16_t light_group, const Vec3& loss,
                         SampleBuffer& buffer) const {
    Sample& sample = buffer.samples[slot];
    if (as == SeenAs::transparent) {
        sample.alpha += luminance(loss);
        sample.through -= loss;
        return;
    }
    buffer.add_radiance(slot, light_group, -loss);
    if (as == SeenAs::shown && context_.layers.names.shown) sample.shown -= loss;
}

void GroundShadows::cover(uint32_t slot, const Vec3& throughput, SampleBuffer& buffer) const {
    const SeenAs as = seen_as(context_.settings.background);
    Sample& sample = buffer.samples[slot];
    take(slot, as, context_.layers.names.environment, throughput * sample.ground, buffer);
    if (as == SeenAs::transparent) sample.through_share -= luminance(throughput);
    if (as == SeenAs::shown) sample.shown_share -= luminance(throughput);
}

}  // namespace sightline
