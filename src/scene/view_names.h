#pragma once
// The views that frame a scene: what --camera and --views accept besides the cameras of a file.
#include "core/math.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// Where a camera stands, as seen from the scene's centre.
struct ViewAngles {
    double azimuth = 0;  ///< degrees about +y: 0 in front (+z, glTF's front), 90 at the right (+x)
    double elevation = 0;  ///< degrees above the horizon, −90 to 90
    bool operator==(const ViewAngles&) const = default;
};

/// The default view, "fit": in front, to the right and a little above; its direction is
/// (0.6, 0.35, 0.8).
inline constexpr ViewAngles fit_view{36.86989764584402, 19.290046219188735};

/// The matrix of a camera at the origin that looks along the view; its +z axis points from the
/// scene to the camera, its +y axis upwards or, from straight above and below, where it would
/// come to lie if the camera rose to there. Unit orthogonal axes; exact for multiples of 90°.
Mat4 view_rotation(const ViewAngles& angles);

/// The view of this name, or of the form AZIMUTH/ELEVATION in degrees; empty for other words,
/// which may name a camera. Throws Error for angles out of range and for lists of views.
std::optional<ViewAngles> find_view(const std::string& view);

/// The names that find_view knows: "fit", "front", "three-quarter", "iso", …
std::span<const std::string> view_names();

/// All that is accepted as one view, as a part of a message.
std::string describe_views();

/// A view under a name that can be part of a file name.
struct NamedView {
    std::string name;    ///< "front", "az045_el20", "sphere12_01"; a camera: as given
    std::string camera;  ///< for --camera: a name, AZIMUTH/ELEVATION, or a camera of the file
};

/// The views that one element of a list stands for: itself; "ring:N@ELEVATION" or
/// "ring:N@AZIMUTH/ELEVATION": N views in equal steps of azimuth from there; "sphere:N": N views
/// spread evenly over all directions (a Fibonacci spiral). Throws Error if it is malformed.
std::vector<NamedView> expand_view(const std::string& element);

/// A full turn of `count` views from `start`.
struct Ring {
    int count = 0;
    std::optional<ViewAngles> start;  ///< unset: only the count was given
    bool operator==(const Ring&) const = default;
};

/// Parses "N", "N@ELEVATION" or "N@AZIMUTH/ELEVATION"; `prefix` stands before it in the message of
/// the Error.
Ring parse_ring(const std::string& text, const std::string& prefix = "");

}  // namespace sightline
