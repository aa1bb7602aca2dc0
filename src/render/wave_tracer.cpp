#include "render/wave_tracer.h"

#include "core/sampler.h"

#include <algorithm>

namespace sightline {
namespace {

// The power heuristic (Veach & Guibas 1995, beta = 2).
float mis_weight(float pdf, float other) {
    const float a = pdf * pdf, b = other * other;
    return a > 0 ? a / (a + b) : 0;
}

}  // namespace

void Counters::add(const Counters& other) {
    for (size_t i = 0; i < ray_kinds; ++i) rays[i] += other.rays[i];
    coloured_shadow_rays += other.coloured_shadow_rays;
    uncovered_hits += other.uncovered_hits;
    absorbed_rays += other.absorbed_rays;
    area_light_samples += other.area_light_samples;
    environment_samples += other.environment_samples;
    cut_rays += other.cut_rays;
    samples += other.samples;
    depth_reached = std::max(depth_reached, other.depth_reached);
}

uint32_t WaveTracer::dimension(const Path& path, Dimension number) const {
    return hash_combine(seed(path), static_cast<uint32_t>(number));
}

// Points of one dimension of many paths.
template <class PathOf>
void WaveTracer::draw(size_t count, Dimension number, const PathOf& path_of, Points& points) {
    draw_indices_.resize(count);
    draw_seeds_.resize(count);
    for (size_t i = 0; i < count; ++i) {
        const Path& path = path_of(i);
        draw_indices_[i] = index(path);
        draw_seeds_[i] = seed(path);
    }
    points.x.resize(count);
    points.y.resize(count);
    sample_2d(draw_indices_, draw_seeds_, static_cast<uint32_t>(number), points.x, points.y);
}

void WaveTracer::trace(std::span<const Request> requests, std::span<Sample> samples,
                       Counters& counters, std::vector<RecordedRay>* recorded) {
    requests_ = requests;
    samples_ = samples;
    group_light_.assign(requests.size() * light_groups_, Vec3(0, 0, 0));
    seen_.clear();
    counters_ = &counters;
    recorded_ = recorded;
    counters.samples += requests.size();
    start(requests);
    for (uint64_t wave = 0; !rays_.empty(); ++wave) {
        counters.depth_reached = std::max(counters.depth_reached, wave);
        hits_.resize(rays_.size());
        t_.intersector.closest(rays_, hits_,
                               wave == 0 ? Coherence::coherent : Coherence::incoherent);
        shade_wave();
        std::swap(rays_, next_rays_);
        std::swap(paths_, next_paths_);
    }
}

void WaveTracer::start(std::span<const Request> requests) {
    const Path fresh = {.slot = 0,
                        .stream = 0,
                        .weight = Vec3(1, 1, 1),
                        .pdf = 0,
                        .width = t_.camera.pixel_width(),
                        .spread = t_.camera.pixel_spread(),
                        .depth = 0,
                        .layers = 0,
                        .from_eye = true,
                        .kind = RayKind::camera,
                        .media = {}};
    paths_.assign(requests.size(), fresh);
    seeds_.resize(requests.size());
    for (uint32_t slot = 0; slot < requests.size(); ++slot) {
        const Request& r = requests[slot];
        const bool same_pixel =
            slot > 0 && r.x == requests[slot - 1].x && r.y == requests[slot - 1].y;
        const auto x = static_cast<uint32_t>(r.x), y = static_cast<uint32_t>(r.y);
        seeds_[slot] =
            same_pixel ? seeds_[slot - 1] : hash_combine(hash_combine(x, y), t_.settings.seed);
        paths_[slot].slot = slot;
        samples_[slot] = Sample{};
    }
    aim(requests);
}

// The rays of the first wave.
void WaveTracer::aim(std::span<const Request> requests) {
    const auto path_of = [&](size_t i) -> const Path& { return paths_[i]; };
    draw(requests.size(), Dimension::pixel, path_of, on_pixel_);
    raster_x_.resize(requests.size());
    raster_y_.resize(requests.size());
    const bool adaptive = t_.settings.error > 0;
    for (size_t i = 0; i < requests.size(); ++i) {
        const Request& r = requests[i];
        const bool at_centre =
            adaptive ? r.sample == 0 && !t_.needs.noise : t_.settings.samples == 1;
        const Vec2 u = at_centre ? Vec2(0.5f, 0.5f) : on_pixel_[i];
        raster_x_[i] = static_cast<float>(r.x) + u.x;
        raster_y_[i] = static_cast<float>(r.y) + u.y;
    }
    rays_.resize(requests.size());
    if (!t_.camera.has_lens()) return t_.camera.rays(raster_x_, raster_y_, rays_);
    draw(requests.size(), Dimension::lens, path_of, on_lens_);
    for (size_t i = 0; i < requests.size(); ++i)
        rays_[i] = t_.camera.ray(raster_x_[i], raster_y_[i], on_lens_[i]);
}

void WaveTracer::shade_wave() {
    next_rays_.clear();
    next_paths_.clear();
    punctual_.clear();
    sampled_.clear();
    met_.clear();
    missed_.clear();
    for (uint32_t i = 0; i < rays_.size(); ++i) {
        record(rays_[i], paths_[i].kind, paths_[i].slot);
        (hits_[i] ? met_ : missed_).push_back(i);
    }
    shade_misses();
    draw_for_hits();
    for (size_t k = 0; k < met_.size(); ++k) shade_hit(k);
    const bool first = !paths_.empty() && paths_[0].depth == 0;
    resolve(punctual_, first ? Coherence::coherent : Coherence::incoherent);
    resolve(sampled_, Coherence::incoherent);
}

void WaveTracer::shade_misses() {
    size_t lit = 0;  // those that see the environment move to the front
    for (const uint32_t i : missed_) {
        const Path& path = paths_[i];
        Sample& sample = samples_[path.slot];
        const bool seen = path.from_eye && t_.settings.background != Background::environment;
        if (seen && t_.settings.background == Background::transparent) {
            sample.alpha -= luminance(path.weight);
        } else if (t_.environment && !seen) {
            missed_[lit++] = i;
        } else if (t_.settings.background == Background::color) {
            // Without an environment the colour behind the scene is what it mirrors, too.
            add_light(path.slot, t_.names.environment, path.weight * t_.settings.background_color);
        }
    }
    missed_.resize(lit);
    if (missed_.empty()) return;
    directions_.resize(lit);
    bool sampled = false;
    for (size_t k = 0; k < lit; ++k) {
        directions_[k] = rays_[missed_[k]].direction;
        sampled = sampled || paths_[missed_[k]].pdf > 0;
    }
    radiances_.resize(lit);
    pdfs_.resize(sampled && t_.needs.environment_light ? lit : 0);
    t_.environment->look_up(directions_, radiances_, pdfs_);
    for (size_t k = 0; k < lit; ++k) {
        const Path& path = paths_[missed_[k]];
        const float mis = path.pdf > 0 && !pdfs_.empty() ? mis_weight(path.pdf, pdfs_[k]) : 1;
        add_light(path.slot, t_.names.environment, path.weight * radiances_[k] * mis);
    }
}

// What each hit of the wave will need of random numbers, and a direction of the environment.
void WaveTracer::draw_for_hits() {
    const size_t count = met_.size();
    const auto path_of = [&](size_t k) -> const Path& { return paths_[met_[k]]; };
    if (t_.needs.secondary_rays && t_.needs.noise)
        draw(count, Dimension::reflection, path_of, on_lobe_);
    if (t_.needs.area_lights) {
        draw(count, Dimension::emitter, path_of, on_emitter_);
        draw(count, Dimension::which_emitter, path_of, which_emitter_);
    }
    if (!t_.needs.environment_light || !t_.environment) return;
    draw(count, Dimension::environment, path_of, on_environment_);
    environment_samples_.resize(count);
    t_.environment->sample(on_environment_.x, on_environment_.y, environment_samples_);
}

void WaveTracer::shade_hit(size_t k) {
    Path path = paths_[met_[k]];
    const Ray& ray = rays_[met_[k]];
    const Hit& hit = hits_[met_[k]];
    const float width = path.width + path.spread * hit.t;
    Surface surface = t_.surfaces.at(ray, hit, width);
    if (t_.needs.volumes && path.media.count > 0) {
        const Vec3& absorption = t_.absorption[path.media.current()];
        if (!is_black(absorption)) {
            path.weight *= attenuate(absorption, hit.t);
            ++counters_->absorbed_rays;
        }
    }
    if (t_.needs.pass_through && surface.alpha < 1) {
        ++counters_->uncovered_hits;
        if (path.layers < max_layers) continue_behind(path, ray, surface, hit.t);
        if (surface.alpha <= 0) return;
        path.weight *= surface.alpha;
    }
    if (path.from_eye && t_.needs.first_hits) record_first(path, ray, hit, surface);
    if (path.from_eye && !t_.names.object_ids.empty())
        seen_.push_back({path.slot, hit.instance, surface.material, path.weight.x});
    add_emission(path, ray, hit, surface);
    if (surface.has(feature_unlit)) return;
    if (surface.has(feature_volume)) surface.eta = eta_at(path.media, surface);
    const bool lobes_are_traced = t_.needs.secondary_rays && send_on(path, surface, k, width);
    light_directly(path, surface, k, lobes_are_traced);
}

// Index of the medium beyond the boundary over that of the medium on the ray's side.
float WaveTracer::eta_at(const MediumStack& media, const Surface& surface) const {
    const auto ior_of = [&](uint32_t m) { return m == none ? 1.0f : t_.scene.materials[m].ior; };
    MediumStack beyond = media;
    surface.front ? beyond.enter(surface.material) : beyond.leave(surface.material);
    return ior_of(beyond.current()) / ior_of(media.current());
}

void WaveTracer::record_first(const Path& path, const Ray& ray, const Hit& hit,
                              const Surface& surface) {
    FirstHit& first = samples_[path.slot].first;
    if (first.valid) return;
    const Vec3 view = transform_point(surface.position, t_.camera.world_to_camera());
    first = {.valid = true,
             .depth = -view.z,
             .position = surface.position,
             .normal = surface.ns,
             .albedo = surface.base_color,
             // Only the pixel's first sample is asked for it.
             .uv = index(path) == 0 ? t_.surfaces.texcoord(ray, hit) : Vec2(0, 0),
             .object = hit.instance,
             .material = surface.material};
}

void WaveTracer::continue_behind(const Path& path, const Ray& ray, const Surface& surface,
                                 float distance) {
    Path behind = path;
    behind.weight *= 1 - surface.alpha;
    if (max_component(behind.weight) < t_.settings.cutoff) return;
    behind.width += behind.spread * distance;
    ++behind.layers;
    next_rays_.push_back(spawn_ray(surface, ray.direction, ray.tfar - distance));
    next_paths_.push_back(behind);
}

void WaveTracer::add_emission(const Path& path, const Ray& ray, const Hit& hit,
                              const Surface& surface) {
    if (is_black(surface.emission)) return;
    float weight = 1;
    if (path.pdf > 0 && t_.needs.area_lights)
        weight = mis_weight(path.pdf, t_.area_lights.pdf(ray, hit));
    add_light(path.slot, t_.names.emission, path.weight * surface.emission * weight);
}

bool WaveTracer::send_on(const Path& path, const Surface& surface, size_t k, float width) {
    if (path.depth >= t_.needs.depth) return false;
    std::array<SecondaryRay, 2> children;
    Vec2 u_reflect(0, 0), u_refract(0, 0);
    float u_lobe = 0;
    const bool rough = is_rough(surface);
    if (rough && t_.needs.noise) {  // smooth lobes have one direction: nothing to choose
        u_reflect = on_lobe_[k];
        if (surface.has(feature_transmission))
            u_refract = sample_2d(index(path), dimension(path, Dimension::refraction));
        if (surface.has(feature_clearcoat))
            u_lobe = sample_1d(index(path), dimension(path, Dimension::coat));
    }
    const int count = sample_secondary(surface, u_reflect, u_refract, u_lobe, children);
    bool too_faint = false;
    for (int i = 0; i < count; ++i) {
        const SecondaryRay& child = children[static_cast<size_t>(i)];
        const Vec3 weight = path.weight * child.weight;
        if (!(max_component(weight) >= t_.settings.cutoff)) {
            ++counters_->cut_rays;
            too_faint = too_faint || child.pdf > 0;
            continue;
        }
        Path& next = next_paths_.emplace_back(path);
        next.weight = weight;
        next.pdf = child.pdf;
        next.stream = hash_combine(path.stream, child.refracted ? 2 : 1);
        next.width = width;
        next.spread = child.pdf > 0 ? std::max(path.spread, 0.1f * surface.roughness) : path.spread;
        ++next.depth;
        next.layers = 0;
        next.from_eye = false;
        next.kind = child.refracted ? RayKind::refraction : RayKind::reflection;
        if (child.enters_volume) next.media.enter(surface.material);
        if (child.leaves_volume) next.media.leave(surface.material);
        next_rays_.push_back(
            spawn_ray(surface, child.direction, std::numeric_limits<float>::infinity()));
    }
    // Also where this sample's ray was lost below the horizon: the lights' share must not depend on
    // the draw. But a lobe too faint to be traced leaves all of its light to them.
    return rough && !too_faint;
}

void WaveTracer::light_directly(const Path& path, const Surface& surface, size_t k,
                                bool lobes_are_traced) {
    if (t_.settings.integrator == Integrator::appel && t_.environment) {
        // Appel's picture has no light but the lamps'; an environment is its constant ambient.
        add_light(path.slot, t_.names.environment, path.weight * surface.base_color * t_.ambient);
    }
    if (!scatters(surface)) return;
    for (size_t i = 0; i < t_.scene.lights.size(); ++i) {
        const auto sample = sample_punctual(t_.scene.lights[i], surface.position);
        if (!sample) continue;
        const BsdfValue f = evaluate_bsdf(surface, sample->wi);
        const uint16_t group = light_groups_ ? t_.names.group_of_light[i] : uint16_t{0};
        add_shadow(punctual_, path, surface, *sample, (f.diffuse + f.glossy) * sample->radiance,
                   group);
    }
    const auto add_sampled = [&](const LightSample& sample, uint16_t group) {
        if (!(sample.pdf > 0) || is_black(sample.radiance)) return;
        const BsdfValue f = evaluate_bsdf(surface, sample.wi);
        const float mis = lobes_are_traced ? mis_weight(sample.pdf, f.glossy_pdf) : 1;
        add_shadow(sampled_, path, surface, sample,
                   (f.diffuse + f.glossy * mis) * sample.radiance * (1 / sample.pdf), group);
    };
    if (t_.needs.environment_light && t_.environment) {
        ++counters_->environment_samples;
        const EnvironmentSample& s = environment_samples_[k];
        add_sampled({s.wi, std::numeric_limits<float>::infinity(), s.radiance, s.pdf},
                    t_.names.environment);
    }
    if (t_.needs.area_lights && !t_.area_lights.empty()) {
        ++counters_->area_light_samples;
        if (const auto s =
                t_.area_lights.sample(surface.position, on_emitter_[k], which_emitter_.x[k]))
            add_sampled(*s, t_.names.emission);
    }
}

}  // namespace sightline
