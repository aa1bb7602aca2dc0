#include "commands.h"
#include "core/error.h"
#include "core/files.h"
#include "core/message.h"
#include "lab/atlas/atlas_report.h"
#include "lab/charts.h"
#include "options.h"
#include "output/output_folder.h"
#include "progress_option.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>

namespace sightline {
namespace {

struct AtlasCommand {
    AtlasOptions options;
    std::string report, breakdown;
    double max_wrong = 1;
    bool overwrite = false, quiet = false;
};

void run(AtlasCommand& command) {
    try {
        check_atlas_names(command.options);
    } catch (const Error& e) {
        throw CLI::ValidationError(e.what());
    }
    // Before the long work, so that a bad folder fails at once.
    if (!command.options.dump.empty()) make_output_folder(command.options.dump, "--dump");
    for (const auto& [name, folder] : command.options.answers)
        if (!std::filesystem::is_directory(folder))
            throw CLI::ValidationError("--answers", "there is no folder " + folder);
    if (!command.report.empty()) claim_report(command.report, command.overwrite);
    command.options.show_progress = !command.quiet;
    const auto scores = run_atlas(command.options);
    if (!command.report.empty())
        write_atlas(command.report, scores, command.options, command.max_wrong);
    if (!command.breakdown.empty())
        write_text(command.breakdown, atlas_breakdown(scores, command.options).dump(1) + '\n');
    if (!command.quiet) fmt::print("{}", atlas_table(scores));
    const double worst = worst_of_production(scores);
    if (worst > command.max_wrong) {
        print_message("sightline: {} is wrong on a fraction of {:.3g} at worst, more than {:g}\n",
                      production_method, worst, command.max_wrong);
        throw CLI::RuntimeError(4);
    }
}

}  // namespace

void add_atlas_command(CLI::App& app) {
    const auto command = std::make_shared<AtlasCommand>();
    AtlasOptions& options = command->options;
    CLI::App* sub = app.add_subcommand(
        "atlas", "Try every intersection method on deliberately difficult rays, judged exactly");
    begin_group(*sub, "Experiments");
    sub->add_option("--families", options.families, "Families, by name or first part of a name")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME,...")
        ->default_str("all");
    sub->add_option("--methods", options.methods, "Intersection methods")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("NAME,...")
        ->default_str("all");
    add_number(*sub, "--rays", options.rays, "N", "Rays per knob value", size_t{1},
               size_t{100000000});
    add_number(*sub, "--seed", options.seed, "N", "Seed of the random numbers", uint64_t{0});
    add_number(*sub, "--rounds", options.rounds, "N",
               "Rounds of timing, in which methods alternate", 1, 100);
    begin_group(*sub, "Engines of other programs (docs/engines.md)");
    sub->add_option("--dump", options.dump,
                    "Write the scenes and rays of families of triangles to this folder")
        ->type_name("DIR");
    add_named_paths(*sub, "--answers", "NAME=DIR",
                    "Judge another program's answers to dumped rays; repeatable", options.answers);
    begin_group(*sub, "Output");
    sub->add_option("--report", command->report,
                    "Folder for results.json, results.csv and index.html")
        ->type_name("DIR");
    add_overwrite_option(*sub, command->overwrite);
    sub->add_option("--breakdown", command->breakdown,
                    "Write the knob values at which Embree's default mode first fails, as JSON")
        ->type_name("FILE");
    add_number(*sub, "--max-wrong", command->max_wrong, "FRACTION",
               "Exit with 4 if Embree, as renders use it, is wrong on more than this fraction of "
               "the rays of a knob value",
               0.0, 1.0);
    begin_group(*sub, "Other");
    add_progress_option(*sub);
    sub->add_flag("--quiet", command->quiet, "Print no progress and no table");
    sub->footer("Try `sightline atlas --families mirrors --rays 1000`.");
    sub->callback([command] { run(*command); });
}

}  // namespace sightline
