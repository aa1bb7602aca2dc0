#include "intersect/engines.h"

#include "core/error.h"
#include "core/suggest.h"
#include "intersect/exact/exact_intersector.h"
#include "intersect/few_shapes.h"
#include "intersect/methods/triangle_methods.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

bool any_scene(const Scene&) { return true; }

EngineEntry embree_entry(const char* name, const char* description, bool robust, bool packets,
                         std::optional<BuildQuality> quality = {}) {
    const auto make = [=](const Scene& scene, Structure, EmbreeOptions options) {
        options.robust = robust;
        options.packets = packets;
        options.quality = quality.value_or(options.quality);
        return make_embree(scene, options);
    };
    return {name, description, false, any_scene, make};
}

EngineEntry triangle_method_entry(const TriangleMethod& method) {
    const auto make = [&method](const Scene& scene, Structure structure, const EmbreeOptions&) {
        return make_method_intersector(scene, method, structure);
    };
    return {method.name, method.description, true, any_scene, make};
}

std::vector<EngineEntry> make_registry() {
    std::vector<EngineEntry> entries = {
        embree_entry("embree", "Embree in ROBUST mode, 16 rays per call", true, true),
        embree_entry("embree-single", "Embree in ROBUST mode, one ray per call", true, false),
        embree_entry("embree-default", "Embree in its default mode, 16 rays per call", false, true),
        embree_entry("embree-default-single", "Embree in its default mode, one ray per call", false,
                     false),
        embree_entry("embree-high",
                     "Embree in its default mode, built with spatial splits, 16 rays per call",
                     false, true, BuildQuality::high),
        {"few-shapes", "brute force over at most eight spheres, planes and triangles", false,
         has_few_shapes,
         [](const Scene& scene, Structure, const EmbreeOptions&) {
             return make_few_shapes(scene);
         }},
        {"exact", "a BVH whose triangle tests decide as exact arithmetic does", false, any_scene,
         [](const Scene& scene, Structure, const EmbreeOptions&) {
             return make_exact_intersector(scene);
         }}};
    for (const TriangleMethod& method : triangle_methods())
        entries.push_back(triangle_method_entry(method));
    return entries;
}

/// An engine name in its parts.
struct ParsedName {
    const EngineEntry* entry = nullptr;  ///< nullptr: unknown
    Structure structure = Structure::bvh;
    std::optional<Coherence> coherence;
};

bool remove_suffix(std::string_view& text, std::string_view suffix) {
    if (!text.ends_with(suffix)) return false;
    text.remove_suffix(suffix.size());
    return true;
}

ParsedName parse_name(std::string_view name) {
    ParsedName parsed;
    if (remove_suffix(name, "@coherent"))
        parsed.coherence = Coherence::coherent;
    else if (remove_suffix(name, "@incoherent"))
        parsed.coherence = Coherence::incoherent;
    if (remove_suffix(name, ":bounds"))
        parsed.structure = Structure::mesh_bounds;
    else if (remove_suffix(name, ":loop"))
        parsed.structure = Structure::loop;
    const auto registry = engine_registry();
    const auto found = std::ranges::find(registry, name, &EngineEntry::name);
    if (found != registry.end() && (found->has_structures || parsed.structure == Structure::bvh))
        parsed.entry = &*found;
    return parsed;
}

ParsedName parse_known_name(std::string_view name) {
    ParsedName parsed = parse_name(name);
    if (parsed.entry) return parsed;
    const std::vector<std::string> names = engine_names();
    const std::string hint = did_you_mean(name, names);
    throw Error(fmt::format(
        "unknown engine '{}'{}", name,
        hint.empty() ? fmt::format("; there are {}; a triangle method may be followed by :bounds "
                                   "or :loop, any by @coherent or @incoherent",
                                   fmt::join(names, ", "))
                     : hint));
}

/// Calls an engine with one fixed coherence and ignores the one that the caller passes.
class PinnedCoherence : public Intersector {
  public:
    PinnedCoherence(std::unique_ptr<Intersector> engine, Coherence coherence)
        : engine_(std::move(engine)), coherence_(coherence) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible visible) const override {
        engine_->closest(rays, hits, coherence_, visible);
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                  Visible visible) const override {
        engine_->occluded(rays, blocked, coherence_, visible);
    }
    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible visible) const override {
        engine_->all(rays, hits, visible);
    }
    std::string description() const override { return engine_->description(); }
    size_t memory() const override { return engine_->memory(); }
    std::vector<std::string> warnings() const override { return engine_->warnings(); }
    bool leaves_out(const Ray& ray, const SurfaceId& surface) const override {
        return engine_->leaves_out(ray, surface);
    }

  private:
    std::unique_ptr<Intersector> engine_;
    Coherence coherence_;
};

}  // namespace

std::span<const EngineEntry> engine_registry() {
    static const std::vector<EngineEntry> entries = make_registry();
    return entries;
}

std::vector<std::string> engine_names() {
    std::vector<std::string> names;
    for (const EngineEntry& entry : engine_registry()) names.push_back(entry.name);
    return names;
}

void check_engine_name(std::string_view name) { parse_known_name(name); }

std::optional<Coherence> pinned_coherence(std::string_view name) {
    return parse_name(name).coherence;
}

std::unique_ptr<Intersector> make_engine(const Scene& scene, std::string_view name,
                                         const EmbreeOptions& embree) {
    const ParsedName parsed = parse_known_name(name);
    if (!parsed.entry->supports(scene))
        throw Error(fmt::format("{}: {} does not support this scene: it is {}", scene.path,
                                parsed.entry->name, parsed.entry->description));
    auto engine = parsed.entry->make(scene, parsed.structure, embree);
    if (!parsed.coherence) return engine;
    return std::make_unique<PinnedCoherence>(std::move(engine), *parsed.coherence);
}

std::vector<Engine> make_engines(const Scene& scene, std::span<const std::string> names,
                                 const EmbreeOptions& embree) {
    for (const std::string& name : names) check_engine_name(name);
    std::vector<Engine> engines;
    for (const std::string& name : names)
        if (std::ranges::none_of(engines, [&](const Engine& e) { return e.name == name; }))
            engines.push_back({name, make_engine(scene, name, embree)});
    return engines;
}

}  // namespace sightline
