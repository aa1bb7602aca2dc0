// The shadow rays of WaveTracer.
#include "render/wave_tracer.h"

namespace sightline {

void WaveTracer::add_shadow(ShadowWave& wave, const Path& path, const Surface& surface,
                            const LightSample& sample, const Vec3& light, uint16_t group) {
    const Vec3 arriving = path.weight * light;
    if (is_black(arriving)) return;
    // Ends short of an area light, so that the emitter does not shadow itself.
    const float length = sample.pdf > 0 ? sample.distance * (1 - 0x1p-12f) : sample.distance;
    wave.rays.push_back(spawn_shadow_ray(surface, sample.wi, length));
    wave.shadows.push_back({arriving, path.slot, group, path.media});
    // Light from below the surface has crossed its boundary.
    if (surface.has(feature_volume) && dot(sample.wi, surface.ng) < 0) {
        MediumStack& media = wave.shadows.back().media;
        surface.front ? media.enter(surface.material) : media.leave(surface.material);
    }
}

void WaveTracer::resolve(ShadowWave& wave, Coherence coherence) {
    if (wave.rays.empty()) return;
    for (size_t i = 0; i < wave.rays.size(); ++i)
        record(wave.rays[i], RayKind::shadow, wave.shadows[i].slot);
    blocked_.resize(wave.rays.size());
    t_.intersector.occluded(wave.rays, blocked_, coherence,
                            t_.needs.coloured_shadows ? Visible::opaque : Visible::all);
    if (t_.needs.coloured_shadows) filter_light(wave);
    for (size_t i = 0; i < wave.shadows.size(); ++i) {
        const Shadow& shadow = wave.shadows[i];
        if (!blocked_[i]) add_light(shadow.slot, shadow.group, shadow.light);
    }
}

// Walks the unblocked shadow rays through the translucent surfaces on their way, one layer a round
// and nearest first, and colours their light; sets `blocked_` where nothing is left.
void WaveTracer::filter_light(ShadowWave& wave) {
    std::vector<uint32_t>& open = open_shadows_;
    open.clear();
    for (uint32_t i = 0; i < wave.rays.size(); ++i)
        if (!blocked_[i]) open.push_back(i);
    for (int layer = 0; !open.empty(); ++layer) {
        layer_rays_.clear();
        for (const uint32_t i : open) layer_rays_.push_back(wave.rays[i]);
        layer_hits_.resize(open.size());
        t_.intersector.closest(layer_rays_, layer_hits_, Coherence::incoherent,
                               Visible::translucent);
        size_t left = 0;
        for (size_t k = 0; k < open.size(); ++k) {
            if (!layer_hits_[k]) continue;
            const uint32_t i = open[k];
            if (layer == 0) ++counters_->coloured_shadow_rays;
            pass_layer(wave.shadows[i], wave.rays[i], layer_hits_[k]);
            if (layer == max_layers || is_black(wave.shadows[i].light)) {
                blocked_[i] = 1;
            } else {
                open[left++] = i;
            }
        }
        open.resize(left);
    }
}

// Takes from the light what the surface at the hit and the interior before it keep; moves the ray
// behind the surface.
void WaveTracer::pass_layer(Shadow& shadow, Ray& ray, const Hit& hit) const {
    const Surface surface = t_.surfaces.at(ray, hit, 0);
    if (t_.needs.volumes && shadow.media.count > 0)
        shadow.light *= attenuate(t_.absorption[shadow.media.current()], hit.t);
    shadow.light *= t_.surfaces.transmittance(hit, ray);
    if (t_.needs.volumes && surface.has(feature_volume)) {
        surface.front ? shadow.media.enter(surface.material) : shadow.media.leave(surface.material);
    }
    ray = spawn_ray(surface, ray.direction, ray.tfar - hit.t);
}

}  // namespace sightline
