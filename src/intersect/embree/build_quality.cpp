#include "intersect/embree/build_quality.h"

namespace sightline {
namespace {

void add(OverlapCounter& counter, const Mesh& mesh) {
    for (const auto& [a, b, c] : mesh.triangles)
        counter.add(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
}

}  // namespace

double half_area(const Box3& box) {
    const Vec3d d = Vec3d(box.max) - Vec3d(box.min);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

void OverlapCounter::add(const Vec3& a, const Vec3& b, const Vec3& c) {
    Box3 box(a);
    box.extendBy(b);
    box.extendBy(c);
    bounds_.extendBy(box);
    box_area_ += half_area(box);
    triangle_area_ += 0.5 * cross(Vec3d(b - a), Vec3d(c - a)).length();
}

OverlapStats OverlapCounter::stats() const {
    const double whole = half_area(bounds_);
    if (!(box_area_ > 0) || !(triangle_area_ > 0) || !std::isfinite(whole)) return {};
    return {box_area_ / whole, box_area_ / (2 * triangle_area_)};
}

bool spatial_splits_pay_off(const OverlapStats& stats) {
    return stats.boxes_entered > 16 && stats.area_ratio > 6;
}

OverlapStats overlap_stats(const Scene& scene) {
    OverlapCounter baked;
    std::vector<bool> counted(scene.groups.size());
    OverlapStats worst;
    const auto consider = [&](const OverlapStats& stats) {
        if (stats.boxes_entered * stats.area_ratio > worst.boxes_entered * worst.area_ratio)
            worst = stats;
    };
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        if (!instance.baked && counted[instance.group]) continue;
        counted[instance.group] = true;
        OverlapCounter own;
        for (const uint32_t mesh : group.meshes)
            add(instance.baked ? baked : own, scene.meshes[mesh]);
        consider(own.stats());
    }
    consider(baked.stats());
    return worst;
}

BuildQuality choose_build_quality(const Scene& scene) {
    return spatial_splits_pay_off(overlap_stats(scene)) ? BuildQuality::high : BuildQuality::medium;
}

}  // namespace sightline
