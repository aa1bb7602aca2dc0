#include "scene/gltf/contents.h"

#include <algorithm>

namespace sightline {
namespace {

using nlohmann::json;

std::vector<std::string> names_of(const json& objects) {
    std::vector<std::string> names;
    for (const json& object : objects) names.push_back(object.value("name", std::string()));
    return names;
}

// The specification requires the bounds of keyframe times, so no accessor needs to be read.
double last_keyframe(const Document& document, const GltfAnimation& animation) {
    double last = 0;
    for (const GltfAnimation::Sampler& sampler : animation.samplers) {
        if (sampler.input == none) continue;  // left out
        const json& accessor = document.list("accessors")[sampler.input];
        const auto max = accessor.find("max");
        const bool known = max != accessor.end() && max->is_array() && max->size() == 1 &&
                           max->front().is_number();
        if (known) last = std::max(last, max->front().get<double>());
    }
    return last;
}

}  // namespace

std::vector<std::string> names_in(const Document& document, const char* list) {
    return names_of(document.list(list));
}

std::vector<std::string> variant_names(const Document& document) {
    const json* extension = find_extension(document.json, "KHR_materials_variants");
    return extension ? names_of((*extension)["variants"]) : std::vector<std::string>();
}

FileContents read_contents(const Document& document) {
    FileContents contents;
    contents.scenes = names_in(document, "scenes");
    contents.variants = variant_names(document);
    for (const GltfAnimation& animation : document.animations)
        contents.animations.push_back({animation.name, last_keyframe(document, animation)});
    document.list("extensionsUsed").get_to(contents.extensions);
    return contents;
}

}  // namespace sightline
