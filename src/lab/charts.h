#pragma once
#include <nlohmann/json_fwd.hpp>

#include <string>

namespace sightline {

/// Draws the charts of `folder`/results.json beside it (chart-*.svg and .png) by the script
/// tools/charts, which needs python3 with matplotlib, and writes `folder`/index.html: the page
/// with the data (see fill_page) and, in place of its <!--CHARTS-->, the drawings, or, where they
/// cannot be made, a line that says how to get them.
void write_report_page(const std::string& folder, std::string page,
                       const nlohmann::ordered_json& data);

}  // namespace sightline
