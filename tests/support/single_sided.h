#pragma once
// Materials and meshes whose faces are drawn from one side.
#include "support/pictures.h"

namespace sightline {

/// A Lambertian material whose backs are not drawn.
inline Material single_sided(const Vec3& color) {
    Material m = matte(color);
    m.double_sided = false;
    return m;
}

inline Material unlit(const Vec3& color) {
    Material m = single_sided(color);
    m.unlit = true;
    return m;
}

/// The mesh with its faces turned the other way.
inline Mesh turned(Mesh mesh) {
    for (auto& [a, b, c] : mesh.triangles) std::swap(b, c);
    for (Vec3& n : mesh.normals) n = -n;
    return mesh;
}

inline Mesh inside_out_ball(const Vec3& centre, float radius) {
    return turned(ball(centre, radius));
}

/// A level square of 2 · `half` around the y axis that looks upwards.
inline Mesh floor_mesh(float y, float half) {
    return quad_mesh({-half, y, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
}

}  // namespace sightline
