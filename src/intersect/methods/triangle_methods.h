#pragma once
// The triangle methods by name.
#include "core/ray.h"
#include "intersect/methods/triangles.h"

#include <memory>
#include <span>
#include <string>

namespace sightline {

/// The closest hit found so far.
struct NearestTriangle {
    double t, u = 0, v = 0;
    uint32_t index = none;  ///< into the set; none: no hit yet
};

/// Triangles prepared for one method.
class TriangleSet {
  public:
    virtual ~TriangleSet() = default;

    /// Tests triangles first … first + count − 1 with tnear < t ≤ tfar, and replaces `best` by hits
    /// nearer than best.t.
    virtual void nearest(const Ray& ray, uint32_t first, uint32_t count,
                         NearestTriangle& best) const = 0;

    /// The hit on one triangle, under the same conditions.
    virtual std::optional<TriangleHit<double>> test(const Ray& ray, uint32_t index) const = 0;

    virtual size_t memory() const = 0;
};

struct TriangleMethod {
    std::string name;         ///< ends in -double if it computes in double precision
    std::string description;  ///< one phrase
    std::unique_ptr<TriangleSet> (*prepare)(std::span<const Corners<float>> triangles);
};

/// All methods, in the order of the documentation.
std::span<const TriangleMethod> triangle_methods();

/// The method of that name. Throws Error, listing the names.
const TriangleMethod& triangle_method(std::string_view name);

}  // namespace sightline
