#pragma once
#include <string>

namespace sightline {

/// Draws the charts of `folder`/results.json beside it (chart-*.svg and .png) by the script
/// tools/charts, which needs python3 with matplotlib. Returns HTML: the drawings, or, where they
/// cannot be made, a line that says how to get them.
std::string draw_charts(const std::string& folder);

}  // namespace sightline
