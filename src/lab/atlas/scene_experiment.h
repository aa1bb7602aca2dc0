#pragma once
// Rays against a scene: every engine takes part, and the referee decides.
#include "intersect/embree/embree.h"
#include "lab/atlas/experiment.h"

namespace sightline {

/// A scene and rays that are difficult for it.
struct SceneRays {
    Scene scene;
    std::vector<Ray> rays;
};

/// A scene with its referee; neither copied nor moved, since the referee points to the scene.
struct RefereedScene {
    const Scene scene;
    const Referee referee;

    explicit RefereedScene(Scene s) : scene(std::move(s)), referee(scene) {}
    RefereedScene(const RefereedScene&) = delete;
    RefereedScene& operator=(const RefereedScene&) = delete;
};

/// The engines that take part.
std::vector<std::string> scene_methods();

/// `embree` says how Embree builds.
Experiment make_scene_experiment(SceneRays input, const EmbreeOptions& embree = {});

}  // namespace sightline
