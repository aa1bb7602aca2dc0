#pragma once
// A comparison as files: results.json, results.csv and a self-contained HTML page.
#include "lab/compare/screen_maps.h"

namespace sightline {

/// The part of a report that is not in the comparison.
struct ReportContext {
    std::string command;     ///< the whole command line
    std::string replay;      ///< a command to which --ray and --methods can be appended
    std::string production;  ///< name of the engine that renders this scene
    double max_wrong = 0;    ///< limit for that engine, wrong rays per million
    std::string scene;       ///< path
    Image rendered;          ///< 8-bit RGB; empty: none
    PixelRect window;        ///< of `rendered`
};

/// Writes the three files into `folder`, which must exist; each appears whole or not at all, the
/// page last. Throws Error.
void write_comparison(const std::string& folder, const Comparison& comparison, const Scene& scene,
                      const Referee& referee, std::span<const RecordedRay> rays,
                      std::span<const Engine> engines, const ReportContext& context);

}  // namespace sightline
