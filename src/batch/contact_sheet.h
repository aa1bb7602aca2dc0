#pragma once
#include "batch/task.h"

#include <string>
#include <vector>

namespace sightline {

/// The page's name within the batch's folder.
inline constexpr const char* contact_sheet_name = "index.html";

/// Writes the page: it shows the pictures of each asset side by side, with verdicts, warnings and
/// times, can sort and filter them, and leads to the pictures. Thumbnails are files of the private
/// folder, which the page loads as they come into view.
/// `compare_to`: folder of the earlier batch, for links to its pictures; empty: none.
void write_contact_sheet(const std::string& folder, const std::vector<Task>& tasks,
                         const std::vector<Outcome>& outcomes, const std::string& compare_to);

}  // namespace sightline
