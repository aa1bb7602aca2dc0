#include "lab/atlas/families.h"
#include "lab/atlas/meshes.h"
#include "lab/atlas/scene_experiment.h"
#include "scene/scene_builder.h"

#include <algorithm>

namespace sightline {
namespace {

/// Edges and vertices inside a bumpy patch, seen from far away and not from its side. As on a
/// closed mesh, each ray must hit something.
SceneRays distant_patch(const ExperimentRequest& request, Target part) {
    Rng rng(request.seed);
    const Mat4d turn = random_rotation(rng);
    const Vec3d up(turn[2][0], turn[2][1], turn[2][2]);
    constexpr uint32_t side = 24, rim = 2;
    Mesh mesh = bumpy_patch(side, 1, turn, rng);
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const uint32_t x = rim + rng.below(side - 2 * rim), y = rim + rng.below(side - 2 * rim);
        const uint32_t triangle = 2 * (y * side + x) + rng.below(2);
        const Vec3d target = random_target(mesh, triangle, part, rng);
        const Vec3d above = up * (2 * rng.sign());
        const Vec3d back = normalize(above + rng.direction());
        rays.push_back(aimed_ray(target + back * request.knob, target, rng));
    }
    std::vector<Mesh> meshes;
    meshes.push_back(std::move(mesh));
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// Needles of length 2 along the axes. They are close to the origin, so that floats can represent
/// their width, and rays run in planes at right angles to the width, which floats can represent,
/// too.
SceneRays needles(const ExperimentRequest& request) {
    Rng rng(request.seed);
    const double width = 1 / request.knob;
    Mesh mesh;
    for (uint32_t i = 0; i < 48; ++i) {
        const int along = static_cast<int>(i % 3);
        for (const double x : {-1.0, 1.0, rng.uniform(-0.5, 0.5)}) {
            Vec3 p(rng.in_cube(width));
            p[along] = static_cast<float>(x);
            mesh.positions.push_back(p);
        }
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const int thin = static_cast<int>(rng.below(3));
        const Vec3d target = random_target(mesh, i % 4 < 2 ? Target::edge : Target::inside, rng);
        Vec3d origin = rng.direction(1, 3);
        origin[thin] = target[thin];
        rays.push_back(aimed_ray(origin, target, rng));
    }
    std::vector<Mesh> meshes;
    meshes.push_back(std::move(mesh));
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// A patch without bumps around `centre`, parallel to the plane z = 0 or rotated.
Mesh flat_patch(uint32_t side, bool rotated, const Vec3d& centre, Rng& rng) {
    Mat4d transform = rotated ? random_rotation(rng) : Mat4d();
    transform[3][0] = centre.x, transform[3][1] = centre.y, transform[3][2] = centre.z;
    return bumpy_patch(side, 0, transform, rng);
}

/// The plane z = 0, where floats can represent any angle, and an oblique plane far beside it.
SceneRays grazing(const ExperimentRequest& request) {
    Rng rng(request.seed);
    std::vector<Mesh> meshes;
    meshes.push_back(flat_patch(12, false, {0, 0, 0}, rng));
    meshes.push_back(flat_patch(12, true, {100, 0, 0}, rng));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Mesh& mesh = meshes[i % 2];
        const auto& [a, b, c] = mesh.triangles[0];
        const Vec3d x = normalize(Vec3d(mesh.positions[b]) - Vec3d(mesh.positions[a]));
        const Vec3d across = Vec3d(mesh.positions[c]) - Vec3d(mesh.positions[a]);
        const Vec3d z = normalize(cross(x, across)), y = cross(z, x);
        const Vec3d target = random_target(mesh, i % 4 < 2 ? Target::edge : Target::inside, rng);
        const double turn = rng.uniform(0, 2 * M_PI), height = 1 / request.knob;
        const Vec3d along = x * std::cos(turn) + y * std::sin(turn);
        const Vec3d back = (along + z * height) * rng.uniform(1, 20);
        rays.push_back(aimed_ray(target + back, target, rng));
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// A ray from inside a closed mesh to one of its vertices, an edge or the inside of a triangle.
Ray ray_from_inside(const Mesh& mesh, const Vec3d& centre, double size, size_t i, Rng& rng) {
    const Vec3d origin = centre + rng.in_cube(0.3 * size);
    const Vec3d target = random_target(mesh, static_cast<Target>(i % 3), rng);
    return aimed_ray(origin, target, rng);
}

/// A closed mesh of size `scale`. Directions have about that length, 1e-12 or 1e12 times it, within
/// the range of floats.
SceneRays scaled(const ExperimentRequest& request, double scale) {
    Rng rng(request.seed);
    std::vector<Mesh> meshes;
    meshes.push_back(closed_globe(8, scale_and_translate(Vec3d(scale, scale, scale), {0, 0, 0})));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        Ray ray = ray_from_inside(meshes[0], {0, 0, 0}, scale, i, rng);
        const double length = Vec3d(ray.direction).length();
        const double stretch = std::pow(10, 12 * (rng.below(3) - 1.0));
        ray.direction =
            Vec3(Vec3d(ray.direction) * (std::clamp(length * stretch, 1e-30, 1e30) / length));
        rays.push_back(ray);
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

SceneRays far_from_origin(const ExperimentRequest& request) {
    Rng rng(request.seed);
    const Vec3d centre = Vec3d(0.61, 0.64, -0.47) * request.knob;
    std::vector<Mesh> meshes;
    meshes.push_back(closed_globe(12, scale_and_translate({1, 1, 1}, centre)));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i)
        rays.push_back(ray_from_inside(meshes[0], centre, 1, i, rng));
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// Two pairs of patches, each 1/knob apart: across z at the origin, where floats can represent any
/// gap, and oblique. Rays come from both sides.
SceneRays near_coplanar(const ExperimentRequest& request) {
    Rng rng(request.seed);
    std::vector<Mesh> meshes;
    for (const bool rotated : {false, true}) {
        const Mat4d turn = rotated ? random_rotation(rng) : Mat4d();
        for (const double height : {0.0, 1 / request.knob}) {
            Mat4d transform = turn;
            const Vec3d up = transform_vector(Vec3d(0, 0, height), turn);
            transform[3][0] = up.x + 100.0 * rotated, transform[3][1] = up.y,
            transform[3][2] = up.z;
            meshes.push_back(bumpy_patch(4, 0, transform, rng));
        }
    }
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d target = random_target(meshes[i % 4], Target::inside, rng);
        rays.push_back(aimed_ray(target + rng.direction(1, 3), target, rng));
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

// T7: rays and triangles along the axes, where products are exactly zero.
enum AxisAlignedCase { dyadic, decimal, negative_zero, from_plane, denormal, cube };

/// A flat grid of cells of width h in the plane z = height, around the origin.
Mesh grid(uint32_t side, float h, float height) {
    Mesh mesh;
    const auto half = static_cast<float>(side) / 2;
    for (uint32_t y = 0; y <= side; ++y)
        for (uint32_t x = 0; x <= side; ++x)
            mesh.positions.push_back(
                {(static_cast<float>(x) - half) * h, (static_cast<float>(y) - half) * h, height});
    add_grid_triangles(mesh, side);
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

/// A ray straight down onto a vertex of the grid, or onto a line between two.
Ray straight_down(const Mesh& mesh, float h, Rng& rng) {
    Vec3 origin = mesh.positions[rng.below(mesh.positions.size())];
    const auto along = static_cast<float>(rng.uniform(0, 1)) * h;
    if (rng.coin()) origin[static_cast<int>(rng.below(2))] += along;
    origin.z = h;
    return {origin, 0, {0, 0, -h}};
}

/// A ray from the plane z = 0; half of these rays stay in it.
Ray from_the_plane(Rng& rng) {
    Vec3 origin(rng.in_cube(1)), direction(rng.direction());
    origin.z = rng.coin() ? 0.0f : -0.0f;
    if (rng.coin()) direction.z = 0;
    return {origin, 0, direction};
}

/// A ray along an axis or a diagonal, from a point of a coarse dyadic lattice within the cube.
Ray along_diagonals(Rng& rng) {
    Vec3 origin, direction;
    do {
        for (int i = 0; i < 3; ++i) {
            origin[i] = (static_cast<float>(rng.below(7)) - 3) * 0.25f;
            direction[i] = (static_cast<float>(rng.below(5)) - 2) * 0.5f;
            if (direction[i] == 0 && rng.coin()) direction[i] = -0.0f;
        }
    } while (direction == Vec3(0, 0, 0));
    return {origin, 0, direction};
}

/// The knob is the index of a case.
SceneRays axis_aligned(const ExperimentRequest& request) {
    Rng rng(request.seed);
    const auto which = static_cast<AxisAlignedCase>(request.knob);
    const float h = which == decimal ? 0.1f : which == denormal ? 0x1p-140f : 0.25f;
    std::vector<Mesh> meshes;
    meshes.push_back(which == cube ? cube_mesh() : grid(12, h, 0));
    if (which == from_plane) meshes.push_back(grid(12, h, -1));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        Ray ray = which == cube         ? along_diagonals(rng)
                  : which == from_plane ? from_the_plane(rng)
                                        : straight_down(meshes[0], h, rng);
        if (which == negative_zero) ray.direction.x = ray.direction.y = -0.0f;
        rays.push_back(ray);
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// An instance of a closed mesh, scaled by 1/knob along one axis and by the root of that along
/// another. The knob is the condition number of the matrix.
SceneRays squeezed(const ExperimentRequest& request) {
    Rng rng(request.seed);
    const Mesh globe = closed_globe(8, Mat4d());
    const Vec3d scale(1, 1 / std::sqrt(request.knob), 1 / request.knob);
    Mat4d matrix = random_rotation(rng) * scale_and_translate(scale, {0, 0, 0});
    matrix = matrix * random_rotation(rng) * scale_and_translate({1, 1, 1}, rng.in_cube(1));
    const Mat4d to_world{Mat4(matrix)};
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d origin = rng.in_cube(0.3);
        const Vec3d target = random_target(globe, static_cast<Target>(i % 3), rng);
        rays.push_back(
            aimed_ray(transform_point(origin, to_world), transform_point(target, to_world), rng));
    }
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(globe), Mat4(matrix));
    return {builder.finish(), std::move(rays)};
}

Family scene_family(std::string name, std::string title, std::string knob,
                    std::vector<KnobValue> values,
                    std::function<SceneRays(const ExperimentRequest&)> make) {
    return {std::move(name),
            std::move(title),
            std::move(knob),
            std::move(values),
            scene_methods(),
            [make = std::move(make)](const ExperimentRequest& r) {
                return make_scene_experiment(make(r));
            }};
}

}  // namespace

std::vector<Family> triangle_families() {
    const auto distances = powers(10, 0, 6), sizes = powers(10, 0, 18, 3);
    return {scene_family("T1e", "rays aimed at edges of a bumpy patch", "distance / edge length",
                         distances, [](const auto& r) { return distant_patch(r, Target::edge); }),
            scene_family("T1v", "rays aimed at vertices of a bumpy patch", "distance / edge length",
                         distances, [](const auto& r) { return distant_patch(r, Target::vertex); }),
            scene_family("T2", "needles", "length / width", powers(10, 0, 12, 2), needles),
            scene_family("T3", "grazing rays", "1 / angle", powers(10, 0, 9), grazing),
            scene_family("T4s", "small sizes, directions of all lengths", "1 / size", sizes,
                         [](const auto& r) { return scaled(r, 1 / r.knob); }),
            scene_family("T4l", "large sizes, directions of all lengths", "size", sizes,
                         [](const auto& r) { return scaled(r, r.knob); }),
            scene_family("T5", "closed meshes far from the origin", "offset / size",
                         zero_and_powers(10, 1, 7), far_from_origin),
            scene_family("T6", "surfaces close behind each other", "size / gap",
                         powers(10, 0, 12, 2), near_coplanar),
            scene_family("T7", "rays and triangles along the axes, zeros and denormals", "case",
                         numbered({"grid of 1/4", "grid of 0.1", "directions of -0",
                                   "from the plane", "denormal grid", "diagonals of a cube"}),
                         axis_aligned),
            scene_family("X1", "instances squeezed by their matrix", "condition of the matrix",
                         powers(10, 0, 8), squeezed)};
}

}  // namespace sightline
