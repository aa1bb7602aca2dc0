#include "scene/camera_fit.h"

#include <cmath>

namespace sightline {

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
