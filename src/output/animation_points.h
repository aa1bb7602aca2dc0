#pragma once
#include "output/options.h"
#include "scene/camera_fit.h"

namespace sightline {

/// Frames of an animation that are looked at to frame it; of more, this many evenly spaced ones.
inline constexpr int max_framed_frames = 250;

/// The points of the command's asset that frame_camera needs to frame all frames of
/// view.frame_for, which is set; the origin if nothing is visible in any of them. `content_hash`:
/// of the asset. The last answer is kept, as a process often renders many frames of an asset.
/// Thread-safe.
std::vector<Vec3d> animation_points(const RenderCommand& command, uint64_t content_hash,
                                    const Framing& framing);

/// The y of the lowest visible point in all those frames; nothing if there is none. The last answer
/// is kept. Thread-safe.
std::optional<double> lowest_in_animation(const RenderCommand& command, uint64_t content_hash);

/// The point that reaches farthest.
Vec3d farthest_of(const std::vector<Vec3d>& points, const Reach& reach);

}  // namespace sightline
