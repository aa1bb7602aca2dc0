#pragma once
#include "intersect/intersector.h"
#include "intersect/ray_rules.h"

#include <string_view>

namespace sightline {

/// What an intersector in front of another program's library is as well: its library can be called
/// with nothing around it, for timing what the intersector adds.
class LibraryCaller {
  public:
    virtual ~LibraryCaller() = default;

    /// Has the library trace the rays, all of which must be library_takes(). Its answers stay where
    /// it puts them. Returns the name of the function that was called.
    virtual std::string_view trace_bare(std::span<const Ray> rays, bool any_hit,
                                        Coherence coherence) const = 0;
};

/// Whether a library in single precision can take the ray as it is.
inline bool library_takes(const Ray& ray) {
    return is_valid(ray) && !is_extreme(ray.direction) && max_abs_component(ray.origin) < 0x1p40f;
}

}  // namespace sightline
