#pragma once
#include "output/options.h"
#include "render/needs.h"

namespace sightline {

/// The ground lies below the scene by this part of the diagonal of the scene's bounds, so that a
/// floor of the asset's own lies above it.
inline constexpr double ground_gap = 0x1p-14;

/// The ground of the command's picture, in the scene's frame; none for a scene in which nothing is
/// visible, unless a height is given. `background`: the colour behind it.
GroundSettings choose_ground(const RenderCommand& command, const Scene& scene,
                             const Vec3& background);

/// Says which ground it is and where it lies.
Decision ground_decision(const GroundOptions& options, const GroundSettings& ground,
                         const Scene& scene);

/// What is wrong with the command's ground; "" if nothing is.
std::string ground_problem(const RenderCommand& command);

}  // namespace sightline
