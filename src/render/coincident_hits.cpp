#include "render/coincident_hits.h"

#include "scene/shape_bounds.h"
#include "shade/hit_geometry.h"

#include <algorithm>
#include <tuple>

namespace sightline {
namespace {

auto id_of(const Hit& hit) { return std::tuple(hit.instance, hit.geometry, hit.primitive); }

float along(const Vec3& normal, const Vec3& error) {
    return std::fabs(normal.x) * error.x + std::fabs(normal.y) * error.y +
           std::fabs(normal.z) * error.z;
}

// The bounds of a geometry in world space, a little larger than it is.
Box3 world_bounds(const Scene& scene, uint32_t geometry, const Instance& instance) {
    Box3 box = scene.is_mesh(geometry) ? mesh_bounds(scene.meshes[geometry])
                                       : shape_bounds(scene.shape(geometry));
    if (!instance.baked) box = transformed_box(box, Mat4d(instance.object_to_world));
    if (box.isEmpty()) return box;
    const Vec3 margin(1e-5f * std::max(max_abs_component(box.min), max_abs_component(box.max)));
    return {box.min - margin, box.max + margin};
}

}  // namespace

std::vector<Box3> translucent_bounds(const Scene& scene) {
    std::vector<Box3> boxes;
    const auto add = [&](uint32_t geometry, const Instance& instance) {
        if (!is_translucent(scene.materials[scene.material_of(geometry)])) return;
        const Box3 box = world_bounds(scene, geometry, instance);
        if (!box.isEmpty()) boxes.push_back(box);
    };
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        for (const uint32_t mesh : group.meshes) add(mesh, instance);
        for (const uint32_t shape : group.shapes)
            add(static_cast<uint32_t>(scene.meshes.size()) + shape, instance);
    }
    constexpr size_t most_boxes = 16;  // more cost as much as the search that they save
    if (boxes.size() <= most_boxes) return boxes;
    Box3 all;
    for (const Box3& box : boxes) all.extendBy(box);
    return {all};
}

bool CoincidentHits::may_be_covered(const Surface& surface) const {
    return std::ranges::any_of(translucent_bounds_,
                               [&](const Box3& box) { return box.intersects(surface.position); });
}

CoincidentHits::Member CoincidentHits::member(const Ray& ray, const Hit& hit) const {
    const HitGeometry g = hit_geometry(scene_, hit, &ray, false);
    const Material& material = scene_.materials[scene_.material_of(hit.geometry)];
    return {.hit = hit,
            .depth = 0,
            .error = 0,
            .front = dot(g.outward, ray.direction) <= 0,
            .opaque = !is_translucent(material),
            .position = g.position,
            .position_error = g.position_error};
}

std::optional<size_t> CoincidentHits::add(const Ray& ray, const Hit& closest,
                                          const Surface& surface) {
    const float speed = ray.direction.length();
    const float cosine = std::max(-dot(surface.ng, ray.direction) / speed, 1e-3f);
    // Other surfaces have similar bounds; engines round t as well.
    const float reach =
        8 * along(surface.ng, surface.position_error) / (cosine * speed) + closest.t * 0x1p-20f;
    // Engines may find another surface at the end of the segment, as far from its place again.
    if (lone_.is_lone(closest, 2 * reach * speed)) return std::nullopt;
    Ray segment = ray;
    segment.tnear = std::max(ray.tnear, closest.t - reach);
    segment.tfar = std::min(ray.tfar, closest.t + reach);
    segments_.push_back(segment);
    queries_.push_back({ray, closest, surface.ng});
    return queries_.size() - 1;
}

void CoincidentHits::search(Visible visible) {
    if (segments_.empty()) return;
    intersector_.all(segments_, found_, visible);
    std::erase_if(found_, [&](const RayHit& found) {
        return id_of(found.hit) == id_of(queries_[found.ray].closest);
    });
    std::ranges::sort(found_, {}, &RayHit::ray);
}

std::span<const Hit> CoincidentHits::at(size_t index) {
    const Query& query = queries_[index];
    hits_.assign(1, query.closest);
    members_.clear();
    const auto ray = static_cast<uint32_t>(index);
    const std::span<const RayHit> others(std::ranges::lower_bound(found_, ray, {}, &RayHit::ray),
                                         std::ranges::upper_bound(found_, ray, {}, &RayHit::ray));
    if (others.empty()) return hits_;
    list_members(query, others);
    keep_connected();
    order_hits();
    return hits_;
}

// The closest hit and all others near it, once each.
void CoincidentHits::list_members(const Query& query, std::span<const RayHit> others) {
    members_.push_back(member(query.ray, query.closest));
    for (const RayHit& found : others) {
        const auto is_same = [&](const Member& m) { return id_of(m.hit) == id_of(found.hit); };
        if (std::ranges::none_of(members_, is_same))
            members_.push_back(member(query.ray, found.hit));
    }
    for (Member& m : members_) {
        m.depth = dot(query.normal, members_[0].position - m.position);
        m.error = along(query.normal, m.position_error);
    }
}

// Removes what no chain of overlapping error bounds connects with the closest hit, the first.
void CoincidentHits::keep_connected() {
    float low = -members_[0].error, high = members_[0].error;
    auto end = members_.begin() + 1;
    for (bool grows = true; grows;) {
        const auto rest = std::partition(end, members_.end(), [&](const Member& m) {
            return m.depth - m.error <= high && m.depth + m.error >= low;
        });
        grows = rest != end;
        for (; end != rest; ++end) {
            low = std::min(low, end->depth - end->error);
            high = std::max(high, end->depth + end->error);
        }
    }
    members_.erase(end, members_.end());
}

void CoincidentHits::order_hits() {
    std::ranges::sort(members_, [](const Member& a, const Member& b) {
        return std::tuple(!a.front, a.opaque, id_of(a.hit)) <
               std::tuple(!b.front, b.opaque, id_of(b.hit));
    });
    hits_.clear();
    for (auto m = members_.begin(); m != members_.end(); ++m) {
        const auto is_repeated = [&](const Member& earlier) {
            return repeats_neighbour(earlier, *m);
        };
        if (std::none_of(members_.begin(), m, is_repeated)) hits_.push_back(m->hit);
    }
}

// True if a ray through a common edge or vertex of two triangles of one mesh hits both, which are
// one surface.
bool CoincidentHits::repeats_neighbour(const Member& a, const Member& b) const {
    if (a.hit.instance != b.hit.instance || a.hit.geometry != b.hit.geometry ||
        a.front != b.front || !scene_.is_mesh(a.hit.geometry))
        return false;
    const auto is_on_border = [](const Hit& hit) {
        return std::min({hit.u, hit.v, 1 - hit.u - hit.v}) < 1e-5f;
    };
    if (!is_on_border(a.hit) || !is_on_border(b.hit)) return false;
    const Mesh& mesh = scene_.meshes[a.hit.geometry];
    int common = 0;
    for (const uint32_t i : mesh.triangles[a.hit.primitive])
        for (const uint32_t j : mesh.triangles[b.hit.primitive])
            common += mesh.positions[i] == mesh.positions[j];
    return common == 1 || common == 2;
}

void CoincidentHits::widen(Surface& surface) const {
    if (members_.size() < 2) return;
    Vec3 error(0);
    float distance = 0;
    for (const Member& m : members_) {
        for (int i = 0; i < 3; ++i) error[i] = std::max(error[i], m.position_error[i]);
        distance = std::max(distance, std::fabs(dot(surface.ng, m.position - surface.position)));
    }
    // The offset along the normal grows by `distance`, since n · n = 1.
    surface.position_error =
        error +
        Vec3(std::fabs(surface.ng.x), std::fabs(surface.ng.y), std::fabs(surface.ng.z)) * distance;
}

}  // namespace sightline
