#pragma once
// What the atlas writes. docs/atlas.md describes the formats.
#include "lab/atlas.h"

#include <nlohmann/json.hpp>

namespace sightline {

/// The document results.json.
nlohmann::ordered_json atlas_json(const std::vector<FamilyScore>& scores,
                                  const AtlasOptions& options, double max_wrong);

/// The knob at which each method first fails, for choosing methods by a scene's knobs.
nlohmann::ordered_json atlas_breakdown(const std::vector<FamilyScore>& scores,
                                       const AtlasOptions& options);

/// One line for each family, knob value and method, with a line of names before.
std::string atlas_csv(const std::vector<FamilyScore>& scores);

/// The page index.html: the results, with `charts` (HTML) among them.
std::string atlas_page(const nlohmann::ordered_json& results, const std::string& charts);

/// For a terminal: methods against families, the knob at which each first fails.
std::string atlas_table(const std::vector<FamilyScore>& scores);

}  // namespace sightline
