#include "intersect/few_shapes.h"

#include "core/vectorise.h"
#include "intersect/ray_rules.h"
#include "intersect/ray_soa.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace sightline {
namespace {

constexpr size_t max_primitives = 8;

enum class Kind { sphere, plane, triangle };

/// A primitive in world space, and the indices of a hit on it.
struct Primitive {
    Kind kind;
    bool translucent;
    Hit hit;                        // only its three indices
    Mat4d to_shape;                 // sphere, plane
    double radius2 = 0;             // sphere
    double half_x = 0, half_z = 0;  // plane
    Vec3d a, b, c, normal;          // triangle; normal = (b − a) × (c − a)
};

using Lanes = std::array<double, soa_width>;
constexpr double endless = std::numeric_limits<double>::infinity();

/// Sixteen rays as arrays, and the closest hit of each: its t and the primitive's index, or −1.
struct alignas(64) Block {
    std::array<std::array<float, soa_width>, 8> floats;  // the rays in single precision
    Lanes ox, oy, oz, dx, dy, dz, tnear, tfar;
    Lanes t, primitive;
    std::array<float, soa_width> rounded;  // t in single precision, within the segment

    RaySoA soa() {
        return {floats[0].data(), floats[1].data(), floats[2].data(), floats[3].data(),
                floats[4].data(), floats[5].data(), floats[6].data(), floats[7].data()};
    }
};

// The loops below, over the first `count` rays of a block, have no branches and one store, so that
// compilers turn them into vector code.

/// && without a branch.
[[gnu::always_inline]] inline bool both(bool a, bool b) { return (int(a) & int(b)) != 0; }

/// `t` if the ray hits within its segment, else endless.
[[gnu::always_inline]] inline double t_if_hit(const Block& b, size_t i, bool hit, double t) {
    return both(hit, both(t >= b.tnear[i], t <= b.tfar[i])) ? t : endless;
}

/// A ray in the shape's space.
struct ObjectRay {
    double ox, oy, oz, dx, dy, dz;
};
[[gnu::always_inline]] inline ObjectRay object_ray(const Block& b, size_t i, const Mat4d& m) {
    return {b.ox[i] * m[0][0] + b.oy[i] * m[1][0] + b.oz[i] * m[2][0] + m[3][0],
            b.ox[i] * m[0][1] + b.oy[i] * m[1][1] + b.oz[i] * m[2][1] + m[3][1],
            b.ox[i] * m[0][2] + b.oy[i] * m[1][2] + b.oz[i] * m[2][2] + m[3][2],
            b.dx[i] * m[0][0] + b.dy[i] * m[1][0] + b.dz[i] * m[2][0],
            b.dx[i] * m[0][1] + b.dy[i] * m[1][1] + b.dz[i] * m[2][1],
            b.dx[i] * m[0][2] + b.dy[i] * m[1][2] + b.dz[i] * m[2][2]};
}

template <size_t count>
[[gnu::always_inline]] inline void intersect_sphere(const Primitive& p, const Block& block,
                                                    Lanes& out) {
    for (size_t i = 0; i < count; ++i) {
        const ObjectRay r = object_ray(block, i, p.to_shape);
        const double dd = r.dx * r.dx + r.dy * r.dy + r.dz * r.dz;
        // Computed at the ray's closest point to the centre, the discriminant does not lose digits
        // to the distance.
        const double s = -(r.ox * r.dx + r.oy * r.dy + r.oz * r.dz) / dd;
        const double cx = r.ox + s * r.dx, cy = r.oy + s * r.dy, cz = r.oz + s * r.dz;
        const double rest = p.radius2 - (cx * cx + cy * cy + cz * cz);
        const double half = std::sqrt(std::fabs(rest) / dd);
        const double t = s - half >= block.tnear[i] ? s - half : s + half;
        out[i] = t_if_hit(block, i, rest >= 0, t);
    }
}

template <size_t count>
[[gnu::always_inline]] inline void intersect_plane(const Primitive& p, const Block& block,
                                                   Lanes& out) {
    for (size_t i = 0; i < count; ++i) {
        const ObjectRay r = object_ray(block, i, p.to_shape);
        const double t = -r.oy / r.dy;
        const bool inside =
            both(std::fabs(r.ox + t * r.dx) <= p.half_x, std::fabs(r.oz + t * r.dz) <= p.half_z);
        out[i] = t_if_hit(block, i, inside, t);
    }
}

/// The volumes that a ray spans with the edges opposite a, b and c. Neighbours compute the same
/// number, negated, for a common edge, so no ray passes between them.
struct Volumes {
    double a, b, c;
};
[[gnu::always_inline]] inline Volumes edge_volumes(const Primitive& p, const Block& r, size_t i) {
    const double ax = p.a.x - r.ox[i], ay = p.a.y - r.oy[i], az = p.a.z - r.oz[i];
    const double bx = p.b.x - r.ox[i], by = p.b.y - r.oy[i], bz = p.b.z - r.oz[i];
    const double cx = p.c.x - r.ox[i], cy = p.c.y - r.oy[i], cz = p.c.z - r.oz[i];
    const double dx = r.dx[i], dy = r.dy[i], dz = r.dz[i];
    return {dx * (by * cz - bz * cy) + dy * (bz * cx - bx * cz) + dz * (bx * cy - by * cx),
            dx * (cy * az - cz * ay) + dy * (cz * ax - cx * az) + dz * (cx * ay - cy * ax),
            dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)};
}

template <size_t count>
[[gnu::always_inline]] inline void intersect_triangle(const Primitive& p, const Block& block,
                                                      Lanes& out) {
    for (size_t i = 0; i < count; ++i) {
        const Volumes w = edge_volumes(p, block, i);
        const double lowest = w.a < w.b ? (w.a < w.c ? w.a : w.c) : (w.b < w.c ? w.b : w.c);
        const double highest = w.a > w.b ? (w.a > w.c ? w.a : w.c) : (w.b > w.c ? w.b : w.c);
        const double to_plane = (p.a.x - block.ox[i]) * p.normal.x +
                                (p.a.y - block.oy[i]) * p.normal.y +
                                (p.a.z - block.oz[i]) * p.normal.z;
        const double along =
            block.dx[i] * p.normal.x + block.dy[i] * p.normal.y + block.dz[i] * p.normal.z;
        const bool mixed = both(highest > 0, lowest < 0);
        const bool inside = both(!mixed, lowest != highest);
        out[i] = t_if_hit(block, i, inside, to_plane / along);
    }
}

template <size_t count>
[[gnu::always_inline]] inline void widen(Block& block) {
    const RaySoA soa = block.soa();
    for (size_t i = 0; i < count; ++i) {
        const Ray ray = soa[i];
        block.ox[i] = double(ray.origin.x);
        block.oy[i] = double(ray.origin.y);
        block.oz[i] = double(ray.origin.z);
        block.dx[i] = double(ray.direction.x);
        block.dy[i] = double(ray.direction.y);
        block.dz[i] = double(ray.direction.z);
        block.tnear[i] = double(next_after_tnear(ray.tnear));
        block.tfar[i] = is_valid(ray) ? double(ray.tfar) : -1.0;
        block.t[i] = endless;
        block.primitive[i] = -1;
    }
}

template <size_t count>
[[gnu::always_inline]] inline void intersect_all(std::span<const Primitive> primitives,
                                                 Visible visible, Block& block) {
    widen<count>(block);
    for (size_t k = 0; k < primitives.size(); ++k) {
        const Primitive p = primitives[k];  // NOLINT(performance-unnecessary-copy-initialization)
        if (visible == (p.translucent ? Visible::opaque : Visible::translucent)) continue;
        alignas(64) Lanes t;
        if (p.kind == Kind::sphere)
            intersect_sphere<count>(p, block, t);
        else if (p.kind == Kind::plane)
            intersect_plane<count>(p, block, t);
        else
            intersect_triangle<count>(p, block, t);
        const auto index = static_cast<double>(k);
        for (size_t i = 0; i < count; ++i)
            block.primitive[i] = t[i] < block.t[i] ? index : block.primitive[i];
        for (size_t i = 0; i < count; ++i) block.t[i] = t[i] < block.t[i] ? t[i] : block.t[i];
    }
    for (size_t i = 0; i < count; ++i)
        block.rounded[i] = std::clamp(static_cast<float>(block.t[i]),
                                      static_cast<float>(block.tnear[i]), block.soa().tfar[i]);
}

class FewShapes final : public Intersector {
  public:
    explicit FewShapes(std::vector<Primitive> primitives) : primitives_(std::move(primitives)) {}

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible visible) const override {
        assert(rays.size() == hits.size());
        for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
            const auto part = rays.subspan(begin, std::min(soa_width, rays.size() - begin));
            Block block;
            to_soa(part, block.soa());
            intersect_(primitives_, visible, block);
            for (size_t i = 0; i < part.size(); ++i) hits[begin + i] = hit(block, i);
        }
    }

    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence,
                  Visible visible) const override {
        assert(rays.size() == blocked.size());
        for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
            const auto part = rays.subspan(begin, std::min(soa_width, rays.size() - begin));
            Block block;
            to_soa(part, block.soa());
            intersect_(primitives_, visible, block);
            for (size_t i = 0; i < part.size(); ++i) blocked[begin + i] = block.primitive[i] >= 0;
        }
    }

    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible visible) const override {
        for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
            const auto part = rays.subspan(begin, std::min(soa_width, rays.size() - begin));
            Block block;
            to_soa(part, block.soa());
            for (size_t k = 0; k < primitives_.size(); ++k) {
                intersect_(std::span(primitives_).subspan(k, 1), visible, block);
                for (size_t i = 0; i < part.size(); ++i)
                    if (const Hit found = hit(primitives_[k], block, i))
                        hits.push_back({static_cast<uint32_t>(begin + i), found});
            }
        }
    }

    bool nearby(const Vec3&, float, size_t most, std::vector<SurfaceId>& found) const override {
        for (const Primitive& p : primitives_) found.push_back(surface_of(p.hit));
        return primitives_.size() <= most;
    }

    std::string description() const override { return "few shapes, one after the other in double"; }

    size_t memory() const override { return primitives_.capacity() * sizeof(Primitive); }

  private:
    Hit hit(const Block& block, size_t i) const {
        if (block.primitive[i] < 0) return {};
        return hit(primitives_[static_cast<size_t>(block.primitive[i])], block, i);
    }

    /// The block's hit `i`, which is on `p`.
    static Hit hit(const Primitive& p, const Block& block, size_t i) {
        if (block.primitive[i] < 0) return {};
        Hit hit = p.hit;
        hit.t = block.rounded[i];
        if (p.kind == Kind::triangle) {
            const Volumes w = edge_volumes(p, block, i);
            const double sum = w.a + w.b + w.c;
            hit.u = static_cast<float>(w.b / sum);
            hit.v = static_cast<float>(w.c / sum);
        }
        return hit;
    }

    std::vector<Primitive> primitives_;
    void (*intersect_)(std::span<const Primitive>, Visible, Block&) =
        best_version<intersect_all<soa_width>, std::span<const Primitive>, Visible, Block&>();
};

Primitive make_primitive(const Scene& scene, Kind kind, uint32_t primitive, uint32_t geometry,
                         uint32_t instance) {
    Primitive p{};
    p.kind = kind;
    p.translucent = is_translucent(scene.materials[scene.material_of(geometry)]);
    p.hit.primitive = primitive;
    p.hit.geometry = geometry;
    p.hit.instance = instance;
    return p;
}

/// `geometry` is a sphere or a plane.
void add_shape(const Scene& scene, uint32_t geometry, uint32_t instance,
               std::vector<Primitive>& primitives) {
    const Shape& shape = scene.shape(geometry);
    const Kind kind = shape.kind == ShapeKind::sphere ? Kind::sphere : Kind::plane;
    Primitive p = make_primitive(scene, kind, 0, geometry, instance);
    p.to_shape = Mat4d(scene.instances[instance].world_to_object) * shape.to_shape;
    p.radius2 = double(shape.radius) * double(shape.radius);
    p.half_x = shape.size.x > 0 ? 0.5 * double(shape.size.x) : endless;
    p.half_z = shape.size.z > 0 ? 0.5 * double(shape.size.z) : endless;
    primitives.push_back(p);
}

void add_mesh(const Scene& scene, uint32_t geometry, uint32_t instance,
              std::vector<Primitive>& primitives) {
    const Mesh& mesh = scene.meshes[geometry];
    const Mat4d to_world(scene.instances[instance].object_to_world);
    for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
        Primitive p = make_primitive(scene, Kind::triangle, k, geometry, instance);
        const auto [a, b, c] = mesh.triangles[k];
        p.a = Vec3d(mesh.positions[a]) * to_world;
        p.b = Vec3d(mesh.positions[b]) * to_world;
        p.c = Vec3d(mesh.positions[c]) * to_world;
        p.normal = cross(p.b - p.a, p.c - p.a);
        primitives.push_back(p);
    }
}

std::vector<Primitive> list_primitives(const Scene& scene) {
    std::vector<Primitive> primitives;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Group& group = scene.groups[scene.instances[i].group];
        for (const uint32_t mesh : group.meshes) add_mesh(scene, mesh, i, primitives);
        for (const uint32_t shape : group.shapes)
            add_shape(scene, static_cast<uint32_t>(scene.meshes.size()) + shape, i, primitives);
    }
    return primitives;
}

}  // namespace

bool has_few_shapes(const Scene& scene) {
    size_t primitives = 0;
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        for (const uint32_t mesh : group.meshes) primitives += scene.meshes[mesh].triangles.size();
        for (const uint32_t shape : group.shapes) {
            const ShapeKind kind = scene.shapes[shape].kind;
            if (kind != ShapeKind::sphere && kind != ShapeKind::plane) return false;
        }
        primitives += group.shapes.size();
        if (primitives > max_primitives) return false;
    }
    return true;
}

std::unique_ptr<Intersector> make_few_shapes(const Scene& scene) {
    assert(has_few_shapes(scene));
    return std::make_unique<FewShapes>(list_primitives(scene));
}

}  // namespace sightline
