#include "render/layers.h"

#include <fmt/format.h>

#include <bit>

namespace sightline {
namespace {

// One layer: its channels' names and how a pixel's values for them are found. The order of this
// table is the order of the channels in the film.
struct Layer {
    const char* aov;  // nullptr: always there
    std::vector<const char*> channels;
    Channel::Type type;
    bool is_color;  // or a direction: half floats may do
    void (*values)(const Pixel& pixel, float* out);
    void (*integers)(const Pixel& pixel, uint32_t* out);
};

void put(float* out, const Vec3& v) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

float inverse_count(const Pixel& p) { return p.samples ? 1 / static_cast<float>(p.samples) : 0; }

Layer real(const char* aov, std::vector<const char*> channels, void (*values)(const Pixel&, float*),
           bool is_color = false) {
    return {aov, std::move(channels), Channel::Type::float32, is_color, values, nullptr};
}

Layer whole(const char* aov, const char* channel, void (*integers)(const Pixel&, uint32_t*)) {
    return {aov, {channel}, Channel::Type::uint32, false, nullptr, integers};
}

void beauty(const Pixel& p, float* out) {
    put(out, p.radiance * inverse_count(p));
    out[3] = p.alpha * inverse_count(p);
}
void depth(const Pixel& p, float* out) {
    *out = p.first.valid ? p.first.depth : std::numeric_limits<float>::infinity();
}
void position(const Pixel& p, float* out) { put(out, p.first.position); }
void normal(const Pixel& p, float* out) { put(out, p.normal * inverse_count(p)); }
void albedo(const Pixel& p, float* out) { put(out, p.albedo * inverse_count(p)); }
void uv(const Pixel& p, float* out) { out[0] = p.first.uv.x, out[1] = p.first.uv.y; }
void object(const Pixel& p, uint32_t* out) { *out = p.first.object + 1; }
void material(const Pixel& p, uint32_t* out) { *out = p.first.material + 1; }
void samples(const Pixel& p, uint32_t* out) { *out = p.samples; }
void cost(const Pixel& p, uint32_t* out) { *out = static_cast<uint32_t>(p.rays); }

const std::vector<Layer>& layers() {
    static const std::vector<Layer> table = {
        real(nullptr, {"R", "G", "B", "A"}, beauty, true),
        real("depth", {"depth.Z"}, depth),
        real("position", {"position.X", "position.Y", "position.Z"}, position),
        real("normal", {"normal.X", "normal.Y", "normal.Z"}, normal, true),
        real("albedo", {"albedo.R", "albedo.G", "albedo.B"}, albedo, true),
        real("uv", {"uv.U", "uv.V"}, uv),
        whole("object", "object.id", object),
        whole("material", "material.id", material),
        whole("samples", "samples.count", samples),
        whole("cost", "cost.rays", cost),
    };
    return table;
}

}  // namespace

Film layout_of(const RenderSettings& settings, const LayerNames& names) {
    Film film{.display = {0, 0, settings.width, settings.height},
              .window = window_of(settings),
              .channels = {}};
    const auto add = [&](std::string name, Channel::Type type) {
        film.channels.push_back(
            {.name = std::move(name), .type = type, .values = {}, .integers = {}});
    };
    const Channel::Type color = settings.half ? Channel::Type::half : Channel::Type::float32;
    for (const Layer& layer : layers()) {
        if (layer.aov && !settings.aovs.contains(layer.aov)) continue;
        for (const char* name : layer.channels) add(name, layer.is_color ? color : layer.type);
    }
    if (!names.object_ids.empty())
        for (const char* kind : {"Object", "Material"})
            for (size_t i = 0; i < 2 * cryptomatte_ranks; ++i)
                add(fmt::format("Crypto{}{:02}.{}", kind, i / 4, "RGBA"[i % 4]),
                    Channel::Type::float32);
    for (const std::string& group : names.light_groups)
        for (const char c : {'R', 'G', 'B'}) add(fmt::format("light.{}.{}", group, c), color);
    return film;
}

void develop(Film& film, const LayerNames& names, int x, int y, const Pixel& pixel) {
    const size_t at =
        static_cast<size_t>(y - film.window.y0) * static_cast<size_t>(film.window.width()) +
        static_cast<size_t>(x - film.window.x0);
    auto channel = film.channels.begin();
    for (const Layer& layer : layers()) {
        if (channel == film.channels.end()) return;
        if (channel->name != layer.channels[0]) continue;  // the film does without this layer
        float values[4];
        uint32_t integers[4];
        layer.values ? layer.values(pixel, values) : layer.integers(pixel, integers);
        for (size_t i = 0; i < layer.channels.size(); ++i, ++channel) {
            if (layer.values) {
                channel->values[at] = values[i];
            } else {
                channel->integers[at] = integers[i];
            }
        }
    }
    const float share = inverse_count(pixel);
    if (!names.object_ids.empty()) {
        for (const std::vector<Coverage>* coverage : {&pixel.objects, &pixel.materials}) {
            const std::vector<Coverage> ranks = rank(*coverage);
            for (size_t i = 0; i < cryptomatte_ranks; ++i) {
                const Coverage r = i < ranks.size() ? ranks[i] : Coverage{0, 0.0f};
                (channel++)->values[at] = std::bit_cast<float>(r.first);
                (channel++)->values[at] = r.second * share;
            }
        }
    }
    for (size_t group = 0; group < names.light_groups.size(); ++group) {
        const Vec3 light = pixel.lights.empty() ? Vec3(0, 0, 0) : pixel.lights[group] * share;
        for (const float value : {light.x, light.y, light.z}) (channel++)->values[at] = value;
    }
}

}  // namespace sightline
