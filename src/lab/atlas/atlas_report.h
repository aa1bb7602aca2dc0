#pragma once
// What the atlas writes. docs/atlas.md describes the formats.
#include "lab/atlas/atlas.h"

#include <nlohmann/json.hpp>

namespace sightline {

/// The document results.json.
nlohmann::ordered_json atlas_json(const std::vector<FamilyScore>& scores,
                                  const AtlasOptions& options, double max_wrong);

/// Writes results.json, results.csv, index.html and the charts to the folder, which exists.
/// Throws Error.
void write_atlas(const std::string& folder, const std::vector<FamilyScore>& scores,
                 const AtlasOptions& options, double max_wrong);

/// The knob at which each method first fails, for choosing methods by a scene's knobs.
nlohmann::ordered_json atlas_breakdown(const std::vector<FamilyScore>& scores,
                                       const AtlasOptions& options);

/// For a terminal: methods against families, the knob at which each first fails.
std::string atlas_table(const std::vector<FamilyScore>& scores);

}  // namespace sightline
