#pragma once
#include "scene/scene.h"

namespace sightline {

/// A hash of what rays can hit, as it is stored: the frame, triangles, shapes and instances, with
/// their indices. Files of rays and answers carry it, because they are about that geometry alone.
uint64_t hash_geometry(const Scene& scene);

}  // namespace sightline
