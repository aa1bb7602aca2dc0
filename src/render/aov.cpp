#include "render/aov.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace sightline {
namespace {

/// A dot would divide the name into layers.
std::string channel_name(const std::string& name) {
    std::string result = name.empty() ? "unnamed" : name;
    std::ranges::replace(result, '.', '_');
    return result;
}

std::vector<uint32_t> cryptomatte_ids(const std::vector<std::string>& names) {
    std::vector<uint32_t> ids;
    for (const std::string& name : names) ids.push_back(cryptomatte_id(name));
    return ids;
}

LayerNames make_layer_names(const Scene& scene, const RenderSettings& settings) {
    LayerNames names;
    names.shown = settings.aovs.contains(shown_layer);
    if (settings.aovs.contains("cryptomatte")) {
        names.object_ids = cryptomatte_ids(object_names(scene));
        names.material_ids = cryptomatte_ids(material_names(scene));
    }
    if (!settings.aovs.contains("lights")) return names;
    std::vector<std::string>& groups = names.light_groups;
    const auto group_of = [&](const std::string& name) {
        const auto found = std::ranges::find(groups, name);
        const auto index = found - groups.begin();
        if (found == groups.end()) groups.push_back(name);
        return static_cast<uint16_t>(index);
    };
    for (const Light& light : scene.lights)
        names.group_of_light.push_back(group_of(channel_name(light.name)));
    names.environment = group_of("environment");
    names.emission = group_of("emission");
    return names;
}

float inverse_count(const Pixel& p) { return p.samples ? 1 / static_cast<float>(p.samples) : 0; }

void beauty(const Pixel& p, const LayerWriter& out) {
    out.set(0, p.radiance * inverse_count(p));
    out.set(3, p.alpha * inverse_count(p));
}
void depth(const Pixel& p, const LayerWriter& out) {
    out.set(0, p.first.valid ? p.first.depth : std::numeric_limits<float>::infinity());
}
void position(const Pixel& p, const LayerWriter& out) { out.set(0, p.first.position); }
void normal(const Pixel& p, const LayerWriter& out) { out.set(0, p.normal * inverse_count(p)); }
void albedo(const Pixel& p, const LayerWriter& out) { out.set(0, p.albedo * inverse_count(p)); }
void uv(const Pixel& p, const LayerWriter& out) {
    out.set(0, p.first.uv.x);
    out.set(1, p.first.uv.y);
}
void object(const Pixel& p, const LayerWriter& out) { out.set(0, p.first.object + 1); }
void material(const Pixel& p, const LayerWriter& out) { out.set(0, p.first.material + 1); }
void samples(const Pixel& p, const LayerWriter& out) { out.set(0, p.samples); }
void cost(const Pixel& p, const LayerWriter& out) { out.set(0, static_cast<uint32_t>(p.rays)); }

// Ranks of objects, then of materials: an id as the bits of a float, and its coverage.
void cryptomatte(const Pixel& p, const LayerWriter& out) {
    size_t channel = 0;
    for (const std::vector<Coverage>* coverage : {&p.objects, &p.materials}) {
        const std::vector<Coverage> ranks = rank(*coverage);
        for (size_t i = 0; i < cryptomatte_ranks; ++i) {
            const Coverage r = i < ranks.size() ? ranks[i] : Coverage{0, 0.0f};
            out.set(channel++, std::bit_cast<float>(r.first));
            out.set(channel++, r.second * inverse_count(p));
        }
    }
}

void lights(const Pixel& p, const LayerWriter& out) {
    for (size_t group = 0; group < p.lights.size(); ++group)
        out.set(3 * group, p.lights[group] * inverse_count(p));
}

void shown(const Pixel& p, const LayerWriter& out) {
    out.set(0, p.shown * inverse_count(p));
    out.set(3, p.shown_share * inverse_count(p));
}

void through(const Pixel& p, const LayerWriter& out) {
    out.set(0, p.through * inverse_count(p));
    out.set(3, p.through_share * inverse_count(p));
}

std::vector<std::string> cryptomatte_channels() {
    std::vector<std::string> channels;
    for (const char* kind : {"Object", "Material"})
        for (size_t i = 0; i < 2 * cryptomatte_ranks; ++i)
            channels.push_back(fmt::format("Crypto{}{:02}.{}", kind, i / 4, "RGBA"[i % 4]));
    return channels;
}

std::vector<std::string> light_channels(const LayerNames& names) {
    std::vector<std::string> channels;
    for (const std::string& group : names.light_groups)
        for (const char c : {'R', 'G', 'B'})
            channels.push_back(fmt::format("light.{}.{}", group, c));
    return channels;
}

}  // namespace

Layers::Layers(const Scene& scene, const RenderSettings& settings)
    : names(make_layer_names(scene, settings)),
      layout{.display = {0, 0, settings.width, settings.height},
             .window = window_of(settings),
             .channels = {}} {
    using enum Channel::Type;
    const Channel::Type color = settings.half ? half : float32;  // colours and directions
    const auto add_if = [&](const char* aov, Resolve resolve,
                            const std::vector<std::string>& channels, Channel::Type type) {
        if (settings.aovs.contains(aov)) add(resolve, channels, type);
    };
    add(beauty, {"R", "G", "B", "A"}, color);
    add_if("depth", depth, {"depth.Z"}, float32);
    add_if("position", position, {"position.X", "position.Y", "position.Z"}, float32);
    add_if("normal", normal, {"normal.X", "normal.Y", "normal.Z"}, color);
    add_if("albedo", albedo, {"albedo.R", "albedo.G", "albedo.B"}, color);
    add_if("uv", uv, {"uv.U", "uv.V"}, float32);
    add_if("object", object, {"object.id"}, uint32);
    add_if("material", material, {"material.id"}, uint32);
    add_if("samples", samples, {"samples.count"}, uint32);
    add_if("cost", cost, {"cost.rays"}, uint32);
    if (!names.object_ids.empty()) add(cryptomatte, cryptomatte_channels(), float32);
    add_if("lights", lights, light_channels(names), color);
    add_if(shown_layer, shown, {"shown.R", "shown.G", "shown.B", "shown.share"}, float32);
    add_if(through_layer, through, {"through.R", "through.G", "through.B", "through.share"},
           float32);
}

void Layers::add(Resolve resolve, const std::vector<std::string>& channels, Channel::Type type) {
    layers_.push_back({layout.channels.size(), resolve});
    for (const std::string& name : channels)
        layout.channels.push_back({.name = name, .type = type, .values = {}, .integers = {}});
}

void Layers::resolve_pixel(Film& film, int x, int y, const Pixel& pixel) const {
    const size_t at =
        static_cast<size_t>(y - film.window.y0) * static_cast<size_t>(film.window.width()) +
        static_cast<size_t>(x - film.window.x0);
    for (const Layer& layer : layers_) layer.resolve(pixel, {film, layer.first_channel, at});
}

}  // namespace sightline
