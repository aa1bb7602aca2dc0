#include "shade/hit_geometry.h"

#include "intersect/shape_surface.h"
#include "scene/shape_bounds.h"

#include <algorithm>
#include <span>

namespace sightline {
namespace {

/// Bound of the relative error of n float operations (Higham's γ; pbrt, 4th ed., section 6.8.1).
constexpr float gamma(int n) {
    constexpr float u = std::numeric_limits<float>::epsilon() / 2;
    const float nu = static_cast<float>(n) * u;
    return nu / (1 - nu);
}

Vec3 abs(const Vec3& v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }

Vec3 max(const Vec3& a, const Vec3& b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// |v|·|M|, the linear part only.
Vec3 transform_abs(const Vec3& v, const Mat4& m) {
    Vec3 r;
    for (int j = 0; j < 3; ++j) {
        r[j] = std::fabs(v.x * m[0][j]) + std::fabs(v.y * m[1][j]) + std::fabs(v.z * m[2][j]);
    }
    return r;
}

Vec3 translation_abs(const Mat4& m) {
    return {std::fabs(m[3][0]), std::fabs(m[3][1]), std::fabs(m[3][2])};
}

/// Takes the point to world space. Its error grows by that of the transform (pbrt, 4th ed., section
/// 6.8.5) and by that of the inverse transform, which Embree applies to rays that start here.
void transform_to_world(HitGeometry& g) {
    const Mat4& m = g.instance->object_to_world;
    const Mat4& inverse = g.instance->world_to_object;
    const Vec3 p = g.position, e = g.position_error;
    g.position = transform_point(p, m);
    const Vec3 back = transform_abs(g.position, inverse) + translation_abs(inverse);
    g.position_error = transform_abs(e, m) * (1 + gamma(3)) +
                       (transform_abs(p, m) + translation_abs(m)) * gamma(3) +
                       transform_abs(back, m) * gamma(4);
    g.edge1 = transform_vector(g.edge1, m);
    g.edge2 = transform_vector(g.edge2, m);
}

void set_mesh_hit(HitGeometry& g, const Mesh& mesh, const Hit& hit, bool needs_uv) {
    g.mesh = &mesh;
    g.corners = mesh.triangles[hit.primitive];
    g.weights[0] = 1 - hit.u - hit.v;
    g.weights[1] = hit.u;
    g.weights[2] = hit.v;
    const auto [i0, i1, i2] = g.corners;
    const Vec3 &p0 = mesh.positions[i0], &p1 = mesh.positions[i1], &p2 = mesh.positions[i2];
    g.position = p0 * g.weights[0] + p1 * g.weights[1] + p2 * g.weights[2];
    // A bound of the interpolation would be as small as the terms. But engines also round the
    // differences between a ray's origin and the corners, by the largest of them: rays from points
    // beside a corner at the origin would hit the triangle again.
    g.position_error = max(max(abs(p0), abs(p1)), abs(p2)) * gamma(8);
    g.edge1 = p1 - p0;
    g.edge2 = p2 - p0;
    const bool baked = g.instance->baked;
    if (!baked) transform_to_world(g);

    const Vec3 n = cross(g.edge1, g.edge2);
    g.area2 = std::sqrt(dot(n, n));
    const float scale = g.area2 > 0 ? 1 / g.area2 : 0;
    g.outward = n * (g.instance->mirrored ? -scale : scale);
    g.normal = g.outward;
    if (!mesh.normals.empty()) {
        g.has_vertex_normals = true;
        Vec3 normal = mesh.normals[i0] * g.weights[0] + mesh.normals[i1] * g.weights[1] +
                      mesh.normals[i2] * g.weights[2];
        if (!baked) normal = transform_normal(normal, g.instance->world_to_object);
        const float length2 = dot(normal, normal);
        if (length2 > 1e-20f) g.normal = normal * (1 / std::sqrt(length2));
    }
    if (needs_uv) g.uv = g.texcoord(0);
}

void set_shape_hit(HitGeometry& g, const Shape& shape, const Hit& hit, const Ray& ray,
                   bool needs_uv) {
    g.shape = &shape;
    const bool baked = g.instance->baked;
    const Vec3d world = Vec3d(ray.origin) + Vec3d(ray.direction) * static_cast<double>(hit.t);
    const Vec3d near = baked ? world : world * Mat4d(g.instance->world_to_object);
    const ShapePoint point = shape_point(shape, near, needs_uv);
    g.position = Vec3(point.position);
    // One rounding of each coordinate; γ3 of the largest also covers the noise in double.
    const Vec3 size = abs(g.position);
    g.position_error = Vec3(std::max(max_component(size), 1e-30f) * gamma(3));
    g.edge1 = g.edge2 = Vec3(0);
    g.normal = Vec3(point.normal);
    g.shape_tangent = Vec3(point.tangent);
    if (!baked) {
        transform_to_world(g);
        g.normal = normalize(transform_normal(g.normal, g.instance->world_to_object));
        g.shape_tangent = normalize(transform_vector(g.shape_tangent, g.instance->object_to_world));
    }
    g.outward = g.normal;
    g.uv = point.uv;
}

/// The set's coordinates by vertex; empty if the mesh lacks it, also where it has a later one.
std::span<const Vec2> texcoords(const Mesh& mesh, uint32_t set) {
    if (set >= mesh.texcoords.size()) return {};
    return mesh.texcoords[set];
}

/// World-space length of one unit of the instance's object space, the mean of all directions.
float scale_of(const Instance& instance) {
    return instance.baked ? 1 : std::cbrt(std::fabs(instance.object_to_world.determinant()));
}

}  // namespace

HitGeometry hit_geometry(const Scene& scene, const Hit& hit, const Ray* ray, bool needs_uv) {
    HitGeometry g;
    g.instance = &scene.instances[hit.instance];
    if (scene.is_mesh(hit.geometry)) {
        set_mesh_hit(g, scene.meshes[hit.geometry], hit, needs_uv);
    } else {
        set_shape_hit(g, scene.shape(hit.geometry), hit, *ray, needs_uv);
    }
    return g;
}

Vec2 HitGeometry::texcoord(uint32_t set) const {
    if (shape) return uv;
    const std::span<const Vec2> t = texcoords(*mesh, set);
    if (t.empty()) return {0, 0};
    return t[corners[0]] * weights[0] + t[corners[1]] * weights[1] + t[corners[2]] * weights[2];
}

UvGradients HitGeometry::uv_gradients(uint32_t set) const {
    if (shape) {
        // As if u and v grew equally fast. A sphere's uv square covers πs² for a bounding cube of
        // side s.
        const float side = shape_bounds(*shape).size().length() * 0.577f * scale_of(*instance);
        const float uv_per_world = side < 1e6f ? 0.56f / std::max(side, 1e-30f) : 1;
        return {shape_tangent * uv_per_world, cross(shape_tangent, normal) * uv_per_world};
    }
    const std::span<const Vec2> t = texcoords(*mesh, set);
    if (t.empty() || !(area2 > 0)) return {};
    const Vec2 a = t[corners[1]] - t[corners[0]], b = t[corners[2]] - t[corners[0]];
    // The gradients of the barycentric weights of corners 1 and 2 are e2 × n and n × e1 over the
    // doubled area, where n is the normal of the triangle as its corners turn.
    const Vec3 n = outward * ((instance->mirrored ? -1 : 1) / area2);
    return {cross(edge2 * a.x - edge1 * b.x, n), cross(edge2 * a.y - edge1 * b.y, n)};
}

Vec4 HitGeometry::color() const {
    if (!mesh || mesh->colors.empty()) return {1, 1, 1, 1};
    const std::vector<Vec4>& c = mesh->colors;
    return c[corners[0]] * weights[0] + c[corners[1]] * weights[1] + c[corners[2]] * weights[2];
}

Vec4 HitGeometry::tangent_from_uv(uint32_t set, Vec2 across, Vec2 down) const {
    Vec3 t(0), up(0);
    if (shape) {
        // The inverse of the transform, as if u and v grew equally fast.
        const float turn = across.x * down.y - across.y * down.x < 0 ? -1.0f : 1.0f;
        const Vec3 plain_up = cross(normal, shape_tangent);
        t = (shape_tangent * down.y + plain_up * across.y) * turn;
        up = (shape_tangent * down.x + plain_up * across.x) * turn;
    } else if (const std::span<const Vec2> uvs = texcoords(*mesh, set); !uvs.empty()) {
        const auto edge = [&](int corner) {
            const Vec2 d = uvs[corners[corner]] - uvs[corners[0]];
            return across * d.x + down * d.y;
        };
        const Vec2 a = edge(1), b = edge(2);
        const float turn = a.x * b.y - a.y * b.x < 0 ? -1.0f : 1.0f;
        t = (edge1 * b.y - edge2 * a.y) * turn;
        up = (edge1 * b.x - edge2 * a.x) * turn;  // against growing v, which runs down
    }
    t = normalize(t - normal * dot(normal, t));
    if (!(dot(t, t) > 0.5f)) {  // no usable coordinates: any direction will do
        t = normalize(std::fabs(normal.x) < 0.7f ? cross(normal, Vec3(1, 0, 0))
                                                 : cross(normal, Vec3(0, 1, 0)));
    }
    return {t.x, t.y, t.z, dot(cross(normal, t), up) < 0 ? -1.0f : 1.0f};
}

Vec4 HitGeometry::own_tangent() const {
    if (!mesh || mesh->tangents.empty()) return Vec4(0);
    const std::vector<Vec4>& all = mesh->tangents;
    const Vec4 sum =
        all[corners[0]] * weights[0] + all[corners[1]] * weights[1] + all[corners[2]] * weights[2];
    Vec3 t(sum.x, sum.y, sum.z);
    float sign = all[corners[0]].w;
    if (!instance->baked) {
        t = transform_vector(t, instance->object_to_world);
        if (instance->mirrored) sign = -sign;
    }
    t = normalize(t - normal * dot(normal, t));
    return dot(t, t) > 0.5f ? Vec4(t.x, t.y, t.z, sign) : Vec4(0);
}

Vec4 HitGeometry::tangent(uint32_t set, Vec2 across, Vec2 down) const {
    // A transform that flattens the texture has no directions of its own.
    const bool flattens = across.x * down.y == across.y * down.x;
    const bool turns = !flattens && (across != Vec2(1, 0) || down != Vec2(0, 1));
    const Vec4 own = own_tangent();
    if (own.w == 0)
        return turns ? tangent_from_uv(set, across, down) : tangent_from_uv(set, {1, 0}, {0, 1});
    if (!turns) return own;
    // The transform turns the mesh's tangent as it turns that from the coordinates.
    const Vec4 before = tangent_from_uv(set, {1, 0}, {0, 1});
    const Vec4 after = tangent_from_uv(set, across, down);
    const Vec3 from(before.x, before.y, before.z), to(after.x, after.y, after.z);
    Vec3 t(own.x, own.y, own.z);
    t = t * dot(from, to) + cross(normal, t) * dot(cross(normal, from), to);
    return {t.x, t.y, t.z, own.w * before.w * after.w};
}

Vec3 HitGeometry::shadow_terminator_offset(const Vec3& facing) const {
    if (!has_vertex_normals) return Vec3(0);
    // Computed in object space: only the height of the smooth surface over the triangle matters.
    const bool baked = instance->baked;
    const Vec3 side = baked ? facing : transform_normal(facing, instance->object_to_world);
    Vec3 at(0);
    for (int i = 0; i < 3; ++i) at += mesh->positions[corners[i]] * weights[i];
    Vec3 sum(0);
    for (int i = 0; i < 3; ++i) {
        const Vec3& n = mesh->normals[corners[i]];
        const float height = dot(at - mesh->positions[corners[i]], n);
        const bool below = dot(n, side) >= 0 ? height < 0 : height > 0;
        if (below) sum -= n * (height * weights[i]);
    }
    return baked ? sum : transform_vector(sum, instance->object_to_world);
}

}  // namespace sightline
