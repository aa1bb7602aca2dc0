#include "scene/frame.h"

namespace sightline {
namespace {

// The length of a triangle's normal is √(n·n) with n = e₁ × e₂: fourth powers of edges, which
// floats hold from 2⁻³¹ to 2³². A tiny scene may still have triangles of 2⁻¹⁵ radii.
constexpr int tiny_exponent = -16, huge_exponent = 30;

}  // namespace

Mat4d Frame::to_frame() const {
    Mat4d m;
    m.setScale(Vec3d(scale));
    for (int i = 0; i < 3; ++i) m[3][i] = -origin[i] * scale;
    return m;
}

Mat4d Frame::from_frame() const {
    Mat4d m;
    m.setScale(Vec3d(1 / scale));
    for (int i = 0; i < 3; ++i) m[3][i] = origin[i];
    return m;
}

Frame choose_frame(const Box3d& bounds) {
    Frame frame;
    const double radius = bounds.isEmpty() ? 0 : bounds.size().length() / 2;
    if (!(radius > 0)) return frame;
    const Vec3d centre = bounds.center();
    const int exponent = std::ilogb(radius);
    if (centre.length() > far_in_radii * radius) {
        // Snapped, so that small changes of the asset do not move it.
        const double grid = std::ldexp(1.0, exponent + 1);
        for (int i = 0; i < 3; ++i) frame.origin[i] = std::round(centre[i] / grid) * grid;
    }
    if (exponent < tiny_exponent) frame.scale = std::ldexp(1.0, -exponent);
    // As large as the range allows, since small things may belong to a huge scene.
    if (exponent >= huge_exponent) frame.scale = std::ldexp(1.0, huge_exponent - 1 - exponent);
    return frame;
}

}  // namespace sightline
