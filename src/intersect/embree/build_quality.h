#pragma once
#include "intersect/intersector.h"

namespace sightline {

/// How much larger than the triangles the boxes around them are: what spatial splits can mend.
struct BoxWaste {
    /// Boxes of single triangles that a random line through the scene enters.
    double boxes_entered = 0;
    /// Area of those boxes against that of the smallest boxes the triangles could have, lying flat
    /// along an axis: about 1 to 3 for ordinary meshes, hundreds for long diagonal cables.
    double ratio = 1;
};

/// Half the surface of a box that is not empty.
double half_area(const Box3& box);

/// Gathers the waste of one tree, triangle by triangle.
class WasteTally {
  public:
    void add(const Vec3& a, const Vec3& b, const Vec3& c);
    BoxWaste waste() const;

  private:
    double boxes_ = 0, triangles_ = 0;
    Box3 bounds_;
};

/// Splits pay where a ray enters many boxes, most of them in vain.
bool splits_pay(const BoxWaste& waste);

/// The waste of the worst tree: the one over all that is baked, or that of an instanced group.
BoxWaste box_waste(const Scene& scene);

/// High (spatial splits) where the boxes of many long diagonal triangles overlap, else medium.
/// Embree's splits need ten times the build time and act in the default mode only, not in ROBUST.
BuildQuality choose_build_quality(const Scene& scene);

}  // namespace sightline
