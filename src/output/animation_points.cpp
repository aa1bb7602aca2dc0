#include "output/animation_points.h"

#include "output/tile_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
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

/// Of all that the frames depend on.
std::string frames_key(const RenderCommand& command, uint64_t content_hash) {
    LoadOptions load = command.load;
    load.time.reset();  // each frame has its own
    const FrameRange& times = *command.view.frame_for;
    return fmt::format("{} {:016x} {:016x} {}..{}@{}", command.asset, content_hash,
                       load_options_key(load), times.first, times.last, times.fps);
}

/// Of all that the points depend on.
std::string points_key(const RenderCommand& command, uint64_t content_hash,
                       const Framing& framing) {
    const Vec3 axis = framing.turn_axis.value_or(Vec3(0, 0, 0));
    return fmt::format("{} {}/{} {} {} {} {} {},{},{}", frames_key(command, content_hash),
                       framing.angles.azimuth, framing.angles.elevation, framing.yfov,
                       framing.aspect, framing.margin, framing.turn_axis.has_value(), axis.x,
                       axis.y, axis.z);
}

/// Calls `visit` with what is visible in each of the frames in which something is.
void for_each_frame(const RenderCommand& command,
                    const std::function<void(const SceneExtent&)>& visit) {
    LoadOptions load = command.load;
    load.decode_images = false;
    GltfAsset asset;
    for (const int frame : sampled_frames(*command.view.frame_for)) {
        load.time = static_cast<float>(frame / command.view.frame_for->fps);
        if (asset.file)
            asset.file->pose(*load.time, asset.scene);
        else
            asset = read_gltf(command.asset, load, GltfFile::Times::any);
        if (const SceneExtent extent(asset.scene); !extent.is_empty()) visit(extent);
    }
}

}  // namespace

std::vector<Vec3d> animation_points(const RenderCommand& command, uint64_t content_hash,
                                    const Framing& framing) {
    static std::mutex mutex;
    static std::string kept_key;
    static std::vector<Vec3d> kept;
    const std::lock_guard lock(mutex);
    const std::string key = points_key(command, content_hash, framing);
    if (key == kept_key) return kept;
    std::vector<Vec3d> points;
    for_each_frame(command, [&](const SceneExtent& extent) {
        const std::vector<Vec3d> found = framing_points(extent, framing);
        points.insert(points.end(), found.begin(), found.end());
    });
    if (points.empty()) points.emplace_back(0, 0, 0);
    kept_key = key;
    return kept = points;
}

std::optional<double> lowest_in_animation(const RenderCommand& command, uint64_t content_hash) {
    static std::mutex mutex;
    static std::string kept_key;
    static std::optional<double> kept;
    const std::lock_guard lock(mutex);
    const std::string key = frames_key(command, content_hash);
    if (key == kept_key) return kept;
    std::optional<double> lowest;
    for_each_frame(command, [&](const SceneExtent& extent) {
        const double y = extent.farthest({Vec3d(0, -1, 0), std::nullopt}).y;
        lowest = std::min(lowest.value_or(y), y);
    });
    kept_key = key;
    return kept = lowest;
}

Vec3d farthest_of(const std::vector<Vec3d>& points, const Reach& reach) {
    return reach.point(*std::ranges::max_element(points, {}, reach));
}

}  // namespace sightline
