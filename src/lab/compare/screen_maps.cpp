#include "lab/compare/screen_maps.h"

#include "core/hash.h"
#include "core/parallel.h"
#include "lab/compare/judging.h"

#include <algorithm>

namespace sightline {
namespace {

/// Row-major index of the ray's pixel in the window.
std::optional<size_t> pixel_index(const RecordedRay& ray, const PixelRect& window) {
    if (!window.contains(ray.x, ray.y)) return std::nullopt;
    return static_cast<size_t>(ray.y - window.y0) * static_cast<size_t>(window.width()) +
           static_cast<size_t>(ray.x - window.x0);
}

Image blank(const PixelRect& window, int channels) {
    Image image;
    image.width = window.width();
    image.height = window.height();
    image.channels = channels;
    image.bytes.resize(static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                       static_cast<size_t>(channels));
    return image;
}

/// Each pixel's first camera ray.
struct PrimaryRays {
    std::vector<Ray> rays;
    std::vector<size_t> pixels;
};

PrimaryRays find_primary_rays(std::span<const RecordedRay> rays, const PixelRect& window) {
    PrimaryRays primary;
    std::vector<bool> seen(static_cast<size_t>(window.width()) *
                           static_cast<size_t>(window.height()));
    for (const RecordedRay& ray : rays) {
        if (ray.kind != RayKind::camera) continue;
        const auto pixel = pixel_index(ray, window);
        if (!pixel || seen[*pixel]) continue;
        seen[*pixel] = true;
        primary.rays.push_back(ray.ray);
        primary.pixels.push_back(*pixel);
    }
    return primary;
}

std::vector<SurfaceId> hit_surfaces(const Engine& engine, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    engine.intersector->closest(rays, hits, Coherence::coherent);
    std::vector<SurfaceId> surfaces;
    for (const Hit& hit : hits) surfaces.push_back(surface_of(hit));
    return surfaces;
}

std::vector<SurfaceId> true_surfaces(const Referee& referee, std::span<const Ray> rays) {
    constexpr size_t rays_at_once = 1024;
    std::vector<SurfaceId> surfaces(rays.size());
    const auto judge = [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const Truth truth = find_truth(referee, rays[i]);
            if (!truth.nearest.empty()) surfaces[i] = truth.nearest[0];
        }
    };
    parallel_ranges(rays.size(), judge, rays_at_once);
    return surfaces;
}

/// A light colour, a hash of the surface; similar for the triangles of a mesh.
Vec3 surface_color(const SurfaceId& id) {
    const uint32_t object[] = {id.instance, id.geometry};
    const uint64_t coarse = hash_bytes(std::as_bytes(std::span(object)));
    const uint64_t fine = hash_bytes(std::as_bytes(std::span(&id.primitive, 1)), coarse);
    const auto channel = [&](int shift) {
        return 80 + static_cast<float>(coarse >> shift & 0xff) * (120 / 255.0f) +
               static_cast<float>(fine >> shift & 0xff) * (55 / 255.0f);
    };
    return {channel(0), channel(8), channel(16)};
}

Image paint(const std::vector<SurfaceId>& surfaces, const std::vector<size_t>& pixels,
            const PixelRect& window, const Image& picture) {
    Image image = blank(window, 3);
    for (size_t i = 0; i < pixels.size(); ++i) {
        const uint8_t* source = &picture.bytes[pixels[i] * 3];
        const float grey = luminance(Vec3(source[0], source[1], source[2])) / 255;
        const bool hit = surfaces[i].geometry != none;
        const Vec3 color =
            hit ? surface_color(surfaces[i]) * (0.4f + 0.6f * grey) : Vec3(24, 26, 30);
        for (int c = 0; c < 3; ++c)
            image.bytes[pixels[i] * 3 + static_cast<size_t>(c)] = static_cast<uint8_t>(color[c]);
    }
    return image;
}

}  // namespace

std::vector<ScreenMap> surface_maps(const Referee& referee, std::span<const RecordedRay> rays,
                                    std::span<const Engine* const> engines, const PixelRect& window,
                                    const Image& picture) {
    const PrimaryRays primary = find_primary_rays(rays, window);
    std::vector<ScreenMap> maps;
    if (primary.rays.empty()) return maps;
    const auto add = [&](const std::string& name, const std::vector<SurfaceId>& surfaces) {
        maps.push_back({name, paint(surfaces, primary.pixels, window, picture)});
    };
    for (const Engine* engine : engines) add(engine->name, hit_surfaces(*engine, primary.rays));
    add("referee", true_surfaces(referee, primary.rays));
    return maps;
}

std::vector<ScreenMap> finding_maps(const Comparison& comparison, std::span<const RecordedRay> rays,
                                    const PixelRect& window) {
    std::vector<ScreenMap> maps;
    for (const EngineScore& engine : comparison.engines)
        maps.push_back({engine.name, blank(window, 4)});
    for (const RayFinding& finding : comparison.findings) {
        const auto pixel = pixel_index(rays[finding.ray], window);
        if (!pixel) continue;
        uint8_t* rgba = &maps[finding.engine].image.bytes[*pixel * 4];
        const bool red = is_wrong(finding.verdict) || (rgba[3] != 0 && rgba[1] < 128);
        rgba[0] = red ? 230 : 250;
        rgba[1] = red ? 20 : 200;
        rgba[2] = red ? 30 : 0;
        rgba[3] = 255;
    }
    return maps;
}

}  // namespace sightline
