#include "lab/atlas/meshes.h"

#include "scene/scene_builder.h"

namespace sightline {

Scene scene_of_meshes(std::vector<Mesh> meshes) {
    SceneBuilder builder;
    builder.add_instance(builder.add_group(std::move(meshes)));
    return builder.finish();
}

void add_grid_triangles(Mesh& mesh, uint32_t side) {
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const uint32_t a = y * (side + 1) + x, b = a + 1, c = a + side + 1, d = c + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
}

Mesh bumpy_patch(uint32_t side, double bumps, const Mat4d& transform, Rng& rng) {
    Mesh mesh;
    const double half = 0.5 * side;
    for (uint32_t y = 0; y <= side; ++y)
        for (uint32_t x = 0; x <= side; ++x) {
            const Vec3d jitter = rng.in_cube(0.25);
            const Vec3d p(x - half + jitter.x, y - half + jitter.y, bumps * jitter.z);
            mesh.positions.push_back(Vec3(transform_point(p, transform)));
        }
    add_grid_triangles(mesh, side);
    return mesh;
}

Mesh closed_globe(uint32_t n, const Mat4d& transform) {
    Mesh mesh;
    const auto add = [&](const Vec3d& p) {
        mesh.positions.push_back(Vec3(transform_point(p, transform)));
    };
    add({0, 0, 1});
    for (uint32_t i = 1; i < n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
            const double a = M_PI * i / n, b = 2 * M_PI * j / n;
            add({std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)});
        }
    add({0, 0, -1});
    const auto vertex = [n](uint32_t i, uint32_t j) {
        return i == 0 ? 0 : i == n ? 1 + n * (n - 1) : 1 + (i - 1) * n + j % n;
    };
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < n; ++j) {
            const uint32_t a = vertex(i, j), b = vertex(i, j + 1), c = vertex(i + 1, j),
                           d = vertex(i + 1, j + 1);
            if (i > 0) mesh.triangles.push_back({a, c, b});
            if (i + 1 < n) mesh.triangles.push_back({b, c, d});
        }
    return mesh;
}

Mat4d random_rotation(Rng& rng) {
    const Vec3d z = rng.direction(), x = normalize(cross(z, rng.direction())), y = cross(z, x);
    return {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, 0, 0, 0, 1};
}

Mat4d scale_and_translate(const Vec3d& scale, const Vec3d& offset) {
    return {scale.x, 0, 0, 0, 0, scale.y, 0, 0, 0, 0, scale.z, 0, offset.x, offset.y, offset.z, 1};
}

Vec3d random_target(const Mesh& mesh, Target target, Rng& rng) {
    const uint32_t triangle = rng.below(mesh.triangles.size());
    return random_target(mesh, triangle, target, rng);
}

Vec3d random_target(const Mesh& mesh, uint32_t index, Target target, Rng& rng) {
    const auto& triangle = mesh.triangles[index];
    const uint32_t first = rng.below(3);
    const Vec3d a(mesh.positions[triangle[first]]), b(mesh.positions[triangle[(first + 1) % 3]]),
        c(mesh.positions[triangle[(first + 2) % 3]]);
    if (target == Target::vertex) return a;
    const double s = rng.uniform(0, 1);
    if (target == Target::edge) return a + (b - a) * s;
    const double t = rng.uniform(0, 1 - s);
    return a + (b - a) * s + (c - a) * t;
}

}  // namespace sightline
