#include "intersect/embree/collect.h"

namespace sightline {
namespace {

struct Collected {
    std::vector<EngineHit>& found;
    size_t most;
};

bool collect_primitive(RTCPointQueryFunctionArguments* args) {
    const auto& [found, most] = *static_cast<Collected*>(args->userPtr);
    const RTCPointQueryContext& context = *args->context;
    const unsigned instance =
        context.instStackSize > 0 ? context.instID[0] : RTC_INVALID_GEOMETRY_ID;
    found.push_back({0, 0, 0, 0, args->primID, args->geomID, instance});
    if (found.size() <= most) return false;
    args->query->radius = 0;
    return true;
}

}  // namespace

void collect_hits(const RTCFilterFunctionNArguments* args) {
    std::vector<EngineHit>& collected = *static_cast<const QueryContext*>(args->context)->collected;
    const unsigned n = args->N;
    for (unsigned i = 0; i < n; ++i) {
        if (!args->valid[i]) continue;
        collected.push_back({RTCRayN_id(args->ray, n, i), RTCRayN_tfar(args->ray, n, i),
                             RTCHitN_u(args->hit, n, i), RTCHitN_v(args->hit, n, i),
                             RTCHitN_primID(args->hit, n, i), RTCHitN_geomID(args->hit, n, i),
                             RTCHitN_instID(args->hit, n, i, 0)});
        args->valid[i] = 0;
    }
}

bool collect_nearby(RTCScene scene, const Vec3& centre, float radius, size_t most,
                    std::vector<EngineHit>& found) {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery query{centre.x, centre.y, centre.z, 0, radius};
    Collected collected{found, most};
    rtcPointQuery(scene, &query, &context, collect_primitive, &collected);
    return found.size() <= most;
}

}  // namespace sightline
