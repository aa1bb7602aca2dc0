#include "scene/gltf/shapes.h"

#include <fmt/format.h>

namespace sightline {
namespace {

using nlohmann::json;

/// One element of KHR_implicit_shapes.shapes, whose property types have been checked.
class Entry {
  public:
    Entry(const Document& document, size_t index, const json& entry)
        : document_(document),
          place_(fmt::format("extensions.KHR_implicit_shapes.shapes[{}]", index)),
          type_(entry["type"]),
          parameters_(entry.value(type_, json::object())) {}

    const std::string& type() const { return type_; }
    bool has(const char* key) const { return parameters_.contains(key); }

    float positive(const char* key, float otherwise) const {
        const float value = parameters_.value(key, otherwise);
        if (!(value > 0)) fail(key, "is not above 0");
        return value;
    }

    float not_negative(const char* key, float otherwise) const {
        const float value = parameters_.value(key, otherwise);
        if (!(value >= 0)) fail(key, "is below 0");
        return value;
    }

    Vec3 size() const {
        const auto size = parameters_.value("size", std::array<float, 3>{1, 1, 1});
        for (const float extent : size)
            if (!(extent > 0)) fail("size", "is not above 0");
        return {size[0], size[1], size[2]};
    }

    [[noreturn]] void fail(const char* key, const char* reason) const {
        document_.fail_part(Fault::shape, fmt::format("{}.{}.{}", place_, type_, key), reason);
    }

    [[noreturn]] void fail_type() const {
        document_.fail_part(Fault::shape, place_ + ".type",
                            fmt::format("\"{}\" is not supported", type_));
    }

  private:
    const Document& document_;
    std::string place_, type_;
    json parameters_;
};

void read_ends(const Entry& entry, Shape& shape) {
    shape.height = entry.positive("height", shape.height);
    shape.radius_top = entry.not_negative("radiusTop", shape.radius_top);
    shape.radius_bottom = entry.not_negative("radiusBottom", shape.radius_bottom);
    if (shape.radius_top == 0 && shape.radius_bottom == 0)
        entry.fail("radiusTop", "and radiusBottom are both 0");
}

Shape read_shape(const Entry& entry) {
    Shape shape;
    if (entry.type() == "sphere") {
        shape.kind = ShapeKind::sphere;
        shape.radius = entry.positive("radius", shape.radius);
    } else if (entry.type() == "box") {
        shape.kind = ShapeKind::box;
        shape.size = entry.size();
    } else if (entry.type() == "capsule") {
        shape.kind = ShapeKind::capsule;
        read_ends(entry, shape);
    } else if (entry.type() == "cylinder") {
        shape.kind = ShapeKind::cylinder;
        read_ends(entry, shape);
    } else if (entry.type() == "plane") {
        shape.kind = ShapeKind::plane;
        shape.size = {entry.has("sizeX") ? entry.positive("sizeX", 0) : 0, 0,
                      entry.has("sizeZ") ? entry.positive("sizeZ", 0) : 0};
    } else if (entry.type() == "torus") {
        shape.kind = ShapeKind::torus;
        shape.radius = entry.positive("radius", shape.radius);
        shape.tube_radius = entry.positive("tubeRadius", shape.tube_radius);
        if (shape.tube_radius > shape.radius) entry.fail("tubeRadius", "is above radius");
    } else if (entry.type() == "heart") {
        shape.kind = ShapeKind::heart;
        shape.scale = entry.positive("scale", shape.scale);
    } else {
        entry.fail_type();
    }
    return shape;
}

}  // namespace

std::optional<Shape> node_shape(Document& document, uint32_t node) try {
    const json& source = document.json["nodes"][node];
    const json* use = find_extension(source, "SIGHTLINE_implicit_shapes");
    if (!use) return {};
    const size_t index = (*use)["shape"];
    const json& shapes = document.json["extensions"]["KHR_implicit_shapes"]["shapes"];
    Shape shape = read_shape(Entry(document, index, shapes[index]));
    if (use->contains("material")) shape.material = use->value("material", 0u) + 1;
    shape.name = document.nodes[node].name;
    return shape;
} catch (const FaultyPart& part) {
    document.report(part);
    return {};
}

bool transform_shape(Shape& shape, const Mat4d& to_object) {
    // Gauss-Jordan elimination stays accurate if extents differ widely; by default it returns the
    // identity for a singular matrix.
    const Mat4d inverse = to_object.gjInverse();
    shape.to_object = to_object;
    shape.to_shape = inverse;
    return (to_object * inverse).equalWithAbsError(Mat4d(), 1e-6);
}

}  // namespace sightline
