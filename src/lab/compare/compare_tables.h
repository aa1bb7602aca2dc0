#pragma once
// A comparison as text, for spreadsheets and the terminal.
#include "lab/compare/compare.h"

namespace sightline {

/// CSV with one line per engine and kind of ray, and one for their total.
std::string comparison_csv(const Comparison& comparison);

/// The same rows as a table for the terminal.
std::string comparison_table(const Comparison& comparison);

/// The truth and all answers for one ray, for the terminal.
std::string ray_text(const Ray& ray, const RayReport& report, std::span<const Engine> engines);

/// What was compared, who is right, and who is fastest: a sentence each. `scene`: its path.
std::vector<std::string> summary_sentences(const Comparison& comparison, const std::string& scene);

}  // namespace sightline
