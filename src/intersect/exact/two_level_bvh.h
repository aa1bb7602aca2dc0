#pragma once
// The scene as the reference tree sees it: one tree over all that is baked, one for each group
// that is placed by a matrix, one over the placements.
#include "core/ray.h"
#include "exact/referee.h"
#include "exact/triangle.h"
#include "intersect/bvh/traversal_kernel.h"
#include "scene/scene.h"

#include <algorithm>

namespace sightline {

/// A mesh within a tree.
struct TreePart {
    uint32_t geometry;
    uint32_t instance;  ///< none where the tree is placed several times
    uint32_t first;     ///< the number of its first triangle in the tree
};

/// Triangles of several meshes with the tree over them.
struct MeshTree {
    TriangleTree tree;
    std::vector<TreePart> parts;

    /// The triangle of that number.
    SurfaceId surface(uint32_t triangle) const {
        const auto next = std::upper_bound(
            parts.begin(), parts.end(), triangle,
            [](uint32_t number, const TreePart& part) { return number < part.first; });
        const TreePart& part = next[-1];
        return {part.instance, part.geometry, triangle - part.first};
    }
};

/// The way from the world into the space of a tree or a shape, in double.
struct Entry {
    Vec3d translation;  ///< subtracted first
    Imath::M33d from_world;
    double residual = 0;  ///< bounds the elements of M·M⁻¹ − 1

    /// The ray there, rounded to floats, with bounds of all errors.
    LocalRay enter(const Vec3d& origin, const Vec3d& direction, float tnear) const;
};

/// One thing that must be asked by itself.
struct PlacedObject {
    enum class Kind : uint8_t { meshes, shape, triangle };

    Kind kind;
    uint32_t instance;
    uint32_t index;          ///< meshes: the tree; shape, triangle: the geometry
    uint32_t primitive = 0;  ///< of a triangle
};

/// All trees of a scene. Plain data, built once.
class PlacedScene {
  public:
    /// Triangles are split where the scene's shape asks for it, unless that is ruled out.
    explicit PlacedScene(const Scene& scene, bool may_split = true);

    const Scene& scene;
    MeshTree baked;
    std::vector<MeshTree> groups;
    std::vector<PlacedObject> objects;  ///< in the order of the tree's units
    BoxTree object_tree;
    std::vector<SurfaceId> unbounded;  ///< triangles too large for float boxes: asked always
    std::vector<Entry> entries;        ///< of each instance; unused where it is baked
    std::vector<uint8_t> translucent;  ///< by geometry

    PlacedTriangle triangle(const SurfaceId& id) const;
    size_t memory() const;

  private:
    struct Draft;

    bool may_split_;

    void place(uint32_t instance, std::vector<uint32_t>& tree_of_group, Draft& draft);
};

}  // namespace sightline
