#include "intersect/build_quality.h"

namespace sightline {
namespace {

double half_area(const Box3& box) {
    const Vec3d d = Vec3d(box.max) - Vec3d(box.min);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// What one tree holds.
struct Tally {
    double boxes = 0, triangles = 0;
    Box3 bounds;

    void add(const Mesh& mesh) {
        for (const auto& [a, b, c] : mesh.triangles) {
            const Vec3 &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
            Box3 box(p);
            box.extendBy(q);
            box.extendBy(r);
            bounds.extendBy(box);
            boxes += half_area(box);
            triangles += 0.5 * cross(Vec3d(q - p), Vec3d(r - p)).length();
        }
    }

    BoxWaste waste() const {
        const double whole = half_area(bounds);
        if (!(boxes > 0) || !(triangles > 0) || !std::isfinite(whole)) return {};
        return {boxes / whole, boxes / (2 * triangles)};
    }
};

/// Splits pay where a ray enters many boxes, most of them in vain.
bool splits_pay(const BoxWaste& waste) { return waste.boxes_entered > 16 && waste.ratio > 6; }

}  // namespace

BoxWaste box_waste(const Scene& scene) {
    Tally baked;
    std::vector<bool> placed(scene.groups.size());
    BoxWaste worst;
    const auto consider = [&](const BoxWaste& waste) {
        if (waste.boxes_entered * waste.ratio > worst.boxes_entered * worst.ratio) worst = waste;
    };
    for (const Instance& instance : scene.instances) {
        const Group& group = scene.groups[instance.group];
        if (!instance.baked && placed[instance.group]) continue;
        placed[instance.group] = true;
        Tally own;
        for (const uint32_t mesh : group.meshes)
            (instance.baked ? baked : own).add(scene.meshes[mesh]);
        consider(own.waste());
    }
    consider(baked.waste());
    return worst;
}

BuildQuality choose_build_quality(const Scene& scene) {
    return splits_pay(box_waste(scene)) ? BuildQuality::high : BuildQuality::medium;
}

}  // namespace sightline
