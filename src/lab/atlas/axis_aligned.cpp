#include "lab/atlas/axis_aligned.h"

#include "lab/atlas/mesh_making.h"

namespace sightline {
namespace {

enum Case : size_t { dyadic, decimal, negative_zero, from_plane, denormal, cube, case_count };

/// A flat grid of cells of width h in the plane z = height, around the origin.
Mesh grid(uint32_t side, float h, float height) {
    Mesh mesh;
    const auto half = static_cast<float>(side) / 2;
    for (uint32_t y = 0; y <= side; ++y)
        for (uint32_t x = 0; x <= side; ++x)
            mesh.positions.push_back(
                {(static_cast<float>(x) - half) * h, (static_cast<float>(y) - half) * h, height});
    add_cells(mesh, side);
    return mesh;
}

/// The closed cube of side 2 about the origin.
Mesh cube_mesh() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back(
            {i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    constexpr uint32_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                      {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
        mesh.triangles.push_back({f[0], f[1], f[2]});
        mesh.triangles.push_back({f[0], f[2], f[3]});
    }
    return mesh;
}

/// A ray straight down on a vertex of the grid, or on a line between two.
Ray straight_down(const Mesh& mesh, float h, Dice& dice) {
    Vec3 origin = mesh.positions[dice.below(mesh.positions.size())];
    const auto along = static_cast<float>(dice.between(0, 1)) * h;
    if (dice.coin()) origin[static_cast<int>(dice.below(2))] += along;
    origin.z = h;
    return {origin, 0, {0, 0, -h}};
}

/// From the plane z = 0 itself, half of them within it.
Ray from_the_plane(Dice& dice) {
    Vec3 origin(dice.vector(1)), direction(dice.direction());
    origin.z = dice.coin() ? 0.0f : -0.0f;
    if (dice.coin()) direction.z = 0;
    return {origin, 0, direction};
}

/// Along axes and diagonals from points of a coarse dyadic lattice within the cube.
Ray along_diagonals(Dice& dice) {
    Vec3 origin, direction;
    do {
        for (int i = 0; i < 3; ++i) {
            origin[i] = (static_cast<float>(dice.below(7)) - 3) * 0.25f;
            direction[i] = (static_cast<float>(dice.below(5)) - 2) * 0.5f;
            if (direction[i] == 0 && dice.coin()) direction[i] = -0.0f;
        }
    } while (direction == Vec3(0, 0, 0));
    return {origin, 0, direction};
}

}  // namespace

std::span<const std::string_view> axis_aligned_cases() {
    static constexpr std::string_view cases[case_count] = {
        "grid of 1/4",    "grid of 0.1",   "directions of -0",
        "from the plane", "denormal grid", "diagonals of a cube"};
    return cases;
}

SceneQueries axis_aligned(size_t which, size_t count, uint64_t seed) {
    Dice dice(seed);
    const float h = which == decimal ? 0.1f : which == denormal ? 0x1p-140f : 0.25f;
    std::vector<Mesh> meshes;
    if (which == cube)
        meshes.push_back(cube_mesh());
    else
        meshes.push_back(grid(12, h, 0));
    if (which == from_plane) meshes.push_back(grid(12, h, -1));
    std::vector<Ray> rays;
    for (size_t i = 0; i < count; ++i) {
        Ray ray = which == cube         ? along_diagonals(dice)
                  : which == from_plane ? from_the_plane(dice)
                                        : straight_down(meshes[0], h, dice);
        if (which == negative_zero) ray.direction.x = ray.direction.y = -0.0f;
        rays.push_back(ray);
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

}  // namespace sightline
