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

const std::vector<Layer>& layers() {
    using Type = Channel::Type;
    static const std::vector<Layer> table = {
        {nullptr,
         {"R", "G", "B", "A"},
         Type::float32,
         [](const Pixel& p, float* out) {
             put(out, p.radiance * inverse_count(p));
             out[3] = p.alpha * inverse_count(p);
         },
         nullptr},
        {"depth",
         {"depth.Z"},
         Type::float32,
         [](const Pixel& p, float* out) {
             out[0] = p.first.valid ? p.first.depth : std::numeric_limits<float>::infinity();
         },
         nullptr},
        {"position",
         {"position.X", "position.Y", "position.Z"},
         Type::float32,
         [](const Pixel& p, float* out) { put(out, p.first.position); },
         nullptr},
        {"normal",
         {"normal.X", "normal.Y", "normal.Z"},
         Type::float32,
         [](const Pixel& p, float* out) { put(out, p.normal * inverse_count(p)); },
         nullptr},
        {"albedo",
         {"albedo.R", "albedo.G", "albedo.B"},
         Type::float32,
         [](const Pixel& p, float* out) { put(out, p.albedo * inverse_count(p)); },
         nullptr},
        {"uv",
         {"uv.U", "uv.V"},
         Type::float32,
         [](const Pixel& p, float* out) { out[0] = p.first.uv.x, out[1] = p.first.uv.y; },
         nullptr},
        {"object",
         {"object.id"},
         Type::uint32,
         nullptr,
         [](const Pixel& p, uint32_t* out) { out[0] = p.first.object + 1; }},
        {"material",
         {"material.id"},
         Type::uint32,
         nullptr,
         [](const Pixel& p, uint32_t* out) { out[0] = p.first.material + 1; }},
        {"samples",
         {"samples.count"},
         Type::uint32,
         nullptr,
         [](const Pixel& p, uint32_t* out) { out[0] = p.samples; }},
        {"cost",
         {"cost.rays"},
         Type::uint32,
         nullptr,
         [](const Pixel& p, uint32_t* out) { out[0] = static_cast<uint32_t>(p.rays); }},
    };
    return table;
}

bool is_wanted(const Layer& layer, const RenderJob& job) {
    return !layer.aov || job.aovs.contains(layer.aov);
}

}  // namespace

Film make_film(const RenderJob& job) {
    Film film{.display = {0, 0, job.width, job.height}, .window = window_of(job), .channels = {}};
    const auto pixels =
        static_cast<size_t>(film.window.width()) * static_cast<size_t>(film.window.height());
    for (const Layer& layer : layers()) {
        if (!is_wanted(layer, job)) continue;
        for (const char* name : layer.channels) {
            Channel channel{.name = name, .type = layer.type, .values = {}, .integers = {}};
            if (layer.values) channel.values.resize(pixels);
            if (layer.integers) channel.integers.resize(pixels);
            film.channels.push_back(std::move(channel));
        }
    }
    return film;
}

void develop(Film& film, const RenderJob& job, int x, int y, const Pixel& pixel) {
    const size_t at =
        static_cast<size_t>(y - film.window.y0) * static_cast<size_t>(film.window.width()) +
        static_cast<size_t>(x - film.window.x0);
    auto channel = film.channels.begin();
    for (const Layer& layer : layers()) {
        if (!is_wanted(layer, job)) continue;
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
