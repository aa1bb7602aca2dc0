#pragma once
#include "output/poses.h"
#include "render_movies.h"

#include <stop_token>
#include <vector>

namespace sightline {

/// Where the cameras of the pictures are written.
struct PosesOptions {
    std::string path;  ///< empty: nowhere
    PosesForm form = PosesForm::sightline;
};

/// The pictures that one command makes, each with a command of its own, and the films of them.
struct RenderPlan {
    std::vector<RenderCommand> commands;
    RenderMovies movies;
    /// Whether the pictures are frames of films and nothing else.
    bool only_movies = false;
    PosesOptions poses;
    std::vector<PosedPicture> posed;  ///< by picture; the names are set
    bool several = false;             ///< views, frames or steps of a turntable
};

/// What `render` says beside warnings and errors.
struct ReportOptions {
    bool explain = false;  ///< what the scene needs
    bool quiet = false;    ///< neither progress nor summaries
    bool names = true;     ///< on standard output, of what was written
};

/// Renders the pictures of a plan one after the other, from one asset in memory, and makes its
/// films. Throws Error, after a stop request, too.
void run_plan(RenderPlan& plan, const ReportOptions& options, std::stop_token stop);

}  // namespace sightline
