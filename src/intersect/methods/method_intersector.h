#pragma once
#include "intersect/intersector.h"
#include "intersect/methods/triangle_methods.h"

namespace sightline {

/// How a method finds the triangles to test.
enum class Structure {
    bvh,          ///< a BVH of conservative boxes, in world space
    mesh_bounds,  ///< a box around each mesh
    loop          ///< all triangles
};

/// An engine that tests triangles with one of triangle_methods() over the scene, which must outlive
/// it. Shapes are solved in double precision by intersect_shape. Throws Error if check_arithmetic
/// refuses the processor's arithmetic.
std::unique_ptr<Intersector> make_method_intersector(const Scene& scene,
                                                     const TriangleMethod& method,
                                                     Structure structure = Structure::bvh);

}  // namespace sightline
