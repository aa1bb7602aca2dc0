#include "output/animation_points.h"

#include "output/tile_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>

namespace sightline {
namespace {

/// The frames to look at: the first, the last and as many between as max_framed_frames allows.
std::vector<int> sampled_frames(const FrameRange& times) {
    const int count = times.last - times.first + 1, taken = std::min(count, max_framed_frames);
    std::vector<int> frames;
    for (int i = 0; i < taken; ++i)
        frames.push_back(taken == 1 ? times.first
                                    : times.first +
                                          static_cast<int>(int64_t{i} * (count - 1) / (taken - 1)));
    return frames;
}

/// Of all that the points depend on.
std::string key_of(const RenderCommand& command, uint64_t content_hash, const Framing& framing) {
    LoadOptions load = command.load;
    load.time.reset();  // each frame has its own
    const FrameRange& times = *command.view.frame_for;
    const Vec3 axis = framing.turn_axis.value_or(Vec3(0, 0, 0));
    return fmt::format("{} {:016x} {:016x} {}..{}@{} {}/{} {} {} {} {} {},{},{}", command.asset,
                       content_hash, load_options_key(load), times.first, times.last, times.fps,
                       framing.angles.azimuth, framing.angles.elevation, framing.yfov,
                       framing.aspect, framing.margin, framing.turn_axis.has_value(), axis.x,
                       axis.y, axis.z);
}

}  // namespace

std::vector<Vec3d> animation_points(const RenderCommand& command, uint64_t content_hash,
                                    const Framing& framing) {
    static std::mutex mutex;
    static std::string kept_key;
    static std::vector<Vec3d> kept;
    const std::lock_guard lock(mutex);
    const std::string key = key_of(command, content_hash, framing);
    if (key == kept_key) return kept;
    std::vector<Vec3d> points;
    LoadOptions load = command.load;
    load.decode_images = false;
    for (const int frame : sampled_frames(*command.view.frame_for)) {
        load.time = static_cast<float>(frame / command.view.frame_for->fps);
        const Scene scene = load_gltf(command.asset, load);
        const SceneExtent extent(scene);
        if (extent.is_empty()) continue;
        const std::vector<Vec3d> found = framing_points(extent, framing);
        points.insert(points.end(), found.begin(), found.end());
    }
    if (points.empty()) points.emplace_back(0, 0, 0);
    kept_key = key;
    return kept = points;
}

Vec3d farthest_of(const std::vector<Vec3d>& points, const Reach& reach) {
    return reach.point(*std::ranges::max_element(points, {}, reach));
}

}  // namespace sightline
