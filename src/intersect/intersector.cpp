#include "intersect/intersector.h"

namespace sightline {

bool is_translucent(const Material& material) {
    return material.alpha_mode != AlphaMode::opaque || material.transmission_factor > 0;
}

}  // namespace sightline
