#include "intersect/engines.h"

#include "core/error.h"
#include "intersect/exact/exact_intersector.h"
#include "intersect/few_shapes.h"
#include "intersect/methods/triangle_methods.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

constexpr std::string_view coherent = "@coherent", incoherent = "@incoherent";

/// The name without what pins the calls.
std::string_view method_of(std::string_view name) {
    for (const std::string_view suffix : {incoherent, coherent})
        if (name.ends_with(suffix)) return name.substr(0, name.size() - suffix.size());
    return name;
}

std::optional<Coherence> pinned(std::string_view name) {
    if (name.ends_with(incoherent)) return Coherence::incoherent;
    if (name.ends_with(coherent)) return Coherence::coherent;
    return std::nullopt;
}

std::unique_ptr<Intersector> make_method(const Scene& scene, std::string_view method,
                                         const EmbreeOptions& options) {
    if (method == "few-shapes") {
        if (auto few = make_few_shapes(scene)) return few;
        throw Error(scene.path + ": few-shapes takes at most eight spheres, planes and triangles");
    }
    if (!method.starts_with("embree")) return make_reference(scene, method);
    EmbreeOptions embree = options;
    embree.robust = !method.starts_with("embree-default");
    embree.packets = !method.ends_with("-single");
    return make_embree(scene, embree);
}

}  // namespace

std::vector<std::string> engine_names() {
    std::vector<std::string> names = {"embree",         "embree-single",
                                      "embree-default", "embree-default-single",
                                      "few-shapes",     "exact"};
    for (const TriangleMethod& method : triangle_methods()) names.push_back(method.name);
    return names;
}

void check_engine_name(std::string_view name) {
    const auto names = engine_names();
    const std::string_view method = method_of(name);
    if (is_reference_method(method) || std::ranges::count(names, method) > 0) return;
    throw Error(
        fmt::format("unknown method '{}'; there are {}; a triangle method may be followed "
                    "by :bounds or :loop, any by @coherent or @incoherent",
                    name, fmt::join(names, ", ")));
}

Engine make_engine(const Scene& scene, std::string_view name, const EmbreeOptions& embree) {
    check_engine_name(name);
    return {std::string(name), make_method(scene, method_of(name), embree), pinned(name)};
}

std::vector<Engine> make_engines(const Scene& scene, std::span<const std::string> names,
                                 const EmbreeOptions& embree) {
    for (const std::string& name : names) check_engine_name(name);
    std::vector<Engine> engines;
    for (const std::string& name : names)
        if (std::ranges::none_of(engines, [&](const Engine& e) { return e.name == name; }))
            engines.push_back(make_engine(scene, name, embree));
    return engines;
}

}  // namespace sightline
