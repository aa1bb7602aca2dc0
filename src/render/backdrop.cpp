#include "render/backdrop.h"

#include "render/direct_light.h"

#include <algorithm>

namespace sightline {

void Backdrop::pass_ground(Wave& wave) const {
    wave.ground.resize(wave.rays.size());
    for (size_t i = 0; i < wave.rays.size(); ++i) {
        const Ray& ray = wave.rays[i];
        Hit& hit = wave.hits[i];
        const Path& path = wave.paths[i];
        // An orthographic view comes from infinity, wherever its camera stands.
        const bool from_infinity = context_.settings.camera.orthographic && path.from_camera &&
                                   path.layers == 0 && ray.direction.y < 0;
        const float distance =
            from_infinity ? context_.ground.line_distance(ray) : context_.ground.distance(ray);
        const bool passes = distance <= ray.tfar && (!hit || distance < hit.t) &&
                            (from_infinity || distance > ray.tnear);
        wave.ground[i] = passes ? distance : std::numeric_limits<float>::infinity();
        if (passes) hit = Hit{};
    }
}

void Backdrop::add(const Wave& wave, GroundShadows& ground, SampleBuffer& buffer) {
    rays_.clear();
    for (const uint32_t i : wave.miss_indices) {
        const Path& path = wave.paths[i];
        // What the ground mirrors of the backdrop is taken for what is seen on the ground.
        if (path.mirrored) continue;
        const bool on_ground = std::isfinite(ground_distance(wave, i));
        const bool on_surface = on_ground && context_.ground.is_surface();
        const bool sees = sees_background(path);
        const bool is_covered = on_surface && !(context_.ground.is_cyclorama() && sees);
        // Without an environment, mirrors show the background colour, too.
        const bool mirrors_color =
            !context_.environment && context_.settings.background == Background::color;
        if (!is_covered && (sees || mirrors_color))
            add_background(wave, i, ground, buffer);
        else if (is_covered || context_.environment)
            rays_.push_back(i);
    }
    if (!rays_.empty()) add_environment(wave, ground, buffer);
}

bool Backdrop::sees_background(const Path& path) const {
    return context_.settings.background != Background::environment && path.sees_backdrop;
}

void Backdrop::add_background(const Wave& wave, uint32_t i, GroundShadows& ground,
                              SampleBuffer& buffer) {
    const Path& path = wave.paths[i];
    const LayerNames& names = context_.layers.names;
    const float distance = ground_distance(wave, i);
    const bool on_ground = std::isfinite(distance);
    if (context_.settings.background == Background::transparent) {
        buffer.add_through(path.slot, path.throughput);
        if (on_ground) add_ground_view(wave, i, Vec3(1), 1, SeenAs::transparent, ground, buffer);
        return;
    }
    const Vec3 color = on_ground && context_.ground.is_surface()
                           ? context_.ground.radiance(context_.ground.point(wave.rays[i], distance))
                           : context_.settings.background_color;
    const bool shown = sees_background(path) && names.shown;
    buffer.add_radiance(path.slot, names.environment, path.throughput * color);
    if (shown) buffer.add_shown(path.slot, path.throughput, color);
    if (on_ground)
        add_ground_view(wave, i, color, 1, shown ? SeenAs::shown : SeenAs::radiance, ground,
                        buffer);
}

// wb · throughput · environment, for the rays in rays_.
void Backdrop::add_environment(const Wave& wave, GroundShadows& ground, SampleBuffer& buffer) {
    directions_.clear();
    for (const uint32_t i : rays_) directions_.push_back(wave.rays[i].direction);
    const bool use_mis =
        context_.needs.environment_light && context_.environment &&
        std::ranges::any_of(rays_, [&](uint32_t i) { return wave.paths[i].pdf > 0; });
    radiances_.assign(rays_.size(), Vec3(0, 0, 0));
    pdfs_.resize(use_mis ? rays_.size() : 0);
    if (context_.environment) context_.environment->look_up(directions_, radiances_, pdfs_);
    for (size_t k = 0; k < rays_.size(); ++k) {
        const uint32_t i = rays_[k];
        const Path& path = wave.paths[i];
        if (context_.is_last(path.depth) && !use_mis) continue;
        const float distance = ground_distance(wave, i);
        const bool on_ground = std::isfinite(distance);
        Vec3 radiance = path.from_camera && context_.backdrop->blurred
                            ? context_.backdrop->blurred->radiance(directions_[k])
                            : radiances_[k];
        if (on_ground && context_.ground.is_surface())
            radiance = context_.ground.radiance(context_.ground.point(wave.rays[i], distance));
        const float weight = path.pdf > 0 && use_mis ? mis_weight(path.pdf, pdfs_[k]) : 1;
        buffer.add_radiance(path.slot, context_.layers.names.environment,
                            path.throughput * radiance * weight);
        if (on_ground) add_ground_view(wave, i, radiance, weight, SeenAs::radiance, ground, buffer);
    }
}

// `unshadowed` has this weight in what the path sees.
void Backdrop::add_ground_view(const Wave& wave, uint32_t i, const Vec3& unshadowed, float weight,
                               SeenAs as, GroundShadows& ground, SampleBuffer& buffer) const {
    const Path& path = wave.paths[i];
    const Vec3 p = context_.ground.point(wave.rays[i], wave.ground[i]);
    const bool mirrors = path.from_camera && context_.ground.mirrors();
    if (mirrors) buffer.samples[path.slot].ground = unshadowed;
    ground.add({.slot = path.slot,
                .stream = path.stream ^ path.depth,
                .point = p,
                .seen = path.throughput * unshadowed * weight,
                .as = as,
                .mirrored = mirrors ? path.throughput.x : 0,
                .albedo = context_.is_last(path.depth)
                              ? Vec3(0)
                              : path.throughput * context_.ground.albedo(p)});
}

}  // namespace sightline
