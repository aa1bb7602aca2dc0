#include "render/samples.h"

#include <algorithm>

namespace sightline {

void Counters::add(const Counters& other) {
    for (size_t i = 0; i < ray_kinds; ++i) rays[i] += other.rays[i];
    coloured_shadow_rays += other.coloured_shadow_rays;
    uncovered_hits += other.uncovered_hits;
    seen_surfaces += other.seen_surfaces;
    absorbed_rays += other.absorbed_rays;
    area_light_samples += other.area_light_samples;
    environment_samples += other.environment_samples;
    cut_rays += other.cut_rays;
    samples += other.samples;
    depth_reached = std::max(depth_reached, other.depth_reached);
}

void SampleBuffer::start(std::span<const SampleRequest> new_requests) {
    requests = new_requests;
    samples.assign(requests.size(), Sample{});
    light_by_group.assign(requests.size() * light_groups, Vec3(0, 0, 0));
    coverage.clear();
}

}  // namespace sightline
