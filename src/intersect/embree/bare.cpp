#include "intersect/embree/bare.h"

#include "intersect/ray_soa.h"

namespace sightline {
namespace {

void trace_packets(RTCScene scene, Query& query, std::span<const Ray> rays, bool any_hit) {
    alignas(64) std::array<int, soa_width> valid{};
    alignas(64) RTCRayHit16 packet{};
    RTCRay16& ray = packet.ray;
    std::fill_n(ray.mask, soa_width, ~0u);
    for (size_t begin = 0; begin < rays.size(); begin += soa_width) {
        const size_t count = std::min(soa_width, rays.size() - begin);
        for (size_t i = 0; i < soa_width; ++i) valid[i] = i < count ? -1 : 0;
        to_soa(rays.subspan(begin, count), {ray.org_x, ray.org_y, ray.org_z, ray.tnear, ray.dir_x,
                                            ray.dir_y, ray.dir_z, ray.tfar});
        if (any_hit) {
            trace(valid.data(), scene, query, ray);
            continue;
        }
        std::fill_n(packet.hit.geomID, soa_width, RTC_INVALID_GEOMETRY_ID);
        std::fill_n(packet.hit.instID[0], soa_width, RTC_INVALID_GEOMETRY_ID);
        trace(valid.data(), scene, query, packet);
    }
}

void trace_single(RTCScene scene, Query& query, std::span<const Ray> rays, bool any_hit) {
    for (const Ray& from : rays) {
        RTCRayHit lone{};
        RTCRay& to = lone.ray;
        to.org_x = from.origin.x, to.org_y = from.origin.y, to.org_z = from.origin.z;
        to.dir_x = from.direction.x, to.dir_y = from.direction.y, to.dir_z = from.direction.z;
        to.tnear = from.tnear, to.tfar = from.tfar;
        to.mask = ~0u;
        lone.hit.geomID = lone.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        if (any_hit)
            trace(scene, query, to);
        else
            trace(scene, query, lone);
    }
}

}  // namespace

void trace_bare(RTCScene scene, Query& query, std::span<const Ray> rays, bool any_hit,
                bool packets) {
    if (packets)
        trace_packets(scene, query, rays, any_hit);
    else
        trace_single(scene, query, rays, any_hit);
}

}  // namespace sightline
