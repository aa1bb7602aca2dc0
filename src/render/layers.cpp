#include "render/layers.h"

namespace sightline {
namespace {

// One layer: its channels' names and how a pixel's values for them are found. The order of this
// table is the order of the channels in the film.
struct Layer {
    const char* aov;  // nullptr: always there
    std::vector<const char*> channels;
    Channel::Type type;
    void (*values)(const Pixel& pixel, float* out);
    void (*integers)(const Pixel& pixel, uint32_t* out);
};

void put(float* out, const Vec3& v) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

float inverse_count(const Pixel& p) { return p.samples ? 1 / static_cast<float>(p.samples) : 0; }

Layer real(const char* aov, std::vector<const char*> channels,
           void (*values)(const Pixel&, float*)) {
    return {aov, std::move(channels), Channel::Type::float32, values, nullptr};
}

Layer whole(const char* aov, const char* channel, void (*integers)(const Pixel&, uint32_t*)) {
    return {aov, {channel}, Channel::Type::uint32, nullptr, integers};
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
        real(nullptr, {"R", "G", "B", "A"}, beauty),
        real("depth", {"depth.Z"}, depth),
        real("position", {"position.X", "position.Y", "position.Z"}, position),
        real("normal", {"normal.X", "normal.Y", "normal.Z"}, normal),
        real("albedo", {"albedo.R", "albedo.G", "albedo.B"}, albedo),
        real("uv", {"uv.U", "uv.V"}, uv),
        whole("object", "object.id", object),
        whole("material", "material.id", material),
        whole("samples", "samples.count", samples),
        whole("cost", "cost.rays", cost),
    };
    return table;
}

}  // namespace

Film make_film(const RenderJob& job, const PixelRect& window) {
    Film film{.display = {0, 0, job.width, job.height}, .window = window, .channels = {}};
    const auto pixels = static_cast<size_t>(window.width()) * static_cast<size_t>(window.height());
    for (const Layer& layer : layers()) {
        if (layer.aov && !job.aovs.contains(layer.aov)) continue;
        for (const char* name : layer.channels) {
            Channel channel{.name = name, .type = layer.type, .values = {}, .integers = {}};
            if (layer.values) channel.values.resize(pixels);
            if (layer.integers) channel.integers.resize(pixels);
            film.channels.push_back(std::move(channel));
        }
    }
    return film;
}

void develop(Film& film, int x, int y, const Pixel& pixel) {
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
}

}  // namespace sightline
