#include "scene/shape_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline {

Imath::Box3d shape_space_bounds(const Shape& s) {
    const double half = 0.5 * double(s.height), r = double(s.radius);
    const double top = double(s.radius_top), bottom = double(s.radius_bottom);
    const double widest = std::max(top, bottom);
    switch (s.kind) {
        case ShapeKind::sphere:
            return {{-r, -r, -r}, {r, r, r}};
        case ShapeKind::box:
            return {Vec3d(s.size) * -0.5, Vec3d(s.size) * 0.5};
        case ShapeKind::capsule:
            return {{-widest, std::min(half - top, -half - bottom), -widest},
                    {widest, std::max(half + top, -half + bottom), widest}};
        case ShapeKind::cylinder:
            return {{-widest, -half, -widest}, {widest, half, widest}};
        case ShapeKind::plane: {
            const double x = s.size.x > 0 ? 0.5 * double(s.size.x) : 1e6;
            const double z = s.size.z > 0 ? 0.5 * double(s.size.z) : 1e6;
            return {{-x, 0, -z}, {x, 0, z}};
        }
        case ShapeKind::torus: {
            const double tube = double(s.tube_radius);
            return {{-r - tube, -tube, -r - tube}, {r + tube, tube, r + tube}};
        }
        case ShapeKind::heart:
            return {Vec3d(-heart_x, -1, -heart_z) * double(s.scale),
                    Vec3d(heart_x, heart_y, heart_z) * double(s.scale)};
    }
    return {};
}

Box3 shape_bounds(const Shape& shape) {
    const Imath::Box3d local = shape_space_bounds(shape);
    const Vec3d middle = transform_point(local.center(), shape.to_object),
                half = local.size() * 0.5;
    Box3 bounds;
    for (int j = 0; j < 3; ++j) {
        const double x = half.x * shape.to_object[0][j], y = half.y * shape.to_object[1][j],
                     z = half.z * shape.to_object[2][j];
        const double extent = shape.kind == ShapeKind::sphere
                                  ? std::sqrt(x * x + y * y + z * z)
                                  : std::abs(x) + std::abs(y) + std::abs(z);
        const float far = std::numeric_limits<float>::infinity();
        bounds.min[j] = std::nextafter(float(middle[j] - extent), -far);
        bounds.max[j] = std::nextafter(float(middle[j] + extent), far);
    }
    return bounds;
}

Box3 mesh_bounds(const Mesh& mesh) {
    Box3 box;
    for (const Vec3& p : mesh.positions) box.extendBy(p);
    return box;
}

bool is_endless(const Shape& shape) {
    return shape.kind == ShapeKind::plane && (shape.size.x <= 0 || shape.size.z <= 0);
}

Box3 transformed_box(const Box3& box, const Mat4d& matrix) {
    Box3 result;
    for (int corner = 0; corner < 8 && !box.isEmpty(); ++corner) {
        const Vec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                     corner & 4 ? box.max.z : box.min.z);
        result.extendBy(Vec3(Vec3d(p) * matrix));
    }
    return result;
}

}  // namespace sightline
