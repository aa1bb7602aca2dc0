#include "lab/compare/screen_maps.h"

#include "core/hash.h"
#include "core/parallel.h"
#include "lab/compare/judging.h"

#include <algorithm>

namespace sightline {
namespace {

/// Where the ray's pixel lies in the window, row by row.
std::optional<size_t> place_of(const RecordedRay& ray, const PixelRect& window) {
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
struct Primaries {
    std::vector<Ray> rays;
    std::vector<size_t> places;
};

Primaries find_primaries(std::span<const RecordedRay> rays, const PixelRect& window) {
    Primaries found;
    std::vector<bool> seen(static_cast<size_t>(window.width()) *
                           static_cast<size_t>(window.height()));
    for (const RecordedRay& ray : rays) {
        if (ray.kind != RayKind::camera) continue;
        const auto place = place_of(ray, window);
        if (!place || seen[*place]) continue;
        seen[*place] = true;
        found.rays.push_back(ray.ray);
        found.places.push_back(*place);
    }
    return found;
}

std::vector<SurfaceId> surfaces_met(const Engine& engine, std::span<const Ray> rays) {
    std::vector<Hit> hits(rays.size());
    engine.closest(rays, hits, Coherence::coherent);
    std::vector<SurfaceId> surfaces;
    for (const Hit& hit : hits) surfaces.push_back(surface_of(hit));
    return surfaces;
}

std::vector<SurfaceId> true_surfaces(const Referee& referee, std::span<const Ray> rays) {
    constexpr size_t run = 1024;
    std::vector<SurfaceId> surfaces(rays.size());
    parallel_for((rays.size() + run - 1) / run, [&](size_t k) {
        for (size_t i = k * run; i < std::min(rays.size(), (k + 1) * run); ++i) {
            const Truth truth = truth_of(referee, rays[i]);
            if (!truth.nearest.empty()) surfaces[i] = truth.nearest[0];
        }
    });
    return surfaces;
}

/// A light colour, the same for the same surface; the triangles of a mesh have similar ones.
Vec3 color_of(const SurfaceId& id) {
    const uint32_t object[] = {id.instance, id.geometry};
    const uint64_t coarse = hash_bytes(std::as_bytes(std::span(object)));
    const uint64_t fine = hash_bytes(std::as_bytes(std::span(&id.primitive, 1)), coarse);
    const auto part = [&](int shift) {
        return 80 + static_cast<float>(coarse >> shift & 0xff) * (120 / 255.0f) +
               static_cast<float>(fine >> shift & 0xff) * (55 / 255.0f);
    };
    return {part(0), part(8), part(16)};
}

Image paint(const std::vector<SurfaceId>& surfaces, const std::vector<size_t>& places,
            const PixelRect& window, const Image& picture) {
    Image image = blank(window, 3);
    for (size_t i = 0; i < places.size(); ++i) {
        const uint8_t* below = &picture.bytes[places[i] * 3];
        const float grey = luminance(Vec3(below[0], below[1], below[2])) / 255;
        const bool hit = surfaces[i].geometry != none;
        const Vec3 color = hit ? color_of(surfaces[i]) * (0.4f + 0.6f * grey) : Vec3(24, 26, 30);
        for (int c = 0; c < 3; ++c)
            image.bytes[places[i] * 3 + static_cast<size_t>(c)] = static_cast<uint8_t>(color[c]);
    }
    return image;
}

bool is_wrong(Verdict verdict) {
    return verdict == Verdict::missed || verdict == Verdict::false_hit ||
           verdict == Verdict::wrong_primitive;
}

}  // namespace

std::vector<ScreenMap> surface_maps(const Referee& referee, std::span<const RecordedRay> rays,
                                    std::span<const Engine* const> engines, const PixelRect& window,
                                    const Image& picture) {
    const Primaries primaries = find_primaries(rays, window);
    std::vector<ScreenMap> maps;
    if (primaries.rays.empty()) return maps;
    const auto add = [&](const std::string& name, const std::vector<SurfaceId>& surfaces) {
        maps.push_back({name, paint(surfaces, primaries.places, window, picture)});
    };
    for (const Engine* engine : engines) add(engine->name, surfaces_met(*engine, primaries.rays));
    add("referee", true_surfaces(referee, primaries.rays));
    return maps;
}

std::vector<ScreenMap> finding_maps(const Comparison& comparison, std::span<const RecordedRay> rays,
                                    const PixelRect& window) {
    std::vector<ScreenMap> maps;
    for (const EngineScore& engine : comparison.engines)
        maps.push_back({engine.name, blank(window, 4)});
    for (const RayFinding& finding : comparison.findings) {
        const auto place = place_of(rays[finding.ray], window);
        if (!place) continue;
        uint8_t* pixel = &maps[finding.engine].image.bytes[*place * 4];
        const bool red = is_wrong(finding.verdict) || (pixel[3] != 0 && pixel[1] < 128);
        pixel[0] = red ? 230 : 250;
        pixel[1] = red ? 20 : 200;
        pixel[2] = red ? 30 : 0;
        pixel[3] = 255;
    }
    return maps;
}

}  // namespace sightline
