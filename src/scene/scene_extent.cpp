#include "scene/scene_extent.h"

#include "core/parallel.h"
#include "scene/shape_bounds.h"
#include "scene/shape_support.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline {
namespace {

constexpr size_t run_length = 1024;  // vertices in a box

size_t run_count(const Mesh& mesh) { return (mesh.positions.size() + run_length - 1) / run_length; }

std::span<const Vec3> run_of(const Mesh& mesh, size_t run) {
    const size_t first = run * run_length;
    return {mesh.positions.data() + first, std::min(run_length, mesh.positions.size() - first)};
}

// Box3::extendBy has a branch for each number.
Box3 box_of(std::span<const Vec3> points) {
    Vec3 low = points[0], high = points[0];
    for (const Vec3& p : points) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return {low, high};
}

// No point of the box reaches farther than the farthest of the box around it in the world.
double bound(const Reach& reach, const Box3& box, const Mat4d& to_world) {
    const Vec3d low(box.min), high(box.max), half = (high - low) * 0.5;
    const Vec3d centre = transform_point((low + high) * 0.5, to_world);
    Vec3d room(0, 0, 0);
    for (int axis = 0; axis < 3; ++axis)
        for (int row = 0; row < 3; ++row) room[axis] += half[row] * std::abs(to_world[row][axis]);
    const Vec3d& d = reach.direction;
    const double up = centre.y * d.y + room.y * std::abs(d.y);
    if (!reach.axis)
        return up + centre.x * d.x + room.x * std::abs(d.x) + centre.z * d.z +
               room.z * std::abs(d.z);
    const Vec3d& axis = *reach.axis;
    const double across = std::abs(centre.x - axis.x) + room.x;
    const double along = std::abs(centre.z - axis.z) + room.z;
    return up + axis.x * d.x + axis.z * d.z +
           std::sqrt((d.x * d.x + d.z * d.z) * (across * across + along * along));
}

// Searches those of `count` things whose bound exceeds the best value so far: first the one with
// the largest bound, after which few others are left.
template <class BoundOf, class Search>
void search_best_first(size_t count, const BoundOf& bound_of, const double& best,
                       const Search& search) {
    std::vector<double> bounds(count);
    for (size_t i = 0; i < count; ++i) bounds[i] = bound_of(i);
    const auto first =
        static_cast<size_t>(std::max_element(bounds.begin(), bounds.end()) - bounds.begin());
    if (count > 0 && bounds[first] > best) search(first);
    for (size_t i = 0; i < count; ++i)
        if (i != first && bounds[i] > best) search(i);
}

}  // namespace

double Reach::operator()(const Vec3d& p) const {
    if (!axis) return dot(p, direction);
    return axis->x * direction.x + p.y * direction.y + axis->z * direction.z +
           std::hypot(direction.x, direction.z) * std::hypot(p.x - axis->x, p.z - axis->z);
}

Vec3d Reach::point(const Vec3d& p) const {
    if (!axis) return p;
    const Vec3d outwards = normalize(Vec3d(direction.x, 0, direction.z));
    return Vec3d(axis->x, p.y, axis->z) + outwards * std::hypot(p.x - axis->x, p.z - axis->z);
}

bool is_invisible(const Material& material) {
    const float alpha = material.base_color_factor.w;  // a texture and colours only lower it
    return (material.alpha_mode == AlphaMode::blend && alpha <= 0) ||
           (material.alpha_mode == AlphaMode::mask && alpha < material.alpha_cutoff);
}

SceneExtent::SceneExtent(const Scene& scene)
    : scene_(scene), first_boxes_(scene.meshes.size(), none) {
    add_parts(true);
    if (parts_.empty()) add_parts(false);
    add_boxes();
}

void SceneExtent::add_parts(bool visible) {
    for (const Instance& instance : scene_.instances) {
        const Mat4d to_world(instance.object_to_world);
        const Group& group = scene_.groups[instance.group];
        for (const uint32_t m : group.meshes)
            if (!scene_.meshes[m].positions.empty() &&
                is_invisible(scene_.materials[scene_.meshes[m].material]) != visible) {
                first_boxes_[m] = 0;
                parts_.push_back({m, to_world, {}});
            }
        for (const uint32_t s : group.shapes)
            if (!is_endless(scene_.shapes[s]) &&
                is_invisible(scene_.materials[scene_.shapes[s].material]) != visible)
                parts_.push_back({static_cast<uint32_t>(scene_.meshes.size()) + s, to_world,
                                  shape_bounds(scene_.shapes[s])});
    }
}

void SceneExtent::add_boxes() {
    struct Run {
        uint32_t mesh;
        size_t run;
    };
    std::vector<Run> runs;
    for (uint32_t m = 0; m < scene_.meshes.size(); ++m) {
        if (first_boxes_[m] == none) continue;
        first_boxes_[m] = static_cast<uint32_t>(runs.size());
        for (size_t i = 0; i < run_count(scene_.meshes[m]); ++i) runs.push_back({m, i});
    }
    boxes_.resize(runs.size());
    constexpr size_t runs_at_once = 64;
    const auto find_boxes = [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            boxes_[i] = box_of(run_of(scene_.meshes[runs[i].mesh], runs[i].run));
    };
    parallel_ranges(runs.size(), find_boxes, runs_at_once);
    std::vector<Box3> mesh_boxes(scene_.meshes.size());
    for (size_t i = 0; i < runs.size(); ++i) mesh_boxes[runs[i].mesh].extendBy(boxes_[i]);
    for (Part& part : parts_)
        if (scene_.is_mesh(part.geometry)) part.box = mesh_boxes[part.geometry];
}

Vec3d SceneExtent::farthest(const Reach& reach) const {
    double best = -std::numeric_limits<double>::infinity();
    Vec3d point(0, 0, 0);
    const auto bound_of = [&](size_t i) { return bound(reach, parts_[i].box, parts_[i].to_world); };
    search_best_first(parts_.size(), bound_of, best, [&](size_t i) {
        scene_.is_mesh(parts_[i].geometry) ? search_mesh(parts_[i], reach, best, point)
                                           : search_shape(parts_[i], reach, best, point);
    });
    return reach.point(point);
}

void SceneExtent::search_mesh(const Part& part, const Reach& reach, double& best,
                              Vec3d& point) const {
    const Mesh& mesh = scene_.meshes[part.geometry];
    const auto bound_of = [&](size_t run) {
        return bound(reach, boxes_[first_boxes_[part.geometry] + run], part.to_world);
    };
    search_best_first(run_count(mesh), bound_of, best, [&](size_t run) {
        for (const Vec3& vertex : run_of(mesh, run)) {
            const Vec3d p = transform_point(Vec3d(vertex), part.to_world);
            if (const double value = reach(p); value > best) {
                best = value;
                point = p;
            }
        }
    });
}

void SceneExtent::search_shape(const Part& part, const Reach& reach, double& best,
                               Vec3d& point) const {
    const Shape& shape = scene_.shape(part.geometry);
    const Mat4d to_world = shape.to_object * part.to_world;
    const auto try_direction = [&](const Vec3d& d) {
        const auto component = [&](const double(&row)[4]) {
            return row[0] * d.x + row[1] * d.y + row[2] * d.z;
        };
        const Vec3d in_shape(component(to_world.x[0]), component(to_world.x[1]),
                             component(to_world.x[2]));
        const Vec3d p = transform_point(farthest_point(shape, in_shape), to_world);
        if (const double value = reach(p); value > best) {
            best = value;
            point = p;
        }
    };
    if (!reach.axis) return try_direction(reach.direction);
    // While the shape turns, it meets the direction from all sides; between two of these, it
    // reaches at most 1 − cos(180°/256) = 8e-5 of its size farther.
    constexpr int sides = 256;
    const double level = std::hypot(reach.direction.x, reach.direction.z);
    for (int i = 0; i < sides; ++i) {
        const double phi = 2 * M_PI * i / sides;
        try_direction({level * std::cos(phi), reach.direction.y, level * std::sin(phi)});
    }
}

}  // namespace sightline
