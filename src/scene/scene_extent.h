#pragma once
// How far the visible part of a scene reaches in a direction, without a hull being made.
#include "scene/scene.h"

#include <optional>
#include <vector>

namespace sightline {

/// A function of points that a reach is measured by: p·direction or, of a scene that turns about
/// the vertical axis through `axis`, the largest value during a full turn.
struct Reach {
    Vec3d direction;
    std::optional<Vec3d> axis;

    double operator()(const Vec3d& p) const;
    /// The point `p` where this value is reached: turned into the direction if the scene turns.
    Vec3d point(const Vec3d& p) const;
};

/// Whether no light leaves the material towards a camera: its alpha is 0 everywhere.
bool is_invisible(const Material& material);

/// The surfaces that can be seen: all meshes and shapes of instances except endless planes and
/// those whose material is invisible; if nothing else is there, the invisible ones. Refers to the
/// scene.
class SceneExtent {
  public:
    explicit SceneExtent(const Scene& scene);

    bool is_empty() const { return parts_.empty(); }

    /// The farthest point. The scene must not be empty. The work is about that of comparing a box
    /// for every 1024 vertices.
    Vec3d farthest(const Reach& reach) const;

  private:
    /// A mesh or shape of an instance.
    struct Part {
        uint32_t geometry;
        Mat4d to_world;
        Box3 box;  ///< in object space
    };

    void add_parts(bool visible);
    void add_boxes();
    void search_mesh(const Part& part, const Reach& reach, double& best, Vec3d& point) const;
    void search_shape(const Part& part, const Reach& reach, double& best, Vec3d& point) const;

    const Scene& scene_;
    std::vector<Part> parts_;
    std::vector<Box3> boxes_;            // of the runs of vertices of all meshes in use
    std::vector<uint32_t> first_boxes_;  // by mesh: into boxes_; `none` if it is not in use
};

}  // namespace sightline
