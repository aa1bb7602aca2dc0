#include "render/shadow_rays.h"

#include <algorithm>

namespace sightline {

namespace {

bool is_gone(const DirectLight& light) { return is_black(light.alone) && is_black(light.shared); }

}  // namespace

LayerTransmittance straight_transmittance(const RenderContext& context, const MediumStack& media,
                                          Surface& surface) {
    const bool is_boundary = surface.has(feature_volume);
    if (is_boundary) surface.eta = context.relative_ior(media, surface);
    // A straight ray has no total reflection: what bends has the same reflectance from both sides.
    if (is_boundary && !transmission_is_unbent(surface)) surface.eta = surface.ior;
    return layer_transmittance(surface);
}

void ShadowRays::add(const Surface& surface, const LightSample& light, const DirectLight& arriving,
                     uint32_t slot, uint16_t light_group, const MediumStack& media) {
    if (is_gone(arriving)) return;
    rays_.push_back(spawn_shadow_ray(surface, light.wi, light.distance));
    // Ends short of an area light, so that the emitter does not shadow itself.
    if (light.pdf > 0) rays_.back().tfar *= 1 - 0x1p-12f;
    shadows_.push_back(
        {arriving, slot, light_group, std::isinf(light.distance), surface.id, media});
    if (context_.ground.exists())
        rays_.back().tfar = std::min(rays_.back().tfar, context_.ground.distance(rays_.back()));
    // Light from below the surface has crossed its boundary.
    if (surface.has(feature_volume) && dot(light.wi, surface.ng) < 0)
        shadows_.back().media = beyond(surface, media);
}

void ShadowRays::add(const Ray& ray, const DirectLight& arriving, uint32_t slot) {
    rays_.push_back(ray);
    shadows_.push_back({arriving, slot, 0, std::isinf(ray.tfar), {}, {}});
}

void ShadowRays::trace(Coherence coherence, SampleBuffer& samples) {
    trace(coherence, samples, [&](size_t i, const Vec3& arrived) {
        if (!occluded_[i]) samples.add_radiance(shadows_[i].slot, shadows_[i].light_group, arrived);
    });
}

void ShadowRays::cross_layers(Coherence coherence, SampleBuffer& samples) {
    for (size_t i = 0; i < rays_.size(); ++i)
        samples.count_ray(rays_[i], RayKind::shadow, shadows_[i].slot, shadows_[i].source);
    occluded_.resize(rays_.size());
    const bool coloured = context_.needs.coloured_shadows;
    context_.intersector.occluded(rays_, occluded_, coherence,
                                  coloured ? Visible::opaque : Visible::all);
    if (context_.single_sided.any_pass()) {
        list_rays(true);
        trace_layers(Visible::all, *samples.counters);
    }
    if (coloured) {
        list_rays(false);
        trace_layers(Visible::translucent, *samples.counters);
    }
}

void ShadowRays::list_rays(bool occluded) {
    crossing_.clear();
    for (uint32_t i = 0; i < rays_.size(); ++i)
        if ((occluded_[i] != 0) == occluded) crossing_.push_back(i);
}

// Takes the listed rays through the surfaces before them, one layer a round and nearest first, and
// colours their light. A ray whose light has gone is occluded, the others are not.
void ShadowRays::trace_layers(Visible visible, Counters& counters) {
    for (const uint32_t i : crossing_) occluded_[i] = 0;
    for (int round = 0; !crossing_.empty(); ++round) {
        layer_rays_.clear();
        for (const uint32_t i : crossing_) layer_rays_.push_back(rays_[i]);
        layer_hits_.resize(crossing_.size());
        context_.intersector.closest(layer_rays_, layer_hits_, Coherence::incoherent, visible);
        if (round == 0 && visible == Visible::translucent)
            counters.coloured_shadow_rays += static_cast<uint64_t>(
                std::ranges::count_if(layer_hits_, [](const Hit& hit) { return bool(hit); }));
        size_t left = 0;
        for (size_t begin = 0; begin < crossing_.size(); begin += surface_block) {
            const size_t end = std::min(begin + surface_block, crossing_.size());
            find_layers(begin, end, round == max_layers, visible);
            for (Layer& layer : layers_) {
                const uint32_t i = layer.ray;
                cross_coincident(shadows_[i], rays_[i], layer);
                if (is_gone(shadows_[i].light))
                    occluded_[i] = 1;
                else
                    crossing_[left++] = i;
            }
        }
        crossing_.resize(left);
    }
}

// The layers before the rays crossing_[begin…end) and what coincides with them; all that `last`
// leaves are blocked.
void ShadowRays::find_layers(size_t begin, size_t end, bool last, Visible visible) {
    layers_.clear();
    coincident_hits_.clear();
    for (size_t k = begin; k < end; ++k) {
        const Hit& hit = layer_hits_[k];
        const uint32_t i = crossing_[k];
        if (!hit) continue;
        if (last || blocks_all(hit)) {
            occluded_[i] = 1;
            continue;
        }
        layers_.push_back({i, hit, context_.surfaces.at(rays_[i], hit, 0, Faces::all), {}});
        layers_.back().coincident = coincident_hits_.add(rays_[i], hit, layers_.back().surface);
    }
    coincident_hits_.search(visible);
}

// True if no light passes the surface from any side.
bool ShadowRays::blocks_all(const Hit& hit) const {
    const uint32_t material = context_.scene.material_of(hit.geometry);
    return !is_translucent(context_.scene.materials[material]) &&
           !context_.single_sided.passes(material);
}

// Removes the light that the medium before the layer and all surfaces that coincide with it keep
// back; moves the ray's origin behind them.
void ShadowRays::cross_coincident(Shadow& shadow, Ray& ray, Layer& layer) {
    if (context_.needs.volumes && shadow.media.count > 0) {
        const Vec3 medium = attenuate(context_.absorption[shadow.media.current()], layer.hit.t);
        shadow.light.attenuate(medium, medium);
    }
    Surface& surface = layer.surface;
    std::span<const Hit> coincident(&layer.hit, 1);
    if (layer.coincident) coincident = coincident_hits_.at(*layer.coincident);
    for (const Hit& hit : coincident) {
        if (coincident.size() > 1) {
            surface = context_.surfaces.at(ray, hit, 0, Faces::all);
            coincident_hits_.widen(surface);
        }
        attenuate_by_layer(shadow, surface);
    }
    ray = spawn_ray(surface, ray.direction, ray.tfar - layer.hit.t);
}

void ShadowRays::attenuate_by_layer(Shadow& shadow, Surface& surface) const {
    DirectLight& light = shadow.light;
    // A ray towards a light meets the front of what the light meets from behind.
    if (surface.front && context_.single_sided.passes(surface.material)) {
        light.alone = light.through_backs;
        light.shared = Vec3(0);
        return;
    }
    const LayerTransmittance layer = straight_transmittance(context_, shadow.media, surface);
    light.attenuate(layer.unbent + layer.bent, layer.unbent);
    if (surface.has(feature_volume)) shadow.media = beyond(surface, shadow.media);
}

}  // namespace sightline
