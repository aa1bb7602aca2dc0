#include "intersect/embree/embree.h"

#include "core/parallel.h"
#include "core/vectorise.h"
#include "intersect/embree/bare.h"
#include "intersect/embree/collect.h"
#include "intersect/embree/embree_api.h"
#include "intersect/embree/reach.h"
#include "intersect/hit_id_map.h"
#include "intersect/library_caller.h"
#include "intersect/ray_rules.h"
#include "intersect/ray_soa.h"
#include "intersect/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

namespace sightline {
namespace {

constexpr unsigned opaque_bit = 1, translucent_bit = 2;

unsigned mask_of(Visible visible) {
    constexpr std::array masks = {opaque_bit | translucent_bit, opaque_bit, translucent_bit};
    return masks[static_cast<size_t>(visible)];
}

/// Of a ray that can enter every instance.
unsigned full_mask(Visible visible) {
    static const std::array masks = {spread_mask(mask_of(Visible::all), 0),
                                     spread_mask(mask_of(Visible::opaque), 0),
                                     spread_mask(mask_of(Visible::translucent), 0)};
    return masks[static_cast<size_t>(visible)];
}

/// Sixteen rays as arrays.
struct alignas(64) Packet {
    explicit Packet(Visible v) : visible(v) { set_masks(); }
    void set_masks() { std::fill_n(rays.ray.mask, soa_width, full_mask(visible)); }

    std::array<int, soa_width> valid;
    std::array<float, soa_width> t_scale;
    std::array<int, soa_width> extreme;  // to be prepared one by one
    RTCRayHit16 rays{};
    Visible visible;
    bool masks_changed = false;  // some rays cannot enter all instances

    RaySoA soa() {
        RTCRay16& to = rays.ray;
        return {to.org_x, to.org_y, to.org_z, to.tnear, to.dir_x, to.dir_y, to.dir_z, to.tfar};
    }
};

/// Does the work of engine_ray, except for directions of extreme length and origins beyond
/// `max_origin`.
[[gnu::always_inline]] inline void apply_rules(Packet& packet, float max_origin) {
    const RaySoA soa = packet.soa();
    for (size_t i = 0; i < soa_width; ++i) {
        const Ray ray = soa[i];
        const int valid = int(is_valid(ray)), far = int(max_abs_component(ray.origin) > max_origin);
        packet.valid[i] = -valid;
        packet.extreme[i] = valid & (int(is_extreme(ray.direction)) | far);
        packet.t_scale[i] = 1;
        soa.tnear[i] = next_after_tnear(ray.tnear);
    }
}

/// Packs up to sixteen rays; missing and invalid ones are disabled. Packets are faster than single
/// rays even if the rays are incoherent. `max_origin`: rays within can enter every instance.
void pack(std::span<const Ray> rays, float max_origin, Packet& packet) {
    static const auto apply = best_version<apply_rules, Packet&, float>();
    const RaySoA soa = packet.soa();
    to_soa(rays, soa);
    apply(packet, max_origin);
    std::fill(packet.valid.begin() + static_cast<ptrdiff_t>(rays.size()), packet.valid.end(), 0);
    if (std::exchange(packet.masks_changed, false)) packet.set_masks();
    for (size_t i = 0; i < rays.size(); ++i) {
        if (!packet.extreme[i]) continue;
        const auto [ray, t_scale, valid] = engine_ray(rays[i], embree_max_coordinate);
        const float coordinate = max_abs_component(ray.origin);
        if (coordinate > max_origin) {
            packet.rays.ray.mask[i] = spread_mask(mask_of(packet.visible), coordinate);
            packet.masks_changed = true;
        }
        packet.valid[i] = valid ? -1 : 0;
        packet.t_scale[i] = t_scale;
        soa.tnear[i] = ray.tnear;
        soa.dx[i] = ray.direction.x;
        soa.dy[i] = ray.direction.y;
        soa.dz[i] = ray.direction.z;
        soa.tfar[i] = ray.tfar;
    }
}

/// The smallest t at which ray `i` of `n` hits the shape within its segment, or a negative number.
float intersect_ray(const Shape& shape, RTCRayN* rays, unsigned n, unsigned i) {
    const Vec3 origin(RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i),
                      RTCRayN_org_z(rays, n, i));
    const Vec3 direction(RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i),
                         RTCRayN_dir_z(rays, n, i));
    const float tnear = RTCRayN_tnear(rays, n, i), tfar = RTCRayN_tfar(rays, n, i);
    const ShapeRoots roots =
        intersect_shape(shape, Vec3d(origin), Vec3d(direction), double(tnear), double(tfar));
    return roots.count > 0 ? std::clamp(static_cast<float>(roots.t[0]), tnear, tfar) : -1.0f;
}

void bound_shape(const RTCBoundsFunctionArguments* args) {
    const Box3 box = shape_bounds(*static_cast<const Shape*>(args->geometryUserPtr));
    *args->bounds_o = {box.min.x, box.min.y, box.min.z, 0, box.max.x, box.max.y, box.max.z, 0};
}

void shape_closest(const RTCIntersectFunctionNArguments* args) {
    const auto& shape = *static_cast<const Shape*>(args->geometryUserPtr);
    const unsigned n = args->N;
    RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, n);
    RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, n);
    for (unsigned i = 0; i < n; ++i) {
        if (!args->valid[i]) continue;
        const float t = intersect_ray(shape, rays, n, i);
        if (t < 0) continue;
        if (const auto collected = static_cast<const QueryContext*>(args->context)->collected) {
            collected->push_back({RTCRayN_id(rays, n, i), t, 0, 0, args->primID, args->geomID,
                                  args->context->instID[0]});
            continue;
        }
        RTCRayN_tfar(rays, n, i) = t;
        RTCHitN_u(hits, n, i) = 0;
        RTCHitN_v(hits, n, i) = 0;
        RTCHitN_geomID(hits, n, i) = args->geomID;
        RTCHitN_primID(hits, n, i) = args->primID;
        RTCHitN_instID(hits, n, i, 0) = args->context->instID[0];
    }
}

void shape_occluded(const RTCOccludedFunctionNArguments* args) {
    const auto& shape = *static_cast<const Shape*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i)
        if (args->valid[i] && intersect_ray(shape, args->ray, args->N, i) >= 0)
            RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
}

/// Rays go on behind some surfaces, where `all` finds what else is there.
bool needs_all_hits(const Scene& scene) {
    const auto lets_rays_on = [&](const auto& geometry) {
        const Material& m = scene.materials[geometry.material];
        return is_translucent(m) || !m.double_sided;
    };
    return std::ranges::any_of(scene.meshes, lets_rays_on) ||
           std::ranges::any_of(scene.shapes, lets_rays_on);
}

class EmbreeIntersector final : public Intersector, public LibraryCaller {
  public:
    EmbreeIntersector(const Scene& scene, const EmbreeOptions& options);

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence,
                 Visible visible) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence coherence,
                  Visible visible) const override;
    void all(std::span<const Ray> rays, std::vector<RayHit>& hits, Visible visible) const override;
    bool nearby(const Vec3& centre, float radius, size_t most,
                std::vector<SurfaceId>& found) const override;
    std::string description() const override;
    size_t memory() const override { return monitor_.bytes(); }
    std::vector<std::string> warnings() const override { return hit_ids_.warnings(); }
    bool leaves_out(const Ray& ray, const SurfaceId& surface) const override;
    std::string_view trace_bare(std::span<const Ray> rays, bool any_hit,
                                Coherence coherence) const override;

  private:
    struct SubScene {
        SceneHandle handle;
        uint32_t first = 0;
        unsigned mask = 0;
    };

    SceneHandle new_scene() const;
    void commit(RTCScene handle);
    unsigned attach_group(RTCScene to, const Group& group);
    unsigned attach(RTCScene to, uint32_t geometry, const Mat4* to_world = nullptr);
    GeometryHandle new_mesh(const Mesh& mesh, const Mat4* to_world);
    GeometryHandle new_shape(const Shape& shape);
    void attach_instance(uint32_t instance, SubScene& sub);
    void attach_flattened(uint32_t instance);
    void closest_single(std::span<const Ray> rays, std::span<Hit> hits, Query&, Visible) const;
    void occluded_single(std::span<const Ray> rays, std::span<uint8_t> blocked, Query&,
                         Visible) const;

    unsigned mask_for(const Ray& ray, Visible visible) const {
        const float coordinate = max_abs_component(ray.origin);
        return coordinate <= max_origin_ ? full_mask(visible)
                                         : spread_mask(mask_of(visible), coordinate);
    }

    const Scene& scene_;
    EmbreeOptions options_;
    Monitor monitor_;
    DeviceHandle device_;
    std::vector<SubScene> sub_scenes_;  // by group; empty unless the group is instanced
    SceneHandle top_;
    HitIdMap hit_ids_;
    bool instanced_ = false;
    bool spatial_splits_;                       // never in ROBUST BVHs, at any build quality
    std::vector<float> reach_;                  // by instance; 0 if its shapes are left out
    float max_origin_ = embree_max_coordinate;  // rays within can enter every instance
};

EmbreeIntersector::EmbreeIntersector(const Scene& scene, const EmbreeOptions& options)
    : scene_(scene),
      options_(options),
      device_(new_device(options.isa)),
      sub_scenes_(scene.groups.size()),
      spatial_splits_(options.quality == BuildQuality::high && !options.robust) {
    monitor_.watch(device_.get());
    reach_.assign(scene.instances.size(), embree_max_coordinate);
    top_ = new_scene();
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (instance.baked) {
            const uint32_t first = hit_ids_.next();
            attach_group(top_.get(), scene.groups[instance.group]);
            for (uint32_t g = first; g < hit_ids_.next(); ++g) hit_ids_.add_entry(i, g);
        } else {
            attach_instance(i, sub_scenes_[instance.group]);
        }
    }
    commit(top_.get());
}

SceneHandle EmbreeIntersector::new_scene() const {
    SceneHandle handle(rtcNewScene(device_.get()));
    const int mode = options_.robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE;
    rtcSetSceneFlags(handle.get(), static_cast<RTCSceneFlags>(
                                       needs_all_hits(scene_) ? mode | collecting_flag : mode));
    constexpr std::array qualities = {RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM,
                                      RTC_BUILD_QUALITY_HIGH};
    rtcSetSceneBuildQuality(handle.get(), qualities[static_cast<size_t>(options_.quality)]);
    return handle;
}

void EmbreeIntersector::commit(RTCScene handle) {
    // With several threads the order of spatial splits, and so the BVH, would depend on timing.
    run_with_threads(spatial_splits_ ? 1 : options_.threads, [&] { rtcCommitScene(handle); });
    monitor_.check();
}

/// Attaches the group's geometries and lists them in hit_ids_. Returns the union of their masks.
unsigned EmbreeIntersector::attach_group(RTCScene to, const Group& group) {
    unsigned mask = 0;
    for (const uint32_t mesh : group.meshes)
        if (!scene_.meshes[mesh].triangles.empty()) mask |= attach(to, mesh);
    for (const uint32_t shape : group.shapes)
        mask |= attach(to, static_cast<uint32_t>(scene_.meshes.size()) + shape);
    return mask;
}

/// `to_world`: the matrix of a mesh whose vertices are to be stored in world space.
unsigned EmbreeIntersector::attach(RTCScene to, uint32_t geometry, const Mat4* to_world) {
    const bool translucent = is_translucent(scene_.materials[scene_.material_of(geometry)]);
    const unsigned mask = translucent ? translucent_bit : opaque_bit;
    const GeometryHandle handle = scene_.is_mesh(geometry)
                                      ? new_mesh(scene_.meshes[geometry], to_world)
                                      : new_shape(scene_.shape(geometry));
    rtcSetGeometryMask(handle.get(), mask);
    rtcCommitGeometry(handle.get());
    rtcAttachGeometry(to, handle.get());
    hit_ids_.add_geometry(geometry);
    return mask;
}

GeometryHandle EmbreeIntersector::new_mesh(const Mesh& mesh, const Mat4* to_world) {
    GeometryHandle handle(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    rtcSetSharedGeometryBuffer(handle.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.triangles.data(), 0, sizeof mesh.triangles[0],
                               mesh.triangles.size());
    // Embree reads 16 bytes at each vertex, so it can share our array only if that has spare
    // capacity.
    std::span<const Vec3> positions = mesh.positions;
    if (!to_world && mesh.positions.capacity() > mesh.positions.size()) {
        rtcSetSharedGeometryBuffer(handle.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   mesh.positions.data(), 0, sizeof(Vec3), mesh.positions.size());
    } else {
        void* copy =
            rtcSetNewGeometryBuffer(handle.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(Vec3), mesh.positions.size());
        if (!copy) return handle;  // monitor_ throws
        const std::span<Vec3> stored(static_cast<Vec3*>(copy), mesh.positions.size());
        std::ranges::transform(mesh.positions, stored.begin(), [&](const Vec3& p) {
            return to_world ? Vec3(Vec3d(p) * Mat4d(*to_world)) : p;
        });
        positions = stored;
    }
    hit_ids_.count_dropped_triangles(mesh.triangles, positions, embree_max_coordinate);
    return handle;
}

GeometryHandle EmbreeIntersector::new_shape(const Shape& shape) {
    GeometryHandle handle(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
    rtcSetGeometryUserPrimitiveCount(handle.get(), 1);
    rtcSetGeometryUserData(handle.get(), const_cast<Shape*>(&shape));
    rtcSetGeometryBoundsFunction(handle.get(), bound_shape, nullptr);
    rtcSetGeometryIntersectFunction(handle.get(), shape_closest);
    rtcSetGeometryOccludedFunction(handle.get(), shape_occluded);
    return handle;
}

/// Attaches an instance of a group, whose scene is built at its first use.
void EmbreeIntersector::attach_instance(uint32_t index, SubScene& sub) {
    const Instance& instance = scene_.instances[index];
    const float max_origin = max_world_coordinate(instance.object_to_world);
    if (max_origin == 0) return attach_flattened(index);
    if (!sub.handle) {
        sub.handle = new_scene();
        sub.first = hit_ids_.next();
        sub.mask = attach_group(sub.handle.get(), scene_.groups[instance.group]);
        commit(sub.handle.get());
    }
    const unsigned c = reach_class_of(max_origin);
    reach_[index] = class_reach(c);
    max_origin_ = std::min(max_origin_, reach_[index]);
    instanced_ = true;
    const GeometryHandle handle(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(handle.get(), sub.handle.get());
    rtcSetGeometryTransform(handle.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                            instance.object_to_world.getValue());
    rtcSetGeometryMask(handle.get(), sub.mask << 2 * c);
    rtcCommitGeometry(handle.get());
    rtcAttachGeometry(top_.get(), handle.get());
    hit_ids_.add_entry(index, sub.first);
}

/// Stores the triangles of an instance in world space, since rays cannot be taken to its object
/// space. Its shapes are left out.
void EmbreeIntersector::attach_flattened(uint32_t index) {
    const Instance& instance = scene_.instances[index];
    const Group& group = scene_.groups[instance.group];
    for (const uint32_t mesh : group.meshes) {
        if (scene_.meshes[mesh].triangles.empty()) continue;
        hit_ids_.add_entry(index, hit_ids_.next());
        attach(top_.get(), mesh, &instance.object_to_world);
    }
    if (group.shapes.empty()) return;
    reach_[index] = 0;
    hit_ids_.count_dropped_shapes(group.shapes.size());
}

bool EmbreeIntersector::leaves_out(const Ray& ray, const SurfaceId& surface) const {
    const bool flattened = reach_[surface.instance] == 0 && scene_.is_mesh(surface.geometry);
    const float reach = flattened ? embree_max_coordinate : reach_[surface.instance];
    return !(max_abs_component(ray.origin) <= reach);
}

std::string_view EmbreeIntersector::trace_bare(std::span<const Ray> rays, bool any_hit,
                                               Coherence coherence) const {
    Query query(coherence == Coherence::coherent && !(any_hit && instanced_));  // see occluded
    sightline::trace_bare(top_.get(), query, rays, any_hit, options_.packets);
    if (options_.packets) return any_hit ? "rtcOccluded16" : "rtcIntersect16";
    return any_hit ? "rtcOccluded1" : "rtcIntersect1";
}

void EmbreeIntersector::closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence,
                                Visible visible) const {
    assert(rays.size() == hits.size());
    Query query(coherence == Coherence::coherent);
    if (!options_.packets) return closest_single(rays, hits, query, visible);
    Packet packet(visible);
    RTCRay16& ray = packet.rays.ray;
    RTCHit16& hit = packet.rays.hit;
    for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
        const size_t count = std::min(soa_width, rays.size() - begin);
        pack(rays.subspan(begin, count), max_origin_, packet);
        std::fill_n(hit.geomID, soa_width, RTC_INVALID_GEOMETRY_ID);
        std::fill_n(hit.instID[0], soa_width, RTC_INVALID_GEOMETRY_ID);
        trace(packet.valid.data(), top_.get(), query, packet.rays);
        for (size_t i = 0; i < count; ++i)
            hits[begin + i] =
                hit.geomID[i] == RTC_INVALID_GEOMETRY_ID
                    ? Hit{}
                    : hit_ids_.resolve(ray.tfar[i] * packet.t_scale[i], hit.u[i], hit.v[i],
                                       hit.primID[i], hit.geomID[i], hit.instID[0][i]);
    }
}

void EmbreeIntersector::occluded(std::span<const Ray> rays, std::span<uint8_t> blocked,
                                 Coherence coherence, Visible visible) const {
    assert(rays.size() == blocked.size());
    // Debian 12's coherent rtcOccluded16 for AVX-512 can loop for ever in a scene with instances:
    // it stores a mask as 16 bits, reloads it as 64 and waits for the rest to become zero.
    Query query(!instanced_ && coherence == Coherence::coherent);
    if (!options_.packets) return occluded_single(rays, blocked, query, visible);
    Packet packet(visible);
    RTCRay16& ray = packet.rays.ray;
    for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
        const size_t count = std::min(soa_width, rays.size() - begin);
        pack(rays.subspan(begin, count), max_origin_, packet);
        trace(packet.valid.data(), top_.get(), query, ray);
        for (size_t i = 0; i < count; ++i) blocked[begin + i] = packet.valid[i] && ray.tfar[i] < 0;
    }
}

/// A valid ray for a single-ray call.
RTCRayHit make_single_ray(const Ray& ray, unsigned mask) {
    RTCRayHit out{};
    RTCRay& to = out.ray;
    to.org_x = ray.origin.x, to.org_y = ray.origin.y, to.org_z = ray.origin.z;
    to.dir_x = ray.direction.x, to.dir_y = ray.direction.y, to.dir_z = ray.direction.z;
    to.tnear = ray.tnear, to.tfar = ray.tfar;
    to.mask = mask;
    out.hit.geomID = out.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return out;
}

void EmbreeIntersector::closest_single(std::span<const Ray> rays, std::span<Hit> hits, Query& query,
                                       Visible visible) const {
    for (size_t i = 0; i < rays.size(); ++i) {
        const auto [ray, t_scale, valid] = engine_ray(rays[i], embree_max_coordinate);
        hits[i] = Hit{};
        if (!valid) continue;
        RTCRayHit lone = make_single_ray(ray, mask_for(ray, visible));
        trace(top_.get(), query, lone);
        const RTCHit& hit = lone.hit;
        if (hit.geomID != RTC_INVALID_GEOMETRY_ID)
            hits[i] = hit_ids_.resolve(lone.ray.tfar * t_scale, hit.u, hit.v, hit.primID,
                                       hit.geomID, hit.instID[0]);
    }
}

void EmbreeIntersector::occluded_single(std::span<const Ray> rays, std::span<uint8_t> blocked,
                                        Query& query, Visible visible) const {
    for (size_t i = 0; i < rays.size(); ++i) {
        const EngineRay ray = engine_ray(rays[i], embree_max_coordinate);
        RTCRay lone = make_single_ray(ray.ray, mask_for(ray.ray, visible)).ray;
        if (ray.valid) trace(top_.get(), query, lone);
        blocked[i] = ray.valid && lone.tfar < 0;
    }
}

void EmbreeIntersector::all(std::span<const Ray> rays, std::vector<RayHit>& hits,
                            Visible visible) const {
    std::vector<EngineHit> found;
    // Short segments of neighbouring rays pass the same nodes, whatever their directions are.
    Query query(true);
    query.collect(found, collect_hits);
    Packet packet(visible);
    std::iota(packet.rays.ray.id, packet.rays.ray.id + soa_width, 0u);
    for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
        const size_t count = std::min(soa_width, rays.size() - begin);
        pack(rays.subspan(begin, count), max_origin_, packet);
        std::fill_n(packet.rays.hit.geomID, soa_width, RTC_INVALID_GEOMETRY_ID);
        std::fill_n(packet.rays.hit.instID[0], soa_width, RTC_INVALID_GEOMETRY_ID);
        found.clear();
        trace(packet.valid.data(), top_.get(), query, packet.rays);
        for (const EngineHit& h : found)
            hits.push_back({static_cast<uint32_t>(begin + h.ray),
                            hit_ids_.resolve(h.t * packet.t_scale[h.ray], h.u, h.v, h.primitive,
                                             h.geometry, h.instance)});
    }
}

bool EmbreeIntersector::nearby(const Vec3& centre, float radius, size_t most,
                               std::vector<SurfaceId>& found) const {
    std::vector<EngineHit> collected;
    if (!collect_nearby(top_.get(), centre, radius, most, collected)) return false;
    for (const EngineHit& h : collected)
        found.push_back(surface_of(hit_ids_.resolve(0, 0, 0, h.primitive, h.geometry, h.instance)));
    return true;
}

std::string EmbreeIntersector::description() const {
    const ssize_t version = rtcGetDeviceProperty(device_.get(), RTC_DEVICE_PROPERTY_VERSION);
    return fmt::format("Embree {}.{}.{} {}{}{}, {}", version / 10000, version / 100 % 100,
                       version % 100, options_.robust ? "robust" : "default",
                       spatial_splits_ ? ", spatial splits" : "",
                       options_.packets ? "" : ", ray by ray", isa_of(device_.get(), options_.isa));
}

}  // namespace

std::string embree_isa(const std::string& requested) {
    return isa_of(new_device(requested).get(), requested);
}

std::unique_ptr<Intersector> make_embree(const Scene& scene, const EmbreeOptions& options) {
    return std::make_unique<EmbreeIntersector>(scene, options);
}

}  // namespace sightline
