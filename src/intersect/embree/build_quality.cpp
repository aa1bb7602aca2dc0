#include "intersect/embree/build_quality.h"

namespace sightline {
namespace {

void add(WasteTally& tally, const Mesh& mesh) {
    for (const auto& [a, b, c] : mesh.triangles)
        tally.add(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
}

}  // namespace

double half_area(const Box3& box) {
    const Vec3d d = Vec3d(box.max) - Vec3d(box.min);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

void WasteTally::add(const Vec3& a, const Vec3& b, const Vec3& c) {
    Box3 box(a);
    box.extendBy(b);
    box.extendBy(c);
    bounds_.extendBy(box);
    boxes_ += half_area(box);
    triangles_ += 0.5 * cross(Vec3d(b - a), Vec3d(c - a)).length();
}

BoxWaste WasteTally::waste() const {
    const double whole = half_area(bounds_);
    if (!(boxes_ > 0) || !(triangles_ > 0) || !std::isfinite(whole)) return {};
    return {boxes_ / whole, boxes_ / (2 * triangles_)};
}

bool splits_pay(const BoxWaste& waste) { return waste.boxes_entered > 16 && waste.ratio > 6; }

BoxWaste box_waste(const Scene& scene) {
    WasteTally baked;
    std::vector<bool> placed(scene.groups.size());
    BoxWaste worst;
    const auto consider = [&](const BoxWaste& waste) {
        if (waste.boxes_entered * waste.ratio > worst.boxes_entered * worst.ratio) worst = waste;
    };
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        if (!instance.baked && placed[instance.group]) continue;
        placed[instance.group] = true;
        WasteTally own;
        for (const uint32_t mesh : group.meshes)
            add(instance.baked ? baked : own, scene.meshes[mesh]);
        consider(own.waste());
    }
    consider(baked.waste());
    return worst;
}

BuildQuality choose_build_quality(const Scene& scene) {
    return splits_pay(box_waste(scene)) ? BuildQuality::high : BuildQuality::medium;
}

}  // namespace sightline
