#pragma once
#include "render/settings.h"

namespace sightline {

/// What the scene's things are called in the layers of a picture; empty where the settings asks for
/// none of these layers.
struct LayerNames {
    std::vector<std::string> light_groups;  ///< each once; a light may share one of the two below
    std::vector<uint16_t> group_of_light;   ///< by Scene::lights: lights of one name are one group
    uint16_t environment = 0;               ///< and backgrounds
    uint16_t emission = 0;                  ///< of surfaces
    std::vector<uint32_t> object_ids;       ///< Cryptomatte's, by Scene::instances
    std::vector<uint32_t> material_ids;     ///< by Scene::materials
};

LayerNames make_layer_names(const Scene& scene, const RenderSettings& settings);

}  // namespace sightline
