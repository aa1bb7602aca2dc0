#pragma once
#include "batch/task.h"

#include <string>
#include <vector>

namespace sightline {

/// The page's name within the batch's folder.
inline constexpr const char* contact_sheet_name = "index.html";

/// Writes the page: self-contained, it lists every picture with thumbnail, verdict, warnings and
/// times, and can sort and filter them.
/// `compare_to`: folder of the earlier batch, for links to its pictures; empty: none.
void write_contact_sheet(const std::string& folder, const std::vector<Task>& tasks,
                         const std::vector<Outcome>& outcomes, const std::string& compare_to);

}  // namespace sightline
