#pragma once
#include "intersect/intersector.h"

namespace sightline {

/// An engine over the scene, which must outlive it, whose every decision about triangles is that of
/// exact arithmetic. Ties go to the least (instance, geometry, primitive); single-precision vectors
/// settle what they can prove. Shapes are solved in double precision by intersect_shape.
/// Throws Error if check_arithmetic refuses the processor's arithmetic.
std::unique_ptr<Intersector> make_exact_intersector(const Scene& scene);

}  // namespace sightline
