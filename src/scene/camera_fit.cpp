#include "scene/camera_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

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

Camera fit_camera(const Box3& bounds, const Vec3& from) {
    const float yfov = pi / 4;
    const Vec3 center = bounds.isEmpty() ? Vec3(0) : bounds.center();
    const float diagonal = bounds.isEmpty() ? 0 : bounds.size().length();
    const float radius = diagonal > 0 ? diagonal / 2 : 1;  // a point or nothing: any distance
    const Vec3 direction = normalize(from);
    return look_at(center + direction * (radius / std::sin(yfov / 2)), center, {0, 1, 0}, yfov);
}

std::span<const std::string> view_names() {
    static const std::vector<std::string> names = {"fit",   "front", "back",  "left",
                                                   "right", "top",   "bottom"};
    return names;
}

std::optional<Vec3> view_direction(const std::string& name) {
    static const Vec3 directions[] = {{0.6f, 0.35f, 0.8f}, {0, 0, 1}, {0, 0, -1}, {-1, 0, 0},
                                      {1, 0, 0},           {0, 1, 0}, {0, -1, 0}};
    const std::span<const std::string> names = view_names();
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) return std::nullopt;
    return directions[found - names.begin()];
}

}  // namespace sightline
