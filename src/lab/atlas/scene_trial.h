#pragma once
// Rays against a scene: every engine there is, judged by the referee.
#include "intersect/embree/embree.h"
#include "lab/atlas/trial.h"

namespace sightline {

/// A scene that owns its triangles, and rays that are hard for it.
struct SceneQueries {
    Scene scene;
    std::vector<Ray> rays;
    bool coherent = true;  ///< how the engines are called
};

/// The engines that take part in trials over scenes.
std::vector<std::string> scene_trial_methods();

/// `embree` says how Embree builds.
std::unique_ptr<Trial> make_scene_trial(SceneQueries queries, const EmbreeOptions& embree = {});

}  // namespace sightline
