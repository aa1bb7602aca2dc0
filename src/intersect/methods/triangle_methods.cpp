#include "intersect/methods/triangle_methods.h"

#include "core/error.h"
#include "intersect/methods/watertight.h"

#include <vector>

namespace sightline {
namespace {

template <template <class> class Method, class T>
class PreparedSet : public TriangleSet {
  public:
    explicit PreparedSet(std::span<const Corners<float>> triangles) {
        triangles_.reserve(triangles.size());
        for (const auto& [a, b, c] : triangles)
            triangles_.push_back(Method<T>::prepare({V(a), V(b), V(c)}));
    }

    void nearest(const Ray& ray, uint32_t first, uint32_t count,
                 NearestTriangle& best) const override {
        const Method<T> method(V(ray.origin), V(ray.direction));
        for (uint32_t i = first; i < first + count; ++i)
            if (const auto hit = within(ray, method(triangles_[i])))
                if (hit->t < best.t) best = {hit->t, hit->u, hit->v, i};
    }

    std::optional<TriangleHit<double>> test(const Ray& ray, uint32_t index) const override {
        return within(ray, Method<T>(V(ray.origin), V(ray.direction))(triangles_[index]));
    }

    size_t memory() const override { return triangles_.size() * sizeof(triangles_[0]); }

  private:
    using V = Imath::Vec3<T>;

    static std::optional<TriangleHit<double>> within(const Ray& ray,
                                                     const std::optional<TriangleHit<T>>& hit) {
        if (!hit || !(hit->t > static_cast<T>(ray.tnear) && hit->t <= static_cast<T>(ray.tfar)))
            return std::nullopt;
        return TriangleHit<double>{static_cast<double>(hit->t), static_cast<double>(hit->u),
                                   static_cast<double>(hit->v)};
    }

    std::vector<typename Method<T>::Triangle> triangles_;
};

template <template <class> class Method, class T>
TriangleMethod entry() {
    const bool wide = std::is_same_v<T, double>;
    return {std::string(Method<T>::name) + (wide ? "-double" : ""),
            std::string(Method<T>::description) + (wide ? ", in double" : ", in float"),
            [](std::span<const Corners<float>> triangles) -> std::unique_ptr<TriangleSet> {
                return std::make_unique<PreparedSet<Method, T>>(triangles);
            }};
}

template <template <class> class... Methods>
std::vector<TriangleMethod> entries() {
    std::vector<TriangleMethod> result;
    ((result.push_back(entry<Methods, float>()), result.push_back(entry<Methods, double>())), ...);
    return result;
}

template <class T>
using PlainWoop = Woop<T>;

}  // namespace

std::span<const TriangleMethod> triangle_methods() {
    static const std::vector<TriangleMethod> methods =
        entries<PlaneInside, SnyderBarr, MollerTrumbore, BaldwinWeber, Plucker, PlainWoop,
                WoopProducts, ExactFiltered>();
    return methods;
}

const TriangleMethod& triangle_method(std::string_view name) {
    std::string names;
    for (const TriangleMethod& method : triangle_methods()) {
        if (method.name == name) return method;
        names += (names.empty() ? "" : ", ") + method.name;
    }
    throw Error("unknown triangle method '" + std::string(name) + "'; there are " + names);
}

}  // namespace sightline
