#pragma once
#include "batch/task.h"

#include <string>
#include <vector>

namespace sightline {

/// Writes `folder`/index.html, a self-contained page that lists every picture with thumbnail,
/// verdict, warnings and times, and can sort and filter them.
/// `compare_to`: folder of the earlier batch, for links to its pictures; empty: none.
void write_contact_sheet(const std::string& folder, const std::vector<Task>& tasks,
                         const std::vector<Outcome>& outcomes, const std::string& compare_to);

}  // namespace sightline
