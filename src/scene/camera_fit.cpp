#include "scene/camera_fit.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

/// Extents along one axis of the picture, seen through a plane that is tilted towards the view:
/// with x along the axis and z towards the camera, the largest x + t·z and −x + t·z.
struct Extents {
    Vec3d high, low;  ///< (x, z) as (x, 0, z) of the points where they are reached
    double of_high(double t) const { return high.x + t * high.z; }
    double of_low(double t) const { return -low.x + t * low.z; }
};

/// One axis of the picture: horizontal or vertical.
class PictureAxis {
  public:
    PictureAxis(const FarthestPoint& farthest, const Vec3d& axis, const Vec3d& towards,
                const std::optional<Vec3d>& turn_axis)
        : farthest_(farthest), axis_(axis), towards_(towards), turn_axis_(turn_axis) {}

    /// With planes whose tangent to the view is t.
    Extents extents(double t) const {
        const auto find = [&](double sign) {
            const Vec3d p = farthest_({axis_ * sign + towards_ * t, turn_axis_});
            return Vec3d(dot(p, axis_), 0, dot(p, towards_));
        };
        return {find(1), find(-1)};
    }

    /// The least distance along the view, from the origin, at which planes of tangent t hold all.
    double least_distance(double t) const {
        const Extents e = extents(t);
        return (e.of_high(t) + e.of_low(t)) / (2 * t);
    }

    /// The camera's place on the axis, at a distance, for which what is seen reaches equally far
    /// to both sides. Newton's method on the tangent: the function is concave, so it rises to the
    /// root from below, and ends there since it is made of straight pieces.
    double centre(double distance) const {
        double t = 0;
        Extents e = extents(t);
        for (int i = 0; i < 32; ++i) {
            const double slope = 2 * distance - e.high.z - e.low.z;
            const double next = slope > 0 ? (e.high.x - e.low.x) / slope : t;
            if (!(next > t * (1 + 1e-9))) break;
            t = next;
            e = extents(t);
        }
        return (e.of_high(t) - e.of_low(t)) / 2;
    }

  private:
    const FarthestPoint& farthest_;
    Vec3d axis_, towards_;
    std::optional<Vec3d> turn_axis_;
};

/// The axes of the picture, to the right and up, and the direction towards the camera.
struct ViewAxes {
    Vec3d right, up, towards;
};

ViewAxes axes_of(const Framing& framing) {
    const Mat4 rotation = view_rotation(framing.angles);
    const auto row = [&](int r) {
        const float* m = rotation[r];
        return normalize(Vec3d(double(m[0]), double(m[1]), double(m[2])));
    };
    return {row(0), row(1), row(2)};
}

std::optional<Vec3d> turn_axis_of(const Framing& framing) {
    if (!framing.turn_axis) return std::nullopt;
    return Vec3d(*framing.turn_axis);
}

/// The share of the picture's width and height that may be filled.
double used_share(const Framing& framing) { return 1 - 2 * double(framing.margin); }

/// Of the planes between which what is framed must lie, to the view.
Imath::V2d tangents(const Framing& framing) {
    const double t = std::tan(double(framing.yfov) / 2) * used_share(framing);
    return {t * double(framing.aspect), t};
}

}  // namespace

Camera look_at(const Vec3& from, const Vec3& at, const Vec3& up, float yfov) {
    Camera camera;
    camera.yfov = yfov;
    const Vec3 z = at == from ? Vec3(0, 0, 1) : normalize(from - at);
    Vec3 x = cross(up, z);
    if (dot(x, x) < 1e-12f) x = cross(std::abs(z.y) < 0.9f ? Vec3(0, 1, 0) : Vec3(0, 0, -1), z);
    x = normalize(x);
    const Vec3 rows[4] = {x, cross(z, x), z, from};
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 3; ++c) camera.to_world[r][c] = rows[r][c];
    return camera;
}

Camera frame_camera(const FarthestPoint& farthest, const Framing& framing) {
    Camera camera;
    camera.orthographic = framing.orthographic;
    camera.yfov = framing.yfov;
    camera.to_world = view_rotation(framing.angles);
    const auto [right, up, towards] = axes_of(framing);
    const std::optional<Vec3d> turn_axis = turn_axis_of(framing);
    const PictureAxis across(farthest, right, towards, turn_axis);
    const PictureAxis along(farthest, up, towards, turn_axis);
    const Extents wide = across.extents(0), high = along.extents(0);
    const double width = wide.high.x - wide.low.x, height = high.high.x - high.low.x;
    const double front = dot(farthest({towards, turn_axis}), towards);
    const double depth = front + dot(farthest({-towards, turn_axis}), -towards);
    double size = std::max({width, height, depth});
    if (!(size > 0)) size = 1;
    double distance = front + size;
    double x = (wide.high.x + wide.low.x) / 2, y = (high.high.x + high.low.x) / 2;
    if (framing.orthographic) {
        const double half =
            std::max(height, width / double(framing.aspect)) / 2 / used_share(framing);
        camera.ymag = static_cast<float>(half > 0 ? half : size / 2);
        camera.xmag = camera.ymag * framing.aspect;
    } else {
        const Imath::V2d t = tangents(framing);
        distance = std::max(across.least_distance(t.x), along.least_distance(t.y));
        // What has no width and height may come no nearer than a point of this size.
        const double least_size = std::max(width, height) > 0 ? 1e-3 * size : size;
        distance = std::max(distance, front + least_size);
        x = across.centre(distance);
        y = along.centre(distance);
    }
    const Vec3d from = right * x + up * y + towards * distance;
    for (int c = 0; c < 3; ++c) camera.to_world[3][c] = static_cast<float>(from[c]);
    return camera;
}

std::vector<Vec3d> framing_points(const SceneExtent& scene, const Framing& framing) {
    constexpr int steps = 16;
    const auto [right, up, towards] = axes_of(framing);
    const std::optional<Vec3d> turn_axis = turn_axis_of(framing);
    const Imath::V2d t = tangents(framing);
    std::vector<Vec3d> points;
    const auto find = [&](const Vec3d& direction) {
        points.push_back(scene.farthest({direction, turn_axis}));
    };
    find(towards);
    find(-towards);
    for (int i = 0; i <= steps; ++i)
        for (const double sign : {1.0, -1.0}) {
            find(right * sign + towards * (t.x * i / steps));
            find(up * sign + towards * (t.y * i / steps));
        }
    return points;
}

Camera fit_camera(const Box3& bounds, const ViewAngles& angles) {
    const Vec3 center = bounds.isEmpty() ? Vec3(0) : bounds.center();
    const float diagonal = bounds.isEmpty() ? 0 : bounds.size().length();
    const float radius = diagonal > 0 ? diagonal / 2 : 1;  // a point or nothing: any distance
    Camera camera;
    camera.to_world = view_rotation(angles);
    const Vec3 direction = transform_vector(Vec3(0, 0, 1), camera.to_world);
    const Vec3 from = center + direction * (radius / std::sin(camera.yfov / 2));
    for (int c = 0; c < 3; ++c) camera.to_world[3][c] = from[c];
    return camera;
}

}  // namespace sightline
