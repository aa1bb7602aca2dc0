#pragma once
#include "core/math.h"

namespace sightline {

using Box3d = Imath::Box3d;

/// Coordinates that suit floats: (p − origin) · scale. The scale is a power of two, so that it
/// changes no digit of a number.
struct Frame {
    Vec3d origin{0, 0, 0};
    double scale = 1;

    /// Whether the frame's coordinates are those that it is relative to.
    bool is_identity() const { return origin == Vec3d(0, 0, 0) && scale == 1; }

    Vec3d enter(const Vec3d& p) const { return (p - origin) * scale; }
    Vec3d leave(const Vec3d& p) const { return p / scale + origin; }

    /// enter() and leave() as matrices.
    Mat4d to_frame() const;
    Mat4d from_frame() const;
};

/// What lies farther from the origin than so many of its radii is far: rounding a coordinate there
/// costs 64 · 2⁻²⁴ = 2⁻¹⁸ radii, which is 0.4 pixels in a view of a hundredth of the scene over
/// 1000 pixels.
inline constexpr double far_in_radii = 64;

/// The frame for what lies within `bounds`; the identity unless that is far from the origin, tiny
/// or huge (ARCHITECTURE.md, "Numbers", gives the limits and their reasons).
Frame choose_frame(const Box3d& bounds);

}  // namespace sightline
