#include "render/wave_tracer.h"

#include "core/sampler.h"
#include "render/sampling_rounds.h"

#include <algorithm>

namespace sightline {
namespace {

/// Where a ground mirrors less of the light than this, few of its mirrored rays are traced, and
/// each counts for those that are not. They are stratified over a pixel's samples, so that they are
/// less noisy than the shadows beside them.
constexpr float faint_mirror = 0.25f;

}  // namespace

WaveTracer::WaveTracer(const RenderContext& context)
    : context_(context),
      coincident_hits_(context.scene, context.intersector, context.lone_surfaces,
                       context.translucent_bounds),
      ground_shadows_(context),
      backdrop_(context),
      direct_light_(context) {
    buffer_.light_groups = context.layers.names.light_groups.size();
}

const SampleBuffer& WaveTracer::trace(std::span<const SampleRequest> requests, Counters& counters,
                                      std::vector<RecordedRay>* recorded) {
    buffer_.counters = &counters;
    buffer_.recorded = recorded;
    buffer_.start(requests);
    counters.samples += requests.size();
    generate_camera_rays();
    for (uint64_t wave = 0; !wave_.rays.empty(); ++wave) {
        counters.depth_reached = std::max(counters.depth_reached, wave);
        next_wave_.clear();
        direct_light_.clear();
        ground_shadows_.clear();

        intersect_closest(wave == 0 ? Coherence::coherent : Coherence::incoherent);
        handle_escaped_rays();
        generate_hit_samples();
        evaluate_materials();
        const bool first_bounce = wave_.paths[0].depth == 0;
        direct_light_.trace(first_bounce ? Coherence::coherent : Coherence::incoherent,
                            ground_shadows_, buffer_);
        ground_shadows_.trace(buffer_);

        std::swap(wave_, next_wave_);
    }
    return buffer_;
}

void WaveTracer::generate_camera_rays() {
    const std::span<const SampleRequest> requests = buffer_.requests;
    const size_t count = requests.size();
    wave_.paths.assign(count, {.slot = 0,
                               .stream = 0,
                               .throughput = Vec3(1, 1, 1),
                               .pdf = 0,
                               .straight_length = 0,
                               .cone_width = context_.camera.pixel_width(),
                               .cone_spread = context_.camera.pixel_spread(),
                               .depth = 0,
                               .layers = 0,
                               .from_camera = true,
                               .sees_backdrop = true,
                               .mirrored = false,
                               .kind = RayKind::camera,
                               .channel = all_channels,
                               .source = {},
                               .media = {}});
    pixel_seeds_.resize(count);
    for (uint32_t slot = 0; slot < count; ++slot) {
        const SampleRequest& r = requests[slot];
        const auto x = static_cast<uint32_t>(r.x), y = static_cast<uint32_t>(r.y);
        const bool same_pixel =
            slot > 0 && r.x == requests[slot - 1].x && r.y == requests[slot - 1].y;
        pixel_seeds_[slot] = same_pixel ? pixel_seeds_[slot - 1]
                                        : hash_combine(hash_combine(x, y), context_.settings.seed);
        const float per_axis = std::sqrt(
            static_cast<float>(samples_after_round(context_.settings, context_.needs, r.index)));
        wave_.paths[slot].slot = slot;
        wave_.paths[slot].cone_width /= per_axis;
        wave_.paths[slot].cone_spread /= per_axis;
    }
    auto& [pixel, lens, raster_x, raster_y] = camera_samples_;
    const auto path_at = [&](size_t i) -> const Path& { return wave_.paths[i]; };
    generate_samples(Dimension::pixel, count, path_at, pixel);
    raster_x.resize(count);
    raster_y.resize(count);
    const bool adaptive = context_.settings.error > 0;
    for (size_t i = 0; i < count; ++i) {
        const SampleRequest& r = requests[i];
        const bool at_centre =
            adaptive ? r.index == 0 && !context_.needs.noise : context_.settings.samples == 1;
        const Vec2 u = at_centre ? Vec2(0.5f, 0.5f) : pixel[i];
        raster_x[i] = static_cast<float>(r.x) + u.x;
        raster_y[i] = static_cast<float>(r.y) + u.y;
    }
    wave_.rays.resize(count);
    if (!context_.camera.has_lens()) return context_.camera.rays(raster_x, raster_y, wave_.rays);
    generate_samples(Dimension::lens, count, path_at, lens);
    for (size_t i = 0; i < count; ++i)
        wave_.rays[i] = context_.camera.ray(raster_x[i], raster_y[i], lens[i]);
}

void WaveTracer::intersect_closest(Coherence coherence) {
    wave_.hits.resize(wave_.rays.size());
    context_.intersector.closest(wave_.rays, wave_.hits, coherence);
    if (context_.ground.exists()) backdrop_.pass_ground(wave_);
    wave_.hit_indices.clear();
    wave_.miss_indices.clear();
    for (uint32_t i = 0; i < wave_.rays.size(); ++i) {
        const Path& path = wave_.paths[i];
        buffer_.count_ray(wave_.rays[i], path.kind, path.slot, path.source);
        (wave_.hits[i] ? wave_.hit_indices : wave_.miss_indices).push_back(i);
    }
}

void WaveTracer::handle_escaped_rays() {
    if (context_.ground.mirrors())
        for (const uint32_t i : wave_.miss_indices) spawn_ground_mirror(i);
    backdrop_.add(wave_, ground_shadows_, buffer_);
}

// The ground mirrors what the camera sees of it directly. A picture without noise gets none by it.
void WaveTracer::spawn_ground_mirror(uint32_t i) {
    const float distance = wave_.ground[i];
    if (!wave_.paths[i].from_camera || std::isinf(distance)) return;
    const Vec3& direction = wave_.rays[i].direction;
    const Ray mirrored{context_.ground.point(wave_.rays[i], distance),
                       0,
                       {direction.x, -direction.y, direction.z}};
    if (!context_.ground.may_meet_scene(mirrored.origin, mirrored.direction)) return;
    Path next = wave_.paths[i];
    next.throughput *= context_.ground.reflectance(mirrored.direction.y);
    const Roulette& roulette = context_.roulette;
    const float survival = context_.needs.noise ? roulette.survival(next.throughput, faint_mirror)
                                                : roulette.survival(next.throughput);
    if (!survives(next, survival, 1)) return;
    next.stream = hash_combine(next.stream, 1);
    next.cone_width += next.cone_spread * distance;
    next.straight_length += distance;
    next.layers = 0;
    next.from_camera = false;
    next.sees_backdrop = false;
    next.mirrored = true;
    next.kind = RayKind::reflection;
    next.source = {};
    next_wave_.add(mirrored, next);
}

bool WaveTracer::samples_lights() const {
    return context_.needs.area_lights || (context_.needs.environment_light && context_.environment);
}

uint32_t WaveTracer::seed(const Path& path, Dimension dimension) const {
    return hash_combine(seed(path), static_cast<uint32_t>(dimension));
}

// One point of `dimension` for each of `count` paths.
template <class PathAt>
void WaveTracer::generate_samples(Dimension dimension, size_t count, const PathAt& path_at,
                                  Samples2D& samples) {
    sample_indices_.resize(count);
    sample_seeds_.resize(count);
    for (size_t i = 0; i < count; ++i) {
        const Path& path = path_at(i);
        sample_indices_[i] = sample_index(path);
        sample_seeds_[i] = seed(path);
    }
    samples.x.resize(count);
    samples.y.resize(count);
    sample_2d(sample_indices_, sample_seeds_, static_cast<uint32_t>(dimension), samples.x,
              samples.y);
}

void WaveTracer::generate_hit_samples() {
    const Needs& needs = context_.needs;
    const size_t count = wave_.hit_indices.size();
    const auto generate = [&](Dimension dimension, Samples2D& samples) {
        const auto path_at = [&](size_t k) -> const Path& {
            return wave_.paths[wave_.hit_indices[k]];
        };
        generate_samples(dimension, count, path_at, samples);
    };
    auto& [lobe, environment, emitter, which_emitter, environment_lights] = hit_samples_;
    if (needs.secondary_rays && needs.noise) generate(Dimension::reflection, lobe);
    if (needs.area_lights) {
        generate(Dimension::emitter, emitter);
        generate(Dimension::which_emitter, which_emitter);
    }
    if (!needs.environment_light || !context_.environment) return;
    generate(Dimension::environment, environment);
    environment_lights.resize(count);
    context_.environment->sample(environment.x, environment.y, environment_lights);
}

// Shades the hits and spawns their rays. What coincides with them is searched for a block at a
// time.
void WaveTracer::evaluate_materials() {
    const size_t count = wave_.hit_indices.size();
    for (size_t begin = 0; begin < count; begin += surface_block) {
        const size_t end = std::min(begin + surface_block, count);
        hit_surfaces_.clear();
        coincident_hits_.clear();
        for (size_t k = begin; k < end; ++k) {
            const uint32_t i = wave_.hit_indices[k];
            const Ray& ray = wave_.rays[i];
            const Hit& hit = wave_.hits[i];
            const Path& path = wave_.paths[i];
            const float width = path.cone_width + path.cone_spread * hit.t;
            auto& [surface, coincident] = hit_surfaces_.emplace_back();
            surface = context_.surfaces.at(ray, hit, width);
            if (may_coincide(surface)) coincident = coincident_hits_.add(ray, hit, surface);
        }
        coincident_hits_.search(Visible::all);
        for (size_t k = begin; k < end; ++k) evaluate_material(k, hit_surfaces_[k - begin]);
    }
}

// Shades the surfaces that coincide with the hit with index k and spawns their rays.
void WaveTracer::evaluate_material(size_t k, HitSurface& at_hit) {
    const uint32_t i = wave_.hit_indices[k];
    const Ray& ray = wave_.rays[i];
    const Hit& hit = wave_.hits[i];
    Path path = wave_.paths[i];
    path.cone_width += path.cone_spread * hit.t;
    path.straight_length += hit.t;
    if (context_.needs.volumes && path.media.count > 0) {
        const Vec3& absorption = context_.absorption[path.media.current()];
        if (!is_black(absorption)) {
            path.throughput *= attenuate(absorption, hit.t);
            ++buffer_.counters->absorbed_rays;
        }
    }
    onward_.clear();
    std::span<const Hit> coincident(&hit, 1);
    if (at_hit.coincident) coincident = coincident_hits_.at(*at_hit.coincident);
    if (coincident.size() == 1)
        visit_surface(path, ray, hit, at_hit.surface, k);
    else
        visit_coincident(path, ray, coincident, at_hit.surface.position, k);
    for (size_t j = 0; j < onward_.rays.size(); ++j)
        next_wave_.add(onward_.rays[j], onward_.paths[j]);
}

// True if other surfaces that coincide with this one matter: the ray goes on behind it, or one that
// it goes on behind may come first.
bool WaveTracer::may_coincide(const Surface& surface) const {
    return surface.alpha < 1 || surface.transmission > 0 ||
           (context_.needs.coloured_shadows && coincident_hits_.may_be_covered(surface));
}

// Takes a path through coincident surfaces, at `point`. What goes on behind one meets the
// next without a ray between.
void WaveTracer::visit_coincident(const Path& path, const Ray& ray, std::span<const Hit> coincident,
                                  const Vec3& point, size_t k) {
    onward_.add(ray, path);
    for (const Hit& hit : coincident) {
        std::swap(onward_, arriving_);
        onward_.clear();
        for (size_t j = 0; j < arriving_.rays.size(); ++j) {
            Ray arriving = arriving_.rays[j];
            arriving.origin = point - arriving.direction * hit.t;
            Surface surface = context_.surfaces.at(arriving, hit, arriving_.paths[j].cone_width);
            coincident_hits_.widen(surface);
            visit_surface(arriving_.paths[j], arriving, hit, surface, k);
        }
    }
}

void WaveTracer::visit_surface(Path path, const Ray& ray, const Hit& hit, Surface& surface,
                               size_t k) {
    const Needs& needs = context_.needs;
    handle_emissive_intersection(path, ray, hit, surface);
    if (is_last(path)) return spawn_last_continuation(path, ray, surface, hit.t);
    if (needs.pass_through && surface.alpha < 1) {
        ++buffer_.counters->uncovered_hits;
        if (path.layers < max_layers) spawn_alpha_continuation(path, ray, surface, hit.t);
        if (surface.alpha <= 0) return;
        path.throughput *= surface.alpha;
    }
    if (path.mirrored) ground_shadows_.cover(path.slot, path.throughput, buffer_);
    path.mirrored = false;
    if (path.from_camera) ++buffer_.counters->seen_surfaces;
    if (path.from_camera && needs.first_hits) record_first_hit(path, ray, hit, surface);
    if (path.from_camera && !context_.layers.names.object_ids.empty())
        buffer_.coverage.push_back({path.slot, hit.instance, surface.material, path.throughput.x});
    if (surface.has(feature_unlit)) return;
    if (!surface.has(feature_volume)) return scatter(path, surface, k);
    const Vec3 etas = context_.relative_iors(path.media, surface);
    if (path.channel == all_channels && etas != Vec3(etas.x))
        return scatter_by_channel(path, surface, etas, k);
    surface.eta = path.channel == all_channels ? etas.x : etas[path.channel];
    scatter(path, surface, k);
}

void WaveTracer::scatter(const Path& path, const Surface& surface, size_t k) {
    const Bsdf bsdf(surface);
    const GlossyEstimator glossy = context_.needs.secondary_rays
                                       ? spawn_secondary_rays(path, bsdf, k)
                                       : GlossyEstimator::lights_only;
    sample_direct_light(path, bsdf, k, glossy);
}

// Dispersion: each channel is refracted by its own index and stays alone from there on, which adds
// no noise. What is reflected has the same direction for all and stays one ray.
void WaveTracer::scatter_by_channel(const Path& path, Surface& surface, const Vec3& etas,
                                    size_t k) {
    const size_t first = next_wave_.rays.size();
    for (uint8_t channel = 0; channel < 3; ++channel) {
        Path alone = path;
        alone.channel = channel;
        alone.throughput = Vec3(0);
        alone.throughput[channel] = path.throughput[channel];
        surface.eta = etas[channel];
        const size_t begin = next_wave_.rays.size();
        scatter(alone, surface, k);
        join_reflections(first, begin);
    }
}

// Adds reflected rays from `begin` on to equal ones from `first` on.
void WaveTracer::join_reflections(size_t first, size_t begin) {
    if (begin == next_wave_.rays.size()) return;
    const Path& reflected = next_wave_.paths[begin];
    if (reflected.kind != RayKind::reflection) return;
    for (size_t i = first; i < begin; ++i) {
        Path& other = next_wave_.paths[i];
        if (other.kind != RayKind::reflection || other.pdf != reflected.pdf ||
            next_wave_.rays[i].direction != next_wave_.rays[begin].direction)
            continue;
        other.throughput += reflected.throughput;
        other.channel = all_channels;
        next_wave_.erase(begin);
        return;
    }
}

void WaveTracer::record_first_hit(const Path& path, const Ray& ray, const Hit& hit,
                                  const Surface& surface) {
    FirstHit& first = buffer_.samples[path.slot].first;
    if (first.valid) return;
    const Vec3 view = transform_point(surface.position, context_.camera.world_to_camera());
    first = {.valid = true,
             .depth = -view.z * context_.world_unit,
             .position = surface.position * context_.world_unit,
             .normal = surface.ns,
             .albedo = surface.base_color,
             // The layer holds the first sample's.
             .uv = sample_index(path) == 0 ? context_.surfaces.texcoord(ray, hit) : Vec2(0, 0),
             .object = hit.instance,
             .material = surface.material};
}

void WaveTracer::spawn_alpha_continuation(const Path& path, const Ray& ray, const Surface& surface,
                                          float distance) {
    Path behind = path;
    behind.throughput *= 1 - surface.alpha;
    if (!survives(behind, context_.roulette.survival(behind.throughput), 0)) return;
    ++behind.layers;
    behind.source = surface.id;
    // What comes from behind meets the front, which shadow rays do not pass: no light sample makes
    // this path.
    if (!surface.front && culls_back_faces(context_.scene.materials[surface.material]))
        behind.pdf = 0;
    onward_.add(spawn_ray(surface, ray.direction, ray.tfar - distance), behind);
}

// What a last ray sees of the lights behind a surface: as much as a shadow ray would.
void WaveTracer::spawn_last_continuation(const Path& path, const Ray& ray, Surface& surface,
                                         float distance) {
    if (path.layers >= max_layers) return;
    if (!surface.front && culls_back_faces(context_.scene.materials[surface.material])) return;
    Path behind = path;
    const LayerTransmittance layer = straight_transmittance(context_, path.media, surface);
    behind.throughput *= layer.unbent + layer.bent;
    if (!survives(behind, context_.roulette.survival(behind.throughput), 0)) return;
    ++behind.layers;
    behind.source = surface.id;
    if (surface.has(feature_volume)) behind.media = beyond(surface, path.media);
    onward_.add(spawn_ray(surface, ray.direction, ray.tfar - distance), behind);
}

// wB · throughput · alpha · Le. Where a light sample might have made the path, both must see the
// same texels: a filtered Le would be counted where it is dark and the light's density low.
void WaveTracer::handle_emissive_intersection(const Path& path, const Ray& ray, const Hit& hit,
                                              const Surface& surface) {
    if (path.from_camera && surface.has(feature_unlit) && context_.layers.names.shown)
        buffer_.add_shown(path.slot, path.throughput * surface.alpha, surface.emission);
    Vec3 emission = surface.emission * surface.alpha;
    std::optional<LightSample> sampled;
    if (path.pdf > 0 && context_.needs.area_lights) {
        Hit seen_from_vertex = hit;
        seen_from_vertex.t = path.straight_length;
        sampled = context_.area_lights.at(ray, seen_from_vertex);
    }
    if (sampled) emission = sampled->radiance * mis_weight(path.pdf, sampled->pdf);
    if (!sampled && is_last(path)) return;
    if (is_black(emission)) return;
    buffer_.add_radiance(path.slot, context_.layers.names.emission, path.throughput * emission);
}

GlossyEstimator WaveTracer::spawn_secondary_rays(const Path& path, const Bsdf& bsdf, size_t k) {
    const Surface& surface = bsdf.surface();
    // Straight transmission is no bounce: shadow rays pass there, too, at any depth.
    const bool exhausted = path.depth >= context_.needs.depth;
    const bool rough = is_rough(surface);
    // The last rays lower the noise of narrow lobes: where light sampling alone chooses directions,
    // the few that fall into one are far too bright.
    const bool followed = rough && (!exhausted || samples_lights());
    if (exhausted && !followed && !surface.has(feature_transmission))
        return GlossyEstimator::lights_only;
    Vec2 u_reflect(0, 0), u_refract(0, 0);
    float u_lobe = 0;
    if (rough && context_.needs.noise) {  // smooth lobes have one direction: nothing to choose
        u_reflect = hit_samples_.lobe[k];
        if (surface.features & (feature_transmission | feature_diffuse_transmission))
            u_refract = sample_2d(sample_index(path), seed(path, Dimension::refraction));
        if (surface.has(feature_clearcoat))
            u_lobe = sample_1d(sample_index(path), seed(path, Dimension::coat));
    }
    std::array<BsdfSample, 2> children;
    const int count = bsdf.sample(u_reflect, u_refract, u_lobe, children);
    for (int i = 0; i < count; ++i) {
        const BsdfSample& child = children[static_cast<size_t>(i)];
        if (child.unbent ? path.layers >= max_layers : exhausted && !(followed && child.pdf > 0))
            continue;
        Path next = path;
        next.throughput *= child.weight;
        const float survival = context_.roulette.survival(next.throughput);
        if (survives(next, survival, child.refracted ? 2 : 1))
            add_secondary_ray(next, surface, child);
        else
            ++buffer_.counters->cut_rays;
    }
    // A direction below the horizon, and a ray that roulette drops or that could not bring as much
    // as the cutoff, count as sampled all the same: the weight of the lights must not depend on the
    // direction drawn, nor be 1 where another lobe of the surface is followed.
    if (!followed) return GlossyEstimator::lights_only;
    return exhausted ? GlossyEstimator::lights_and_last_rays : GlossyEstimator::lights_and_rays;
}

// Russian roulette: false if the path ends; else its throughput grows by 1 / survival. `branch`
// distinguishes the paths that leave one surface, which draw numbers of their own.
bool WaveTracer::survives(Path& path, float survival, uint32_t branch) const {
    if (survival >= 1) return true;
    if (survival <= 0) return false;
    const uint32_t vertex = (path.depth * uint32_t{max_layers + 1} + path.layers) * 3 + branch;
    const uint32_t roulette = hash_combine(seed(path, Dimension::roulette), vertex);
    if (sample_1d(sample_index(path), roulette) >= survival) return false;
    path.throughput /= survival;
    return true;
}

// `next` has the throughput of the ray, otherwise all that the path had at the surface.
void WaveTracer::add_secondary_ray(Path next, const Surface& surface, const BsdfSample& sample) {
    next.stream = hash_combine(next.stream, sample.refracted ? 2 : 1);
    if (sample.unbent) {
        ++next.layers;
    } else {
        next.pdf = sample.pdf;
        next.straight_length = 0;
        next.layers = 0;
        ++next.depth;
    }
    if (sample.pdf > 0) next.cone_spread = std::max(next.cone_spread, 0.1f * surface.roughness);
    next.from_camera = false;
    // A rough lobe's light samples have seen the environment already.
    next.sees_backdrop = next.sees_backdrop && sample.refracted && next.pdf == 0;
    next.source = surface.id;
    next.kind = sample.refracted ? RayKind::refraction : RayKind::reflection;
    if (sample.enters_volume) next.media.enter(surface.material);
    if (sample.leaves_volume) next.media.leave(surface.material);
    Wave& to = sample.refracted ? onward_ : next_wave_;
    to.add(spawn_ray(surface, sample.direction, std::numeric_limits<float>::infinity()), next);
}

void WaveTracer::sample_direct_light(const Path& path, const Bsdf& bsdf, size_t k,
                                     GlossyEstimator glossy) {
    // Appel's picture is lit by punctual lights alone; the environment is its ambient term.
    if (context_.settings.integrator == Integrator::appel && context_.environment)
        buffer_.add_radiance(path.slot, context_.layers.names.environment,
                             path.throughput * bsdf.surface().base_color * context_.ambient);
    if (!scatters(bsdf.surface())) return;
    LightSamples samples{nullptr, Vec2(0, 0), Vec2(0, 0)};
    if (context_.needs.environment_light && context_.environment)
        samples.environment = &hit_samples_.environment_lights[k];
    if (context_.needs.area_lights) {
        samples.emitter = hit_samples_.emitter[k];
        samples.which_emitter = hit_samples_.which_emitter[k];
    }
    direct_light_.add({bsdf, glossy, path.throughput, path.slot, path.media}, samples, buffer_);
}

}  // namespace sightline
