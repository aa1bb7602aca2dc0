#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sightline {

/// How this process shows progress on stderr.
enum class ProgressForm {
    automatic,  ///< a bar, if stderr is a terminal
    off,
    json  ///< lines for programs, whatever stderr is
};

/// Chooses the form; to be called before the first progress is shown.
void set_progress_form(ProgressForm form);
ProgressForm progress_form();

/// Adds to a line of progress the seconds `spent` so far and, `part` in [0,1] of all being done,
/// those that are left: `elapsed_s` and `eta_s`, which is null if nothing is done.
void add_progress_times(nlohmann::ordered_json& fields, double spent, double part);

/// Writes an object as a line of JSON to stderr.
void write_progress_line(const nlohmann::ordered_json& fields);

/// What a progress is of.
struct ProgressName {
    std::string name;              ///< empty: the stage says it
    size_t number = 0, count = 0;  ///< of one among several; count 0: it is the only one
};

/// The progress of one stage of the work: a bar with percentage and remaining time if `show`, or
/// lines of JSON, at most four a second, the first before anything is done and the last after all.
/// `advance` is thread-safe and cheap.
class Progress {
  public:
    Progress(std::string stage, ProgressName name, uint64_t total, bool show);
    ~Progress();
    Progress(const Progress&) = delete;

    void advance(uint64_t done = 1);

  private:
    using Clock = std::chrono::steady_clock;
    void show(uint64_t done);
    void draw(double part, double spent) const;
    void write_line(uint64_t done, double part, double spent) const;

    std::string stage_;
    ProgressName name_;
    uint64_t total_;
    bool bar_, json_;
    std::atomic<uint64_t> done_{0};
    Clock::time_point start_;
    std::mutex showing_;
    Clock::time_point last_;
};

}  // namespace sightline
