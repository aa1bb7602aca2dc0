#pragma once
// The atlas's output files and its table. docs/atlas.md describes the formats.
#include "lab/atlas/atlas.h"

#include <nlohmann/json_fwd.hpp>

namespace sightline {

/// The contents of results.json.
nlohmann::ordered_json atlas_json(const std::vector<FamilyScore>& scores,
                                  const AtlasOptions& options, double max_wrong);

/// Writes results.json, results.csv, index.html and the charts to an existing folder. Throws Error.
void write_atlas(const std::string& folder, const std::vector<FamilyScore>& scores,
                 const AtlasOptions& options, double max_wrong);

/// The contents of breakdown.json: the knob value at which each method first fails, by which
/// `needs` chooses Embree's mode for a scene.
nlohmann::ordered_json atlas_breakdown(const std::vector<FamilyScore>& scores,
                                       const AtlasOptions& options);

/// Tables for a terminal: the breakdown of each method in each family.
std::string atlas_table(const std::vector<FamilyScore>& scores);

}  // namespace sightline
