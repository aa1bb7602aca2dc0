#pragma once
#include "intersect/intersector.h"

#include <string_view>

namespace sightline {

/// An engine that decides by one of triangle_methods(); `name` as in make_reference. Throws Error.
std::unique_ptr<Intersector> make_method_tree(const Scene& scene, std::string_view name);

}  // namespace sightline
