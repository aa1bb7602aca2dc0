#pragma once
// A comparison as files: results.json, results.csv and a page that needs nothing else.
#include "lab/compare/screen_maps.h"

#include <nlohmann/json_fwd.hpp>

namespace sightline {

/// What a report says beside the comparison itself.
struct ReportContext {
    std::string command;     ///< the whole command line
    std::string replay;      ///< a command that takes --ray and --methods behind it
    std::string production;  ///< name of the engine that a render of this scene uses
    double max_wrong = 0;    ///< what that engine is allowed, per million
    std::string picture;     ///< of what: the scene's path
    Image rendered;          ///< 8-bit RGB; empty: none
    PixelRect window;        ///< of `rendered`
};

/// The whole of results.json (docs/compare.md lists the fields).
nlohmann::ordered_json comparison_json(const Comparison& comparison, const ReportContext& context);

/// A line for each engine and kind of ray, and one for both together.
std::string comparison_csv(const Comparison& comparison);

/// The same for the terminal.
std::string comparison_table(const Comparison& comparison);

/// What the engines said of one ray, for the terminal.
std::string ray_text(const Ray& ray, const RayReport& report, std::span<const Engine> engines);

/// Writes the three files into `folder`, which is made where it is not there; each appears whole
/// or not at all, the page last. Throws Error.
void write_comparison(const std::string& folder, const Comparison& comparison, const Scene& scene,
                      const Referee& referee, std::span<const RecordedRay> rays,
                      std::span<const Engine> engines, const ReportContext& context);

}  // namespace sightline
