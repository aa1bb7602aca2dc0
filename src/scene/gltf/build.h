#pragma once
// Internal to src/scene.
#include "scene/gltf/placement.h"

namespace sightline {

/// What the meshes of one or more nodes with the same mesh depend on, beside the file.
struct UsePose {
    uint32_t mesh = none;
    bool skinned = false;
    std::vector<Mat4d> joints;    ///< of its skin
    std::vector<float> weights;   ///< of its morph targets
    Mat4d to_frame;               ///< from object space to the frame of its vertices
    std::optional<Mat4d> matrix;  ///< from there to world space, if the vertices are there

    bool operator==(const UsePose&) const = default;
};

/// The meshes that one use of a mesh has in a scene.
struct BuiltUse {
    UsePose pose;
    std::vector<uint32_t> meshes;  ///< in the scene
    std::vector<Box3> bounds;      ///< of each primitive's vertices, before `pose.matrix`
    bool is_clean = false;         ///< reading them reported nothing
};

/// Builds the scene that the options select, in the frame of its rest pose, at one time after the
/// other. What does not change is read once.
class ScenePoser {
  public:
    /// Reads textures and materials. If `several`, pose() can be called more than once. The
    /// document and the options must outlive it. Throws Error.
    ScenePoser(Document& document, const LoadOptions& options, bool several);

    /// Poses an empty scene, or takes one from its last pose to another. Unset times are those of
    /// LoadOptions. Textures and materials are set in an empty scene alone. Meshes whose vertices
    /// stay keep their arrays. Returns whether any vertex, shape or instance may have moved. Throws
    /// Error, which leaves a scene that cannot be posed again.
    bool pose(std::optional<float> time, Scene& scene);

    /// As the file has them: references to images that turn out to be lost are still there.
    const std::vector<Material>& materials() const { return materials_; }
    const std::vector<Texture>& textures() const { return textures_; }

  private:
    bool add_meshes(const std::vector<uint32_t>& nodes, const std::vector<Mat4d>& world,
                    Scene& before, Scene& scene);

    Document& document_;
    const LoadOptions& options_;
    Placement placement_;
    std::optional<uint32_t> variant_;
    std::vector<Texture> textures_;
    std::vector<Material> materials_;
    std::optional<DocumentState> rest_;  // before it is posed, if it is posed more than once
    std::vector<BuiltUse> built_;        // of the last pose
};

}  // namespace sightline
