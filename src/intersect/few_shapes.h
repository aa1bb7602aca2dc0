#pragma once
#include "intersect/intersector.h"

namespace sightline {

/// An intersector for scenes of at most eight spheres, planes and triangles in all: it tries each
/// of them for every ray, in double precision, sixteen rays at a time and without any tree.
/// The same bits on every processor. Null where the scene has more, or other shapes.
/// The scene must outlive the result.
std::unique_ptr<Intersector> make_few_shapes(const Scene& scene);

}  // namespace sightline
