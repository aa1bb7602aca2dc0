#include "exact/shapes.h"

#include "exact/shape_roots.h"

namespace sightline {

std::optional<std::vector<ExactRoot>> exact_roots(const Ray& ray, const InstancedShape& shape) {
    auto roots = shape_roots(ray, shape);
    if (!roots) return std::nullopt;
    std::vector<ExactRoot> result;
    for (RealRoot& root : *roots) result.push_back({root.to_double(), root.multiplicity()});
    return result;
}

}  // namespace sightline
