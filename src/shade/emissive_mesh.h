#pragma once
#include "shade/discrete_distribution.h"
#include "shade/surface.h"

#include <vector>

namespace sightline {

/// Chooses points on a mesh by what its triangles emit: a triangle in proportion to its estimated
/// emission, and a large textured one cell by cell, so that most points fall where its texture
/// shines. All instances of the mesh share it.
///
/// The estimates affect noise alone: wherever a texture might shine, the density is positive.
class EmissiveMesh {
  public:
    /// The mesh `geometry` as it appears in `instance`; both must exist. Estimates on `threads`
    /// threads (0: all).
    EmissiveMesh(const Scene& scene, const Surfaces& surfaces, uint32_t instance, uint32_t geometry,
                 unsigned threads);

    /// Areas of the mesh's triangles in an instance, in world space, times some quantity.
    struct Integral {
        double emission = 0;  ///< estimated luminance that leaves one side, coverage included
        double potential =
            0;              ///< luminance if every texel shone fully; 0 where textures play no part
        double weight = 0;  ///< emission + floor · potential, by which triangles are picked
    };
    Integral over(const Instance& instance) const;

    /// Sets up sampling. `floor`: the share of the potential that is added to each estimate, in
    /// case it misses what shines. About `cells` cells are spent on the triangles that are picked
    /// most.
    void prepare(float floor, double cells, unsigned threads);

    struct Point {
        uint32_t triangle = 0;
        float u = 0, v = 0;  ///< barycentric, as in Hit
    };
    /// A point from `pick` in [0,1), which chooses the triangle and the cell, and `u` in [0,1)².
    Point sample(double pick, Vec2 u) const;

    /// Density of the sampled points, over that of uniform points on the triangle.
    double density(const Point& point) const;

    /// The number of triangles that have a density.
    uint64_t count() const;

  private:
    // A triangle of n² cells of equal area. Cell (a, b), at index a·n + b, is the one with its
    // corner at u = a/n, v = b/n if a + b < n; the others are the upside-down triangles between
    // those, mirrored at the middle of the unit square.
    struct DividedTriangle {
        uint32_t n;
        DiscreteDistribution cells;
    };
    float estimate(uint32_t triangle, Vec2 corner, float size) const;
    void estimate_triangle(uint32_t triangle);
    double weight(uint32_t triangle) const;
    void divide(uint32_t triangle, uint32_t n, DividedTriangle& divided);

    const Scene& scene_;
    const Surfaces& surfaces_;
    uint32_t instance_, geometry_;
    float potential_ = 0, floor_ = 0;  // luminance; share of it in each weight
    std::vector<float> emission_;      // by triangle: estimated mean luminance
    std::vector<double> area_;         // by triangle, in the mesh's space
    std::vector<uint32_t> divided_;    // by triangle, into divided_triangles_, or none; or empty
    std::vector<DividedTriangle> divided_triangles_;
    DiscreteDistribution triangles_;
};

}  // namespace sightline
