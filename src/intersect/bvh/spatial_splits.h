#pragma once
#include "intersect/methods/triangles.h"

#include <functional>
#include <vector>

namespace sightline {

/// Replaces the boxes of long diagonal triangles by several boxes around parts of them, after
/// Karras and Aila, Fast Parallel Construction of High-Quality Bounding Volume Hierarchies, 2013,
/// section
/// 4. boxes[i] bounds triangle numbers[i]; at most 30 % more boxes are appended. Each point of a
/// triangle stays in one of its boxes, so a BVH over them misses none.
void split_boxes(std::vector<Box3>& boxes, std::vector<uint32_t>& numbers,
                 const std::function<Corners<float>(uint32_t number)>& corners);

}  // namespace sightline
