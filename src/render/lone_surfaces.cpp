#include "render/lone_surfaces.h"

#include "scene/shape_bounds.h"
#include "shade/hit_geometry.h"

#include <algorithm>
#include <array>
#include <bit>

namespace sightline {
namespace {

// A record holds, from the top: the surface's id in 48 bits; the exponent of a float, the surface's
// reach, or 0; the number of times it was asked about, or `judged`.
constexpr uint64_t judged = 255;
// Judging costs several searches, and may be in vain: by then, that is little.
constexpr uint64_t patience = 32;
constexpr size_t most_records = size_t{1} << 16;
constexpr size_t most_nearby = 64;

// What lies nearer to an edge, in barycentric coordinates, is not judged: neighbours lie there.
constexpr float border = 0x1p-8f;
// What is judged around a shape, as a share of its size.
constexpr float clearance = 0x1p-8f;

constexpr double infinity = std::numeric_limits<double>::infinity();

using Triangle = std::array<Vec3d, 3>;

// A convex polygon: the part of a triangle that lies within a slab.
struct Polygon {
    std::array<Vec3d, 8> points;  // x and y as barycentric coordinates, z as height
    size_t count = 0;

    void add(const Vec3d& p) { points[count++] = p; }
};

Triangle world_triangle(const Scene& scene, const SurfaceId& id) {
    const Mesh& mesh = scene.meshes[id.geometry];
    const Instance& instance = scene.instances[id.instance];
    Triangle result;
    for (size_t i = 0; i < 3; ++i) {
        const Vec3d p(mesh.positions[mesh.triangles[id.primitive][i]]);
        result[i] = instance.baked ? p : p * Mat4d(instance.object_to_world);
    }
    return result;
}

Box3 world_box(const Triangle& triangle) {
    Box3 box;
    for (const Vec3d& p : triangle) box.extendBy(Vec3(p));
    return box;
}

Box3 world_box(const Scene& scene, const SurfaceId& id) {
    if (scene.is_mesh(id.geometry)) return world_box(world_triangle(scene, id));
    const Instance& instance = scene.instances[id.instance];
    const Box3 box = shape_bounds(scene.shape(id.geometry));
    return instance.baked ? box : transformed_box(box, Mat4d(instance.object_to_world));
}

Box3 grown(const Box3& box, float by) { return {box.min - Vec3(by), box.max + Vec3(by)}; }

// A bound of the position errors of hits on a triangle, which are convex functions of the place.
double largest_error(const Scene& scene, const SurfaceId& id) {
    double largest = 0;
    for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}) {
        const Hit corner{0, uv.x, uv.y, id.primitive, id.geometry, id.instance};
        const HitGeometry g = hit_geometry(scene, corner, nullptr, false);
        largest = std::max(largest, static_cast<double>(g.position_error.length()));
    }
    return largest;
}

// The coordinates that Polygon has, for a triangle.
struct FlatFrame {
    explicit FlatFrame(const Triangle& triangle) : origin(triangle[0]) {
        const Vec3d e1 = triangle[1] - origin, e2 = triangle[2] - origin, n = cross(e1, e2);
        const double n2 = dot(n, n);
        to_u = cross(e2, n) / n2, to_v = cross(n, e1) / n2, to_height = n / std::sqrt(n2);
    }

    Polygon polygon(const Triangle& other) const {
        Polygon result;
        for (const Vec3d& p : other) {
            const Vec3d q = p - origin;
            result.add({dot(q, to_u), dot(q, to_v), dot(q, to_height)});
        }
        return result;
    }

    Vec3d origin, to_u, to_v, to_height;
};

// Cuts away what is above the height, or below it.
Polygon cut(const Polygon& polygon, double height, bool above) {
    const auto outside = [&](const Vec3d& p) { return above ? p.z - height : height - p.z; };
    Polygon result;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Vec3d &p = polygon.points[i], &q = polygon.points[(i + 1) % polygon.count];
        const double at_p = outside(p), at_q = outside(q);
        if (at_p <= 0) result.add(p);
        if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0))
            result.add(p + (q - p) * (at_p / (at_p - at_q)));
    }
    return result;
}

// The part of the triangle itself that is judged, in the coordinates of a polygon.
constexpr auto inner_border = static_cast<double>(border);
const std::array<Vec3d, 3> inner = {Vec3d(inner_border, inner_border, 0),
                                    Vec3d(1 - 2 * inner_border, inner_border, 0),
                                    Vec3d(inner_border, 1 - 2 * inner_border, 0)};

// True if all of the polygon lies behind one edge of the inner part.
bool lies_beyond_an_edge(const Polygon& polygon) {
    double u = -infinity, v = -infinity, w = -infinity;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Vec3d& p = polygon.points[i];
        u = std::max(u, p.x), v = std::max(v, p.y), w = std::max(w, 1 - p.x - p.y);
    }
    return std::min({u, v, w}) < inner_border;
}

// True if, seen from above, an edge of the polygon or of the inner part lies between them.
bool is_separate(const Polygon& polygon) {
    if (lies_beyond_an_edge(polygon)) return true;
    for (size_t i = 0; i < polygon.count; ++i) {
        const Vec3d &p = polygon.points[i], edge = polygon.points[(i + 1) % polygon.count] - p;
        const auto extent = [&](std::span<const Vec3d> points) {
            double low = infinity, high = -infinity;
            for (const Vec3d& q : points) {
                const double side = edge.x * (q.y - p.y) - edge.y * (q.x - p.x);
                low = std::min(low, side), high = std::max(high, side);
            }
            return std::pair(low, high);
        };
        const auto own = extent({polygon.points.data(), polygon.count}), other = extent(inner);
        if (other.first > own.second || other.second < own.first) return true;
    }
    return false;
}

}  // namespace

LoneSurfaces::LoneSurfaces(const Scene& scene, const Intersector& intersector)
    : scene_(scene),
      intersector_(intersector),
      offsets_(scene.meshes.size() + scene.shapes.size()) {
    std::vector<uint64_t> sizes;
    for (const Group& group : scene.groups) {
        uint64_t size = 0;
        for (const uint32_t mesh : group.meshes) {
            offsets_[mesh] = static_cast<uint32_t>(size);
            size += scene.meshes[mesh].triangles.size();
        }
        for (const uint32_t shape : group.shapes)
            offsets_[scene.meshes.size() + shape] = static_cast<uint32_t>(size++);
        sizes.push_back(size);
    }
    uint64_t total = 0;
    for (const Instance& instance : scene.instances) {
        first_ids_.push_back(total);
        total += sizes[instance.group];
    }
    records_ = std::vector<std::atomic<uint64_t>>(
        std::bit_ceil(std::clamp<size_t>(total, 1, most_records)));
    mask_ = records_.size() - 1;
    // No surface has this id.
    for (std::atomic<uint64_t>& record : records_) record = ~uint64_t{0};
}

bool LoneSurfaces::is_lone(const Hit& hit, float distance) const {
    const bool on_triangle = scene_.is_mesh(hit.geometry);
    // From a hit to what is not judged: a share of the smallest height, and a little less.
    const float within =
        on_triangle ? std::min({hit.u, hit.v, 1 - hit.u - hit.v}) - 1.01f * border : 1;
    if (!(within > 0)) return false;
    const uint64_t id = first_ids_[hit.instance] + offsets_[hit.geometry] + hit.primitive;
    std::atomic<uint64_t>& record = records_[id & mask_];
    uint64_t value = record.load(std::memory_order_relaxed);
    if (value >> 16 != id) value = id << 16;
    if ((value & 255) != judged) {
        ++value;
        if ((value & 255) > patience) {
            const float reach = on_triangle ? judge_triangle(hit) : judge_shape(hit);
            value = id << 16 | uint64_t{std::bit_cast<uint32_t>(reach) >> 23} << 8 | judged;
        }
        record.store(value, std::memory_order_relaxed);
    }
    const auto reach = std::bit_cast<float>(static_cast<uint32_t>(value >> 8 & 255) << 23);
    return distance <= reach * within;
}

// The smallest height, if nothing else meets the triangle within `border`; else 0.
float LoneSurfaces::judge_triangle(const Hit& hit) const {
    const SurfaceId id = surface_of(hit);
    const Triangle corners = world_triangle(scene_, id);
    const Vec3d e1 = corners[1] - corners[0], e2 = corners[2] - corners[0];
    const Vec3d normal = cross(e1, e2);
    const double area2 = normal.length();
    const double longest = std::max({e1.length(), e2.length(), (e2 - e1).length()});
    // The normals of slivers have errors of their own.
    if (!(area2 > 0x1p-6 * longest * longest)) return 0;
    const double height = area2 / longest;
    // No point of the triangle is farther from an edge, so that no distance that is_lone allows is
    // longer, either.
    const Box3 box = grown(world_box(corners), static_cast<float>(height / 3));
    std::vector<SurfaceId> others;
    if (!intersector_.nearby(box.center(), box.size().length() / 2, most_nearby, others)) return 0;
    const double error = largest_error(scene_, id);
    const FlatFrame frame(corners);
    const auto meets = [&](const SurfaceId& other) {
        if (other == id) return false;
        if (!scene_.is_mesh(other.geometry)) return box.intersects(world_box(scene_, other));
        Polygon part = frame.polygon(world_triangle(scene_, other));
        if (lies_beyond_an_edge(part)) return false;
        // Twice the bounds, for the places themselves have these errors, and some more, also for
        // the error of the normal.
        const double slab = 3 * (error + largest_error(scene_, other)) + 0x1p-14 * height;
        part = cut(cut(part, slab, true), -slab, false);
        return part.count > 0 && !is_separate(part);
    };
    return std::ranges::any_of(others, meets) ? 0 : static_cast<float>(height);
}

// Of a shape, engines report one hit of a short segment, so that it coincides with others alone.
float LoneSurfaces::judge_shape(const Hit& hit) const {
    const SurfaceId id = surface_of(hit);
    const Box3 own = world_box(scene_, id);
    const Vec3 size = own.size();
    const float distance = clearance * std::max({size.x, size.y, size.z});
    const Box3 box = grown(own, distance);
    std::vector<SurfaceId> others;
    if (!intersector_.nearby(box.center(), box.size().length() / 2, most_nearby, others)) return 0;
    const auto comes_near = [&](const SurfaceId& other) {
        return other != id && box.intersects(world_box(scene_, other));
    };
    return std::ranges::any_of(others, comes_near) ? 0 : distance;
}

}  // namespace sightline
