#include "scene/gltf/placement.h"

#include "scene/gltf/accessor.h"
#include "scene/gltf/mesh.h"
#include "scene/gltf/nodes.h"
#include "scene/gltf/pose.h"
#include "scene/gltf/shapes.h"
#include "scene/shape_bounds.h"

#include <fmt/format.h>

namespace sightline {
namespace {

bool is_in_range(const Vec3d& p) {
    const double limit = double(max_coordinate);
    return std::abs(p.x) <= limit && std::abs(p.y) <= limit && std::abs(p.z) <= limit;
}

Box3d transformed(const Box3& box, const Mat4d& matrix) {
    Box3d result;
    for (int corner = 0; corner < 8 && !box.isEmpty(); ++corner) {
        const Vec3d p(double(corner & 1 ? box.max.x : box.min.x),
                      double(corner & 2 ? box.max.y : box.min.y),
                      double(corner & 4 ? box.max.z : box.min.z));
        result.extendBy(transform_point(p, matrix));
    }
    return result;
}

/// Collects the bounds of a scene in double.
class Placer {
  public:
    Placer(Document& document, Placement& placement)
        : document_(document), placement_(placement), world_(world_matrices(document)) {}

    void add(uint32_t node) {
        const GltfNode& source = document_.nodes[node];
        if (source.mesh != none) {
            const std::vector<Mat4d> matrices =
                source.skin == none ? instance_matrices(document_, node, world_[node])
                                    : joint_matrices(document_.skins[source.skin], world_);
            for (const GltfPrimitive& primitive : document_.meshes[source.mesh].primitives)
                add_primitive(primitive, matrices);
        }
        if (const std::optional<Shape> shape = node_shape(document_, node)) {
            if (is_endless(*shape)) return;
            for (const Mat4d& m : instance_matrices(document_, node, world_[node]))
                extend_if_in_range(transformed(shape_bounds(*shape), m));
        }
    }

    const Box3d& bounds() const { return bounds_; }

  private:
    void add_primitive(const GltfPrimitive& primitive, const std::vector<Mat4d>& matrices) {
        const auto found = primitive.attributes.find("POSITION");
        if (found == primitive.attributes.end()) return;
        const uint32_t accessor = found->second;
        const GltfAccessor& positions = document_.accessors[accessor];
        if (positions.dropped || positions.components() != 3) return;  // reported when it is read
        const Box3 box = position_bounds(accessor);
        for (const Mat4d& matrix : matrices) {
            if (!extend_if_in_range(transformed(box, matrix)))
                add_vertices_in_range(accessor, matrix);
        }
    }

    bool extend_if_in_range(const Box3d& box) {
        const bool in_range = box.isEmpty() || (is_in_range(box.min) && is_in_range(box.max));
        if (in_range) bounds_.extendBy(box);
        return in_range;
    }

    std::vector<Vec3> positions(uint32_t accessor) {
        return read_floats<Vec3>(document_, accessor, Fault::primitive,
                                 fmt::format("accessors[{}]", accessor));
    }

    Box3 position_bounds(uint32_t accessor) {
        const auto [entry, is_new] = placement_.position_bounds.try_emplace(accessor);
        if (!is_new) return entry->second;
        try {
            for (const Vec3& p : positions(accessor))
                if (is_finite(p)) entry->second.extendBy(p);
        } catch (const FaultyPart&) {
            entry->second = {};  // reported when it is read for the scene
        }
        return entry->second;
    }

    void add_vertices_in_range(uint32_t accessor, const Mat4d& matrix) {
        const ReadBudget budget = document_.budget;  // the vertices have been charged
        for (const Vec3& p : positions(accessor)) {
            const Vec3d placed = transform_point(Vec3d(p), matrix);
            if (is_in_range(placed)) bounds_.extendBy(placed);
        }
        document_.budget = budget;
    }

    Document& document_;
    Placement& placement_;
    std::vector<Mat4d> world_;
    Box3d bounds_;
};

}  // namespace

Placement place_scene(Document& document, const LoadOptions& options) {
    const ReadBudget budget = document.budget;  // what is read here is read again for the scene
    Placement placement;
    Placer placer(document, placement);
    for (const uint32_t node : visible_nodes(document, options)) placer.add(node);
    placement.frame = choose_frame(placer.bounds());
    if (!placer.bounds().isEmpty())
        placement.radius = placer.bounds().size().length() / 2 * placement.frame.scale;
    document.budget = budget;
    return placement;
}

Frame object_frame(const Box3& bounds, const Mat4d& matrix, bool instanced,
                   const Placement& placement) {
    if (bounds.isEmpty()) return {};
    Frame frame = choose_frame({Vec3d(bounds.min), Vec3d(bounds.max)});
    const double distance = transform_vector(frame.origin, matrix).length();
    if (!instanced || distance <= far_in_radii * placement.radius) frame.origin = Vec3d(0);
    return frame;
}

}  // namespace sightline
