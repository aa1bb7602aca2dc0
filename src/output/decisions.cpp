#include "output/decisions.h"

#include "output/environment_cache.h"
#include "output/formats.h"
#include "render/texture_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace sightline {

Decision light_decision(const LightOptions& light, const Scene& scene) {
    const std::string env = choose_environment(light, scene);
    const size_t lamps = scene.lights.size();
    std::string choice = lamps == 0 ? "" : fmt::format("{} of the file", lamps);
    if (env != "none") choice += (choice.empty() ? "" : " and ") + env;
    if (choice.empty()) choice = "none";
    const char* because = !light.env.empty()           ? "asked for"
                          : env != "none" && lamps > 0 ? "the file's lamps leave it dark"
                          : lamps > 0                  ? "the file has lights"
                          : scene.background           ? "the file has a background and no lights"
                                             : "the file has neither lights nor a background";
    return {"light", choice, because, ""};
}

void add_module_need(const RenderCommand& command, const Scene& scene, Needs& needs) {
    const auto written = std::ranges::count_if(command.output.pictures, is_written_by_module);
    const auto decoded =
        std::ranges::count_if(scene.images, [](const Image& i) { return i.by_module; });
    const bool read = is_environment_file(choose_environment(command.light, scene));
    const bool on = written + decoded + read > 0;
    needs.report.push_back(
        {"image_module", on ? "on" : "off",
         fmt::format("{} pictures written other than PNG, JPEG and EXR, {} textures other than "
                     "PNG and JPEG and {} environments decoded",
                     written, decoded, int{read}),
         on ? "" : "loading OpenImageIO and all that it links"});
}

void add_frame_need(const Scene& scene, Needs& needs) {
    const Frame& frame = scene.frame;
    if (frame.is_identity()) return;
    needs.report.push_back({"coordinates",
                            fmt::format("minus ({}, {}, {}), times {}", frame.origin.x,
                                        frame.origin.y, frame.origin.z, frame.scale),
                            "the scene is far from the origin, tiny or huge", ""});
}

void add_texture_need(const Scene& scene, Needs& needs) {
    size_t images = 0, reduced = 0, kept = 0, whole = 0;
    int least = std::numeric_limits<int>::max();
    for (const Image& image : scene.images) {
        if (image.empty()) continue;
        ++images;
        kept += image.memory();
        whole += image.memory() << 2 * image.level;
        reduced += image.level > 0;
        if (image.level > 0) least = std::min(least, image.level);
    }
    if (images == 0) return;
    if (reduced == 0) {
        needs.report.push_back({"textures", "whole",
                                "rays of this view may read every texel of "
                                "each image",
                                ""});
        return;
    }
    needs.report.push_back(
        {"textures", "reduced",
         fmt::format("{} of {} images are needed at 1/{} of their size or less by all that this "
                     "view sees but {} of its pixels",
                     reduced, images, 1 << least, TextureLevels::ignored_share),
         fmt::format("decoding and keeping {:.1f} of {:.1f} MiB", double(whole - kept) / 0x1p20,
                     double(whole) / 0x1p20)});
}

}  // namespace sightline
