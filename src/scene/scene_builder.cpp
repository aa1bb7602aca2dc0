#include "scene/scene_builder.h"

#include "scene/shape_bounds.h"

#include <cassert>
#include <utility>

namespace sightline {
namespace {

template <class T>
uint32_t append(std::vector<T>& all, T item) {
    all.push_back(std::move(item));
    return static_cast<uint32_t>(all.size() - 1);
}

}  // namespace

Instance make_instance(uint32_t group, const Mat4& object_to_world) {
    const Mat4d matrix(object_to_world);
    Instance instance;
    instance.group = group;
    instance.object_to_world = object_to_world;
    instance.world_to_object = Mat4(matrix.inverse());
    instance.mirrored = matrix.determinant() < 0;
    return instance;
}

SceneBuilder::SceneBuilder() { scene_.materials.emplace_back(); }

uint32_t SceneBuilder::add_material(const Material& material) {
    return append(scene_.materials, material);
}

uint32_t SceneBuilder::add_mesh(Mesh mesh, uint32_t material) {
    mesh.material = material;
    std::vector<Mesh> meshes;
    meshes.push_back(std::move(mesh));
    return add_group(std::move(meshes));
}

uint32_t SceneBuilder::add_shape(Shape shape, uint32_t material) {
    shape.material = material;
    return add_group({}, {std::move(shape)});
}

uint32_t SceneBuilder::add_group(std::vector<Mesh> meshes, std::vector<Shape> shapes) {
    Group group;
    for (Mesh& mesh : meshes) {
        assert(mesh.material < scene_.materials.size());
        mesh.positions.reserve(mesh.positions.size() + 1);
        group.meshes.push_back(append(scene_.meshes, std::move(mesh)));
    }
    for (Shape& shape : shapes) {
        assert(shape.material < scene_.materials.size());
        shape.to_shape = shape.to_object.inverse();
        group.shapes.push_back(append(scene_.shapes, std::move(shape)));
    }
    return append(scene_.groups, std::move(group));
}

void SceneBuilder::add_instance(uint32_t group) {
    assert(group < scene_.groups.size());
    Instance& instance = scene_.instances.emplace_back();
    instance.group = group;
    instance.baked = true;
}

void SceneBuilder::add_instance(uint32_t group, const Mat4& object_to_world) {
    assert(group < scene_.groups.size());
    scene_.instances.push_back(make_instance(group, object_to_world));
}

void SceneBuilder::add_light(const Light& light) { scene_.lights.push_back(light); }

void SceneBuilder::add_camera(const Camera& camera) { scene_.cameras.push_back(camera); }

Scene SceneBuilder::finish() {
    std::vector<Box3> boxes;  // of each mesh and shape, in object space
    for (const Mesh& mesh : scene_.meshes) boxes.push_back(mesh_bounds(mesh));
    for (const Shape& shape : scene_.shapes)
        boxes.push_back(is_endless(shape) ? Box3() : shape_bounds(shape));
    const size_t first_shape = scene_.meshes.size();
    for (const Instance& instance : scene_.instances) {
        const Mat4d matrix(instance.object_to_world);
        const Group& group = scene_.groups[instance.group];
        for (const uint32_t m : group.meshes)
            scene_.bounds.extendBy(transformed_box(boxes[m], matrix));
        for (const uint32_t s : group.shapes)
            scene_.bounds.extendBy(transformed_box(boxes[first_shape + s], matrix));
    }
    return std::move(scene_);
}

}  // namespace sightline
