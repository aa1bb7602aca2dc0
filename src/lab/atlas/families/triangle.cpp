#include "lab/atlas/axis_aligned.h"
#include "lab/atlas/families.h"
#include "lab/atlas/mesh_making.h"
#include "lab/atlas/scene_trial.h"

#include <algorithm>

namespace sightline {
namespace {

/// Edges and vertices within a bumpy patch, seen from far away and not from its side: as on a
/// closed mesh, whatever happens there the ray must hit something.
SceneQueries distant_patch(const TrialRequest& request, Target aim) {
    Dice dice(request.seed);
    const Mat4d turn = random_rotation(dice);
    const Vec3d up(turn[2][0], turn[2][1], turn[2][2]);
    constexpr uint32_t side = 24, rim = 2;
    Mesh mesh = bumpy_patch(side, 1, turn, dice);
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const uint32_t x = rim + dice.below(side - 2 * rim), y = rim + dice.below(side - 2 * rim);
        const uint32_t triangle = 2 * (y * side + x) + dice.below(2);
        const Vec3d target = aimed_point(mesh, triangle, aim, dice);
        const Vec3d above = up * (2 * dice.sign());
        const Vec3d back = normalize(above + dice.direction());
        rays.push_back(aimed_ray(target + back * request.knob, target, dice));
    }
    std::vector<Mesh> meshes;
    meshes.push_back(std::move(mesh));
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// Needles of length 2 along the axes, all close to the origin, so that floats can hold their
/// width. Rays run in planes at right angles to the width, which floats can hold, too.
SceneQueries needles(const TrialRequest& request) {
    Dice dice(request.seed);
    const double width = 1 / request.knob;
    Mesh mesh;
    for (uint32_t i = 0; i < 48; ++i) {
        const int along = static_cast<int>(i % 3);
        for (const double x : {-1.0, 1.0, dice.between(-0.5, 0.5)}) {
            Vec3 p(dice.vector(width));
            p[along] = static_cast<float>(x);
            mesh.positions.push_back(p);
        }
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const int thin = static_cast<int>(dice.below(3));
        const Vec3d target = aimed_point(mesh, i % 4 < 2 ? Target::edge : Target::inside, dice);
        Vec3d origin = dice.direction(1, 3);
        origin[thin] = target[thin];
        rays.push_back(aimed_ray(origin, target, dice));
    }
    std::vector<Mesh> meshes;
    meshes.push_back(std::move(mesh));
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// A patch without bumps: in the plane z = 0, or turned, about `place`.
Mesh flat_patch(uint32_t side, bool turned, const Vec3d& place, Dice& dice) {
    Mat4d turn = turned ? random_rotation(dice) : Mat4d();
    turn[3][0] = place.x, turn[3][1] = place.y, turn[3][2] = place.z;
    return bumpy_patch(side, 0, turn, dice);
}

/// The plane z = 0, where floats can hold any angle, and a plane across the axes, far beside it.
SceneQueries grazing(const TrialRequest& request) {
    Dice dice(request.seed);
    std::vector<Mesh> meshes;
    meshes.push_back(flat_patch(12, false, {0, 0, 0}, dice));
    meshes.push_back(flat_patch(12, true, {100, 0, 0}, dice));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Mesh& mesh = meshes[i % 2];
        const auto& [a, b, c] = mesh.triangles[0];
        const Vec3d x = normalize(Vec3d(mesh.positions[b]) - Vec3d(mesh.positions[a]));
        const Vec3d across = Vec3d(mesh.positions[c]) - Vec3d(mesh.positions[a]);
        const Vec3d z = normalize(cross(x, across)), y = cross(z, x);
        const Vec3d target = aimed_point(mesh, i % 4 < 2 ? Target::edge : Target::inside, dice);
        const double turn = dice.between(0, 2 * M_PI), height = 1 / request.knob;
        const Vec3d along = x * std::cos(turn) + y * std::sin(turn);
        const Vec3d back = (along + z * height) * dice.between(1, 20);
        rays.push_back(aimed_ray(target + back, target, dice));
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// Rays from within a closed mesh, at its edges, its vertices and anything between.
Ray ray_from_within(const Mesh& mesh, const Vec3d& centre, double size, size_t i, Dice& dice) {
    const Vec3d origin = centre + dice.vector(0.3 * size);
    const Vec3d target = aimed_point(mesh, static_cast<Target>(i % 3), dice);
    return aimed_ray(origin, target, dice);
}

/// A closed mesh of size `scale`; directions of about the same length, 1e-12 and 1e12 times that
/// (as far as floats reach).
SceneQueries scaled(const TrialRequest& request, double scale) {
    Dice dice(request.seed);
    std::vector<Mesh> meshes;
    meshes.push_back(closed_globe(8, scale_and_offset(Vec3d(scale, scale, scale), {0, 0, 0})));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        Ray ray = ray_from_within(meshes[0], {0, 0, 0}, scale, i, dice);
        const double length = Vec3d(ray.direction).length();
        const double stretch = std::pow(10, 12 * (dice.below(3) - 1.0));
        ray.direction =
            Vec3(Vec3d(ray.direction) * (std::clamp(length * stretch, 1e-30, 1e30) / length));
        rays.push_back(ray);
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

SceneQueries far_from_origin(const TrialRequest& request) {
    Dice dice(request.seed);
    const Vec3d centre = Vec3d(0.61, 0.64, -0.47) * request.knob;
    std::vector<Mesh> meshes;
    meshes.push_back(closed_globe(12, scale_and_offset({1, 1, 1}, centre)));
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i)
        rays.push_back(ray_from_within(meshes[0], centre, 1, i, dice));
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// Two patches 1/knob apart: along z about the origin, where floats can hold any gap, and across
/// the axes. Rays come from both sides.
SceneQueries near_coplanar(const TrialRequest& request) {
    Dice dice(request.seed);
    std::vector<Mesh> meshes;
    for (const bool turned : {false, true}) {
        const Mat4d turn = turned ? random_rotation(dice) : Mat4d();
        for (const double height : {0.0, 1 / request.knob}) {
            Mat4d place = turn;
            const Vec3d up = transform_vector(Vec3d(0, 0, height), turn);
            place[3][0] = up.x + 100.0 * turned, place[3][1] = up.y, place[3][2] = up.z;
            meshes.push_back(bumpy_patch(4, 0, place, dice));
        }
    }
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d target = aimed_point(meshes[i % 4], Target::inside, dice);
        rays.push_back(aimed_ray(target + dice.direction(1, 3), target, dice));
    }
    return {scene_of_meshes(std::move(meshes)), std::move(rays)};
}

/// A closed mesh squeezed by the condition number along one axis and by its root along another.
SceneQueries squeezed(const TrialRequest& request) {
    Dice dice(request.seed);
    const Mesh globe = closed_globe(8, Mat4d());
    const Vec3d scale(1, 1 / std::sqrt(request.knob), 1 / request.knob);
    Mat4d matrix = random_rotation(dice) * scale_and_offset(scale, {0, 0, 0});
    matrix = matrix * random_rotation(dice) * scale_and_offset({1, 1, 1}, dice.vector(1));
    const Mat4d placed{Mat4(matrix)};
    std::vector<Ray> rays;
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d origin = dice.vector(0.3);
        const Vec3d target = aimed_point(globe, static_cast<Target>(i % 3), dice);
        rays.push_back(
            aimed_ray(transform_point(origin, placed), transform_point(target, placed), dice));
    }
    return {scene_of_meshes({globe}, {placed}), std::move(rays)};
}

}  // namespace

void add_triangle_families(std::vector<Family>& families) {
    const auto add = [&](std::string name, std::string title, std::string knob,
                         std::vector<KnobValue> values, auto maker) {
        families.push_back({std::move(name), std::move(title), std::move(knob), std::move(values),
                            scene_trial_methods(), [maker](const TrialRequest& request) {
                                return make_scene_trial(maker(request));
                            }});
    };
    const auto distances = powers(10, 0, 6);
    add("T1e", "rays aimed at edges of a bumpy patch", "distance / edge length", distances,
        [](const TrialRequest& r) { return distant_patch(r, Target::edge); });
    add("T1v", "rays aimed at vertices of a bumpy patch", "distance / edge length", distances,
        [](const TrialRequest& r) { return distant_patch(r, Target::vertex); });
    add("T2", "needles", "length / width", powers(10, 0, 12, 2), needles);
    add("T3", "grazing rays", "1 / angle", powers(10, 0, 9), grazing);
    add("T4s", "small sizes, directions of all lengths", "1 / size", powers(10, 0, 18, 3),
        [](const TrialRequest& r) { return scaled(r, 1 / r.knob); });
    add("T4l", "large sizes, directions of all lengths", "size", powers(10, 0, 18, 3),
        [](const TrialRequest& r) { return scaled(r, r.knob); });
    auto offsets = powers(10, 1, 7);
    offsets.insert(offsets.begin(), KnobValue{0});
    add("T5", "closed meshes far from the origin", "offset / size", offsets, far_from_origin);
    add("T6", "surfaces close behind each other", "size / gap", powers(10, 0, 12, 2),
        near_coplanar);
    std::vector<KnobValue> cases;
    for (const std::string_view label : axis_aligned_cases())
        cases.push_back({static_cast<double>(cases.size()), std::string(label)});
    add("T7", "what is aligned with the axes, zero or denormal", "case", cases,
        [](const TrialRequest& r) {
            return axis_aligned(static_cast<size_t>(r.knob), r.rays, r.seed);
        });
    add("X1", "instances squeezed by their matrix", "condition of the matrix", powers(10, 0, 8),
        squeezed);
}

}  // namespace sightline
