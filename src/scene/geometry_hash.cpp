#include "scene/geometry_hash.h"

#include "core/hash.h"

namespace sightline {
namespace {

/// Chains the bytes of arrays; the types have no padding.
class Hasher {
  public:
    template <class T>
    void add(std::span<const T> values) {
        const uint64_t count = values.size();
        hash_ = hash_bytes(std::as_bytes(std::span(&count, 1)), hash_);
        hash_ = hash_bytes(std::as_bytes(values), hash_);
    }
    template <class T>
    void add(const std::vector<T>& values) {
        add(std::span(values));
    }
    template <class T>
    void add(const T& value) {
        add(std::span(&value, 1));
    }
    uint64_t result() const { return hash_; }

  private:
    uint64_t hash_ = 0;
};

void add_shape(const Shape& shape, Hasher& hasher) {
    hasher.add(static_cast<uint32_t>(shape.kind));
    for (const float length : {shape.radius, shape.tube_radius, shape.height, shape.radius_top,
                               shape.radius_bottom, shape.scale})
        hasher.add(length);
    hasher.add(shape.size);
    hasher.add(shape.to_object);
    hasher.add(shape.to_shape);
}

}  // namespace

uint64_t hash_geometry(const Scene& scene) {
    Hasher hasher;
    hasher.add(scene.frame.origin);
    hasher.add(scene.frame.scale);
    for (const Mesh& mesh : scene.meshes) {
        hasher.add(mesh.positions);
        hasher.add(mesh.triangles);
    }
    for (const Shape& shape : scene.shapes) add_shape(shape, hasher);
    for (const Group& group : scene.groups) {
        hasher.add(group.meshes);
        hasher.add(group.shapes);
    }
    for (const Instance& instance : scene.instances) {
        hasher.add(instance.group);
        hasher.add(uint8_t{instance.baked});
        hasher.add(instance.object_to_world);
    }
    return hasher.result();
}

}  // namespace sightline
