#pragma once
// Scenes made in code; scene/gltf/load.h reads them from files.
#include "scene/scene.h"

namespace sightline {

/// A group transformed by an affine matrix. One without an inverse gets the identity for it.
Instance make_instance(uint32_t group, const Mat4& object_to_world);

/// Builds a Scene from materials, meshes, shapes, instances, lights and cameras.
///
///     SceneBuilder builder;
///     const uint32_t red = builder.add_material(material);
///     builder.add_instance(builder.add_mesh(quad_mesh(corner, edge, other_edge), red));
///     const Scene scene = builder.finish();
class SceneBuilder {
  public:
    /// Starts with glTF's default material, which has index 0.
    SceneBuilder();

    /// Returns the material's index.
    uint32_t add_material(const Material& material);

    /// Adds a group of one mesh with this material; returns the group. Normals and tangents stay as
    /// they are: a mesh without normals is shaded flat.
    uint32_t add_mesh(Mesh mesh, uint32_t material = 0);

    /// Adds a group of one shape with this material; returns the group. `shape.to_object` must have
    /// an inverse; `shape.to_shape` is ignored.
    uint32_t add_shape(Shape shape, uint32_t material = 0);

    /// Adds a group of meshes and shapes, each with the material in its own field; returns the
    /// group.
    uint32_t add_group(std::vector<Mesh> meshes, std::vector<Shape> shapes = {});

    /// Draws a group as it is: it is baked, its coordinates are in world space.
    void add_instance(uint32_t group);

    /// Draws a group transformed by an affine matrix.
    void add_instance(uint32_t group, const Mat4& object_to_world);

    void add_light(const Light& light);
    void add_camera(const Camera& camera);

    /// Computes the bounds and returns the scene. The last call of a builder.
    Scene finish();

  private:
    Scene scene_;
};

}  // namespace sightline
