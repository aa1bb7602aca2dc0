#pragma once
#include "intersect/intersector.h"

#include <string_view>

namespace sightline {

/// Our own engine over the scene, which must outlive it. METHOD is one of
/// - "exact": a tree whose every decision about triangles is that of exact arithmetic, ties going
///   to the least (instance, geometry, primitive); vectors of floats settle what is certain;
/// - a name of triangle_methods(): a tree of conservative boxes over that method, in world space;
/// - such a name followed by ":bounds" (a box around each mesh) or ":loop" (all triangles).
/// Shapes are solved in double by intersect_shape. Throws Error: unknown method, or arithmetic
/// that check_arithmetic refuses.
std::unique_ptr<Intersector> make_reference(const Scene& scene, std::string_view method = "exact");

/// Whether make_reference knows the method.
bool is_reference_method(std::string_view method);

}  // namespace sightline
