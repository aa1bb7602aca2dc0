#pragma once
// Whether spatial splits pay off for a scene.
#include "intersect/embree/embree.h"

namespace sightline {

/// How much the boxes around triangles overlap: the cost that spatial splits reduce.
struct OverlapStats {
    /// Boxes of single triangles that a random line through the scene enters.
    double boxes_entered = 0;
    /// Area of those boxes divided by that of the smallest boxes that the triangles could have,
    /// lying flat along an axis: about 1 to 3 for ordinary meshes, hundreds for long diagonal
    /// cables.
    double area_ratio = 1;
};

/// Half the surface area of a box that is not empty.
double half_area(const Box3& box);

/// Sums the statistics of one BVH, triangle by triangle.
class OverlapCounter {
  public:
    void add(const Vec3& a, const Vec3& b, const Vec3& c);
    OverlapStats stats() const;

  private:
    double box_area_ = 0, triangle_area_ = 0;
    Box3 bounds_;
};

/// True if a ray enters many boxes, most of them in vain.
bool spatial_splits_pay_off(const OverlapStats& stats);

/// The statistics of the worst BVH: the one over all that is baked, or that of an instanced group.
OverlapStats overlap_stats(const Scene& scene);

/// High (spatial splits) if the boxes of many long diagonal triangles overlap, else medium.
/// Embree's splits take ten times the build time and have an effect in the default mode only, not
/// in ROBUST.
BuildQuality choose_build_quality(const Scene& scene);

}  // namespace sightline
