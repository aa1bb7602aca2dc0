#include "batch/report.h"

#include "core/error.h"
#include "core/message.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/version.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace sightline {
namespace {

using nlohmann::json;

std::string now_text() {
    const auto now = std::chrono::system_clock::now();
    const auto milliseconds =
        std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                       fmt::gmtime(std::chrono::system_clock::to_time_t(now)), milliseconds % 1000);
}

// What a warning says of any file: without its place, and N for each number.
std::string kind_of(const std::string& warning) {
    const size_t place = warning.find(": ");
    std::string kind;
    bool in_number = false;
    for (const char c : place == std::string::npos ? warning : warning.substr(place + 2)) {
        const bool is_digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
        if (!is_digit) kind += c;
        if (is_digit && !in_number) kind += 'N';
        in_number = is_digit;
    }
    return fmt::format("\"{}\"", kind);
}

// The kinds of fault that an asset has, and of other warnings of its picture, except why it is
// blank: each such picture is told by itself.
std::set<std::string> warning_kinds(const Outcome& outcome) {
    std::set<std::string> kinds, told;
    for (const FoundFault& fault : outcome.faults) {
        kinds.insert(fault.key);
        told.insert(fault.place + ": " + fault.text);
    }
    size_t count = outcome.warnings.size();
    if (is_blank(outcome.verdict) && count > 0) --count;
    for (size_t i = 0; i < count; ++i)
        if (!told.contains(outcome.warnings[i])) kinds.insert(kind_of(outcome.warnings[i]));
    return kinds;
}

}  // namespace

BatchReport::BatchReport(size_t tasks, const std::string& log, bool show_bar)
    : log_path_(log),
      tasks_(tasks),
      show_bar_(show_bar && progress_form() == ProgressForm::automatic && isatty(STDERR_FILENO)),
      start_(std::chrono::steady_clock::now()) {
    if (!log.empty()) log_.open(log, std::ios::app);
    log_event({{"event", "start"}, {"version", program_version}, {"tasks", tasks}});
}

BatchReport::~BatchReport() {
    clear_bar();
    try {
        log_event({{"event", "end"}, {"done", done_}, {"failed", failed_}, {"skipped", skipped_}});
    } catch (const Error& e) {
        print_message("sightline: {}\n", e.what());
    }
}

void BatchReport::log_event(json fields) {
    if (log_path_.empty()) return;
    fields["time"] = now_text();
    log_ << fields.dump(-1, ' ', false, json::error_handler_t::replace) << '\n' << std::flush;
    if (!log_) throw Error(log_path_ + ": cannot write the log");
}

void BatchReport::task_started(const Task& task, unsigned threads) {
    log_event(
        {{"event", "begin"}, {"name", task.name}, {"asset", task.asset}, {"threads", threads}});
}

void BatchReport::task_finished(const Outcome& outcome) {
    ++done_;
    skipped_ += outcome.skipped;
    json fields = to_json(outcome);
    fields["event"] = "task";
    log_event(std::move(fields));
    // Faults are told together at the end: an asset library may have one in every file.
    if (outcome.verdict == TaskVerdict::ok || outcome.verdict == TaskVerdict::drawn_with_faults)
        return;
    if (!has_picture(outcome.verdict)) ++failed_;
    clear_bar();
    print_message("{}: {}: {}\n", to_string(outcome.verdict), printable(outcome.name),
                  printable(outcome.message));
}

void BatchReport::clear_bar() {
    if (drawn_) print_message("\r\033[K");
    drawn_ = false;
}

void BatchReport::write_progress(double spent) {
    const auto now = std::chrono::steady_clock::now();
    if (done_ < tasks_ && now - written_ < std::chrono::milliseconds(250)) return;
    written_ = now;
    const auto rendered = static_cast<double>(done_ - skipped_);
    const double all = rendered + static_cast<double>(tasks_ - done_);
    nlohmann::ordered_json fields = {{"stage", "batch"},
                                     {"done", done_},
                                     {"total", tasks_},
                                     {"skipped", skipped_},
                                     {"failed", failed_}};
    add_progress_times(fields, spent, all > 0 ? rendered / all : 1);
    write_progress_line(fields);
}

void BatchReport::update_bar() {
    const double spent =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (progress_form() == ProgressForm::json) return write_progress(spent);
    if (!show_bar_) return;
    // Skipped tasks took no time, so the rate counts rendered ones only.
    const auto rendered = static_cast<double>(done_ - skipped_);
    const auto left = static_cast<double>(tasks_ - done_);
    const size_t filled = tasks_ ? done_ * 30 / tasks_ : 30;
    print_message("\r\033[K[{:#<{}}{:.<{}}] {}/{}  {:.1f}/s  {} left  {} failed", "", filled, "",
                  30 - filled, done_, tasks_, rendered / spent,
                  rendered > 0 ? clock_text(left * spent / rendered) : "?", failed_);
    drawn_ = true;
}

std::string describe_warnings(std::span<const Outcome> outcomes) {
    constexpr size_t most = 3;
    size_t warned = 0, faulty = 0;
    std::map<std::string, size_t> counts;  // of pictures, by kind of warning
    for (const Outcome& outcome : outcomes) {
        if (!has_picture(outcome.verdict)) continue;
        const std::set<std::string> kinds = warning_kinds(outcome);
        warned += !kinds.empty();
        faulty += outcome.fault_count > 0;
        for (const std::string& kind : kinds) ++counts[kind];
    }
    if (warned == 0) return "";
    std::vector<std::pair<std::string, size_t>> kinds(counts.begin(), counts.end());
    std::ranges::stable_sort(kinds, std::greater<>(), [](const auto& kind) { return kind.second; });
    std::string list;
    for (size_t i = 0; i < std::min(most, kinds.size()); ++i)
        list += fmt::format("{}{} in {}", i ? ", " : "", kinds[i].first, kinds[i].second);
    if (const size_t more = kinds.size() - std::min(most, kinds.size()))
        list += fmt::format(" and {} more kind{}", more, more > 1 ? "s" : "");
    std::string counted = fmt::format("{} drawn with faults", faulty);
    if (faulty == 0)
        counted = fmt::format("{} with warnings", warned);
    else if (faulty < warned)
        counted = fmt::format("{} with warnings, {} of them drawn with faults", warned, faulty);
    return printable(counted + ": " + list) + "\n";
}

std::string describe_stages(std::span<const Outcome> outcomes) {
    std::map<std::string, double> sums;
    double total = 0;
    for (const Outcome& outcome : outcomes) {
        if (outcome.skipped) continue;
        for (const auto& [stage, seconds] : outcome.stages) {
            sums[stage] += seconds;
            total += seconds;
        }
    }
    if (total <= 0) return "";
    std::vector<std::pair<std::string, double>> stages(sums.begin(), sums.end());
    std::ranges::stable_sort(stages, std::greater<>(),
                             [](const auto& stage) { return stage.second; });
    std::string list;
    for (const auto& [stage, seconds] : stages)
        list +=
            fmt::format("{}{} {:.0f} %", list.empty() ? "" : ", ", stage, 100 * seconds / total);
    return fmt::format("{:.1f} s of work: {}\n", total, list);
}

}  // namespace sightline
