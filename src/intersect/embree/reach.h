#pragma once
// From how far away rays can be taken to the object spaces of instances in single precision.
#include "core/math.h"

namespace sightline {

/// Embree silently drops a triangle with a coordinate beyond this or NaN; on a ray with such a
/// coordinate, in any instance, an assertion of Debian's build ends the process.
inline constexpr float embree_max_coordinate = 1.844e18f;

/// The largest world coordinate of a ray's origin such that its coordinates in object space stay
/// within embree_max_coordinate; 0 if the matrix has no inverse that is usable in single precision.
float max_world_coordinate(const Mat4& object_to_world);

/// Instances are told apart by masks: those of class c can be entered by rays whose origin has no
/// coordinate beyond class_reach(c). Each class has two bits, shifted by 2·c. Class 0 is for what
/// is stored in world space.
inline constexpr unsigned reach_classes = 12;
float class_reach(unsigned reach_class);

/// The first class that is within the given coordinate, which is 0 or a result of
/// max_world_coordinate.
unsigned reach_class_of(float max_coordinate);

/// The two-bit mask in all classes that a ray from such a coordinate can enter.
unsigned spread_mask(unsigned mask, float coordinate);

}  // namespace sightline
