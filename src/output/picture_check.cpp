#include "output/picture_check.h"

#include "scene/shape_bounds.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

std::string why_empty(const RenderContext& context, const Counters& counters) {
    const Scene& scene = context.scene;
    if (scene.instances.empty()) return "the asset has nothing to draw";
    if (counters.uncovered_hits > 0)
        return "all that the camera meets is fully transparent, or culled since it is seen from "
               "behind";
    if (scene.bounds.isEmpty()) return "the camera looks past the asset";
    // In camera space, along whose −z the camera looks.
    const Box3 bounds = transformed_box(scene.bounds, Mat4d(context.camera.world_to_camera()));
    const Camera& camera = context.settings.camera;
    if (bounds.min.z >= 0) return "the asset lies behind the camera";
    if (-bounds.min.z <= camera.znear) return "the asset lies before the camera's znear";
    if (-bounds.max.z > camera.zfar) return "the asset lies beyond the camera's zfar";
    const float distance = std::max(-bounds.max.z, 0.0f);
    const float pixel = context.camera.pixel_width() + context.camera.pixel_spread() * distance;
    if (bounds.size().length() < pixel) return "the asset is smaller than a pixel";
    return "the camera looks past the asset";
}

std::string why_black(const RenderContext& context) {
    const bool lit = context.environment || context.needs.area_lights ||
                     std::ranges::any_of(context.scene.lights, [](const Light& light) {
                         return light.intensity > 0 && !is_black(light.color);
                     });
    return lit ? "no light reaches what the camera sees, or it reflects none"
               : "there is no light: the asset has none, and the environment is none";
}

}  // namespace

const char* to_string(PictureContent content) {
    constexpr const char* names[] = {"something", "empty", "black"};
    return names[static_cast<size_t>(content)];
}

PictureContent content_of(const RenderResult& result) {
    if (result.counters.seen_surfaces == 0) return PictureContent::empty;
    return result.lit_pixels == 0 ? PictureContent::black : PictureContent::something;
}

std::string why_blank(PictureContent content, const RenderContext& context,
                      const RenderResult& result) {
    return content == PictureContent::black
               ? "the picture is black: " + why_black(context)
               : "the picture is empty: " + why_empty(context, result.counters);
}

}  // namespace sightline
