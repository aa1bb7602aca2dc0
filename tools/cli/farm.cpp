// What the jobs of a farm run; `sightline batch --farm` submits them.
#include "batch/farm.h"
#include "batch/contact_sheet.h"
#include "batch/report.h"
#include "commands.h"
#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <memory>

namespace sightline {
namespace {

std::atomic<int> farm_interrupts{0};

size_t array_element() {
    const char* text = std::getenv("SLURM_ARRAY_TASK_ID");
    if (!text)
        throw Error("SLURM_ARRAY_TASK_ID is not set: this command runs in a job of an array");
    return std::strtoull(text, nullptr, 10);
}

int part(const std::string& folder) {
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { ++farm_interrupts; });
    return run_farm_part(folder, array_element(), &farm_interrupts);
}

int merge(const std::string& folder) {
    const FarmResult result = merge_farm(folder);
    if (result.resubmitted) {
        fmt::print("submitted the missing pictures again\n");
        return 0;
    }
    write_contact_sheet(folder, result.tasks, result.outcomes, result.compare_to);
    const size_t missing = result.tasks.size() - result.outcomes.size();
    const auto failed = std::ranges::count_if(
        result.outcomes, [](const Outcome& o) { return !has_picture(o.verdict); });
    const auto blank = std::ranges::count_if(result.outcomes,
                                             [](const Outcome& o) { return is_blank(o.verdict); });
    const auto changed = std::ranges::count_if(
        result.outcomes, [](const Outcome& o) { return is_different(o.change); });
    fmt::print(
        "{} pictures, {} failed, {} missing, {} changed{}{}\n", result.tasks.size(), failed,
        missing, changed, blank ? fmt::format(", {} empty or black", blank) : "",
        result.passed_over ? fmt::format(", inputs passed over: {}", result.passed_over) : "");
    fmt::print("{}", describe_warnings(result.outcomes));
    const int status = missing ? 1 : failed || (changed && result.fail_on_change) ? 3 : 0;
    finish_farm(folder, status);
    return status;
}

void add(CLI::App& app, const char* name, int (*run)(const std::string& folder)) {
    const auto folder = std::make_shared<std::string>();
    CLI::App* sub = app.add_subcommand(name, "Run by the jobs of `batch --farm`");
    sub->group("");  // hidden
    sub->add_option("--out", *folder, "Folder of the batch")->required()->type_name("DIR");
    sub->callback([folder, run] {
        if (const int status = run(*folder)) throw CLI::RuntimeError(status);
    });
}

}  // namespace

void add_farm_commands(CLI::App& app) {
    add(app, "farm-part", part);
    add(app, "farm-merge", merge);
}

}  // namespace sightline
