#include "scene/gltf/flat.h"

namespace sightline {
namespace {

// The rows of the linear part, and of its cofactors: the inverse transpose times the determinant.
struct Rows {
    Vec3d rows[3], cofactors[3];
};

double norm(const Vec3d (&rows)[3]) {
    return std::sqrt(dot(rows[0], rows[0]) + dot(rows[1], rows[1]) + dot(rows[2], rows[2]));
}

Rows rows_of(const Mat4d& m) {
    const Vec3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]);
    const Vec3d z(m[2][0], m[2][1], m[2][2]);
    return {{x, y, z}, {cross(y, z), cross(z, x), cross(x, y)}};
}

}  // namespace

double condition_of(const Mat4d& matrix) {
    const Rows m = rows_of(matrix);
    return norm(m.rows) * norm(m.cofactors) / std::abs(dot(m.rows[0], m.cofactors[0]));
}

bool has_area(const Mat4d& matrix) {
    const Rows m = rows_of(matrix);
    for (int i = 0; i < 3; ++i) {
        const double product = m.rows[(i + 1) % 3].length() * m.rows[(i + 2) % 3].length();
        if (m.cofactors[i].length() > 1e-12 * product) return true;  // less is rounding
    }
    return false;
}

// With M = σ₁u₁v₁ᵀ + σ₂u₂v₂ᵀ, the cofactors are σ₁σ₂u₃v₃ᵀ: what is missing, up to its length.
Mat4d thickened(const Mat4d& matrix) {
    const Rows m = rows_of(matrix);
    const double scale = 0x1p-16 / std::sqrt(norm(m.cofactors));
    Mat4d result = matrix;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) result[r][c] += m.cofactors[r][c] * scale;
    return result;
}

}  // namespace sightline
