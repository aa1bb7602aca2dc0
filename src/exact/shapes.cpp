#include "exact/shapes.h"

#include "exact/dyadic.h"
#include "exact/shape_roots.h"
#include "scene/shape_bounds.h"

#include <algorithm>

namespace sightline {
namespace {

using Rational = mpq_class;

/// An affine matrix of rational numbers that maps rows, p · m.
struct RationalMatrix {
    std::array<std::array<Rational, 3>, 4> rows;

    template <class Matrix>
    explicit RationalMatrix(const Matrix& m) {
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 3; ++j)
                rows[static_cast<size_t>(i)][static_cast<size_t>(j)] =
                    Dyadic(static_cast<double>(m[i][j])).rational();
    }
};

template <class Matrix>
bool is_finite(const Matrix& m) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 3; ++j)
            if (!std::isfinite(m[i][j])) return false;
    return true;
}

/// The inverse, by Cramer's rule; none if there is none.
std::optional<RationalMatrix> inverse_of(const RationalMatrix& m) {
    const auto minor = [&](size_t i, size_t j) {
        const auto &a = m.rows[(j + 1) % 3], &b = m.rows[(j + 2) % 3];
        const size_t k = (i + 1) % 3, l = (i + 2) % 3;
        return Rational(a[k] * b[l] - a[l] * b[k]);
    };
    Rational determinant = 0;
    for (size_t j = 0; j < 3; ++j) determinant += m.rows[0][j] * minor(j, 0);
    if (determinant == 0) return std::nullopt;
    RationalMatrix result = m;
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) result.rows[i][j] = minor(i, j) / determinant;
    for (size_t j = 0; j < 3; ++j) {
        result.rows[3][j] = 0;
        for (size_t i = 0; i < 3; ++i) result.rows[3][j] -= m.rows[3][i] * result.rows[i][j];
    }
    return result;
}

/// First a, then b.
RationalMatrix product_of(const RationalMatrix& a, const RationalMatrix& b) {
    RationalMatrix result = a;
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 3; ++j) {
            result.rows[i][j] = i == 3 ? b.rows[3][j] : Rational(0);
            for (size_t k = 0; k < 3; ++k) result.rows[i][j] += a.rows[i][k] * b.rows[k][j];
        }
    return result;
}

/// The least float box around centre ± reach, one ulp wider.
void set_extent(const Rational& centre, const Rational& reach, Box3& box, int axis) {
    // get_d rounds towards zero.
    const double low = Rational(centre - reach).get_d(), high = Rational(centre + reach).get_d();
    box.min[axis] = std::nextafter(float_below(low), -INFINITY);
    box.max[axis] = std::nextafter(float_above(high), INFINITY);
}

Box3 box_around(const Imath::Box3d& local, bool round, const RationalMatrix& to_world) {
    Rational centre[3], half[3];
    for (int i = 0; i < 3; ++i) {
        // What computing the local box in double rounded off.
        const double slack = 0x1p-48 * std::max(std::abs(local.min[i]), std::abs(local.max[i]));
        const Rational low = Dyadic(local.min[i] - slack).rational(),
                       high = Dyadic(local.max[i] + slack).rational();
        centre[i] = (low + high) / 2;
        half[i] = (high - low) / 2;
    }
    Box3 box;
    for (size_t j = 0; j < 3; ++j) {
        Rational middle = to_world.rows[3][j], sum = 0, squares = 0;
        for (size_t i = 0; i < 3; ++i) {
            const Rational reach = abs(half[i] * to_world.rows[i][j]);
            middle += centre[i] * to_world.rows[i][j];
            sum += reach;
            squares += reach * reach;
        }
        // A root in double, unless it might underflow or overflow.
        const double root = std::sqrt(squares.get_d()) * (1 + 0x1p-50);
        if (round && root > 0x1p-400 && root < 0x1p400) sum = Dyadic(root).rational();
        set_extent(middle, sum, box, static_cast<int>(j));
    }
    return box;
}

}  // namespace

std::optional<std::vector<ExactRoot>> exact_roots(const Ray& ray, const InstancedShape& shape) {
    auto roots = shape_roots(ray, shape);
    if (!roots) return std::nullopt;
    std::vector<ExactRoot> result;
    for (RealRoot& root : *roots) result.push_back({root.to_double(), root.multiplicity()});
    return result;
}

Box3 exact_bounds(const InstancedShape& instanced) {
    const Shape& shape = *instanced.shape;
    const Box3 endless(Vec3(-INFINITY), Vec3(INFINITY));
    const Imath::Box3d local = shape_space_bounds(shape);
    bool bounded = !is_endless(shape) && is_finite(shape.to_shape) &&
                   (instanced.to_world == nullptr || is_finite(*instanced.to_world));
    for (int i = 0; i < 3; ++i)
        bounded &= std::isfinite(local.min[i]) && std::isfinite(local.max[i]);
    if (!bounded) return endless;
    auto to_world = inverse_of(RationalMatrix(shape.to_shape));
    if (!to_world) return endless;
    if (instanced.to_world != nullptr) {
        const RationalMatrix instance(*instanced.to_world);
        if (!inverse_of(instance)) return endless;  // its roots are not known
        to_world = product_of(*to_world, instance);
    }
    return box_around(local, shape.kind == ShapeKind::sphere, *to_world);
}

}  // namespace sightline
