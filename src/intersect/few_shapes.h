#pragma once
#include "intersect/intersector.h"

namespace sightline {

/// Whether the scene has at most eight primitives in all instances, each a sphere, plane or
/// triangle.
bool has_few_shapes(const Scene& scene);

/// A brute-force intersector for scenes with has_few_shapes: it tests every primitive for every
/// ray, in double precision, sixteen rays at a time. It gives the same bits on every processor.
/// The scene must outlive the result.
std::unique_ptr<Intersector> make_few_shapes(const Scene& scene);

}  // namespace sightline
