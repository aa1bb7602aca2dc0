#pragma once
#include "intersect/methods/triangles.h"

#include <functional>
#include <vector>

namespace sightline {

/// Replaces the boxes of long diagonal triangles by several around parts of them, after Karras and
/// Aila, Fast Parallel Construction of High-Quality Bounding Volume Hierarchies, 2013, section 4.
/// boxes[i] is around the triangle numbers[i]; at most three for ten are added, behind the
/// others. Each point of a triangle stays in one of its boxes, so a tree over them may miss none.
void split_boxes(std::vector<Box3>& boxes, std::vector<uint32_t>& numbers,
                 const std::function<Corners<float>(uint32_t number)>& corners);

}  // namespace sightline
