#pragma once
// A filter of bounded doubles before the exact roots of spheres. Private to src/exact.
#include "exact/shapes.h"
#include "exact/triangle.h"

namespace sightline {

/// Bounds of the simple roots within a ray's segment, ascending and disjoint.
struct RootEnclosures {
    int count = 0;
    std::array<Enclosure, 2> t{};
};

/// Proven bounds of all roots of a sphere; none if doubles cannot tell the roots from one another
/// or from the ends of the segment.
std::optional<RootEnclosures> enclose_sphere_roots(const Ray& ray, const InstancedShape& sphere);

}  // namespace sightline
