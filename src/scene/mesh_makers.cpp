#include "scene/mesh_makers.h"

namespace sightline {

Mesh quad_mesh(const Vec3& a, const Vec3& u, const Vec3& v) {
    Mesh mesh;
    mesh.positions = {a, a + u, a + u + v, a + v};
    mesh.texcoords = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

Mesh sphere_mesh(uint32_t rows, uint32_t columns, const Vec3& centre, float radius) {
    Mesh mesh;
    const auto add = [&](const Vec3& direction) {
        mesh.positions.push_back(centre + direction * radius);
        mesh.normals.push_back(direction);
    };
    const auto angle = [](uint32_t step, uint32_t steps, float full) {
        return full * static_cast<float>(step) / static_cast<float>(steps);
    };
    add({0, 1, 0});
    for (uint32_t row = 1; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            const float theta = angle(row, rows, pi), phi = angle(column, columns, 2 * pi);
            add({std::sin(theta) * std::cos(phi), std::cos(theta),
                 std::sin(theta) * std::sin(phi)});
        }
    }
    add({0, -1, 0});
    const auto vertex = [&](uint32_t row, uint32_t column) {
        if (row == 0) return 0u;
        if (row == rows) return static_cast<uint32_t>(mesh.positions.size() - 1);
        return 1 + (row - 1) * columns + column % columns;
    };
    for (uint32_t row = 0; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            const uint32_t a = vertex(row, column), b = vertex(row, column + 1);
            const uint32_t c = vertex(row + 1, column), d = vertex(row + 1, column + 1);
            if (row > 0) mesh.triangles.push_back({a, b, c});
            if (row < rows - 1) mesh.triangles.push_back({b, d, c});
        }
    }
    return mesh;
}

}  // namespace sightline
