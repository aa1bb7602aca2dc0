#include "core/files.h"
#include "lab/atlas/atlas_report.h"
#include "options.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace sightline {
namespace {

struct AtlasCommand {
    AtlasOptions options;
    std::string report, breakdown;
    double max_wrong = 1;
    bool quiet = false;
};

void run(AtlasCommand& command) {
    // Before the long work, so that a folder that cannot be is told at once.
    if (!command.report.empty()) std::filesystem::create_directories(command.report);
    command.options.show_progress = !command.quiet;
    const auto scores = run_atlas(command.options);
    if (!command.report.empty())
        write_atlas(command.report, scores, command.options, command.max_wrong);
    if (!command.breakdown.empty())
        write_text(command.breakdown, atlas_breakdown(scores, command.options).dump(1) + '\n');
    if (!command.quiet) fmt::print("{}", atlas_table(scores));
    const double worst = worst_of_production(scores);
    if (worst > command.max_wrong) {
        fmt::print(stderr,
                   "sightline: {} is wrong on a fraction of {:.3g} at its worst, more than {:g}\n",
                   production_method, worst, command.max_wrong);
        throw CLI::RuntimeError(4);
    }
}

}  // namespace

void add_atlas_command(CLI::App& app) {
    const auto command = std::make_shared<AtlasCommand>();
    CLI::App* sub = app.add_subcommand(
        "atlas", "Try every intersection method on rays that are hard on purpose, judged exactly");
    sub->add_option("--report", command->report, "Folder for results.json, results.csv, index.html")
        ->type_name("DIR");
    sub->add_option("--families", command->options.families,
                    "Families, by name or by how names begin (default: all)")
        ->delimiter(',')
        ->type_name("NAME,…");
    sub->add_option("--methods", command->options.methods, "Methods (default: all)")
        ->delimiter(',')
        ->type_name("NAME,…");
    sub->add_option("--rays", command->options.rays, "Rays for each knob value")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000000));
    sub->add_option("--seed", command->options.seed, "Of all random numbers")
        ->capture_default_str();
    sub->add_option("--rounds", command->options.rounds, "Of timing, in which methods take turns")
        ->capture_default_str()
        ->check(CLI::Range(1, 100));
    sub->add_option(
           "--max-wrong", command->max_wrong,
           "Exit with 4 where Embree as renders use it errs on a larger fraction of the rays "
           "of any knob value")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1.0));
    sub->add_option("--breakdown", command->breakdown, "Write the breakdown knobs to a file")
        ->type_name("FILE");
    sub->add_flag("--quiet", command->quiet, "No progress and no table");
    sub->callback([command] { run(*command); });
}

}  // namespace sightline
