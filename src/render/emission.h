#pragma once
#include "scene/scene.h"

namespace sightline {

/// Whether surfaces of the material light others.
inline bool emits(const Material& m) { return max_component(m.emissive_factor) > 0 && !m.unlit; }

}  // namespace sightline
