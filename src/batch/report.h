#pragma once
// Progress and events of a running batch, for people and scripts.
#include "batch/task.h"

#include <chrono>
#include <fstream>
#include <span>
#include <string>

namespace sightline {

/// A progress bar if stderr is a terminal or lines of JSON (see ProgressForm), a line on stderr per
/// failure or blank picture, and the event log.
class BatchReport {
  public:
    /// `log`: file that gets a JSON line per event, appended; empty: none. Throws Error.
    BatchReport(size_t tasks, const std::string& log, bool show_bar);
    ~BatchReport();
    BatchReport(const BatchReport&) = delete;

    void task_started(const Task& task, unsigned threads);
    void task_finished(const Outcome& outcome);
    /// Shows how far the batch is, from time to time.
    void update_bar();

  private:
    void log_event(nlohmann::json fields);
    void clear_bar();
    void write_progress(double spent);

    std::string log_path_;
    std::ofstream log_;
    size_t tasks_, done_ = 0, failed_ = 0, skipped_ = 0;
    bool show_bar_, drawn_ = false;
    std::chrono::steady_clock::time_point start_, written_{};
};

/// A line about the pictures that have warnings: how many, how many of them were drawn with faults,
/// and in how many pictures the three most frequent kinds are: a fault's name, or a warning's text
/// in quotes. Empty if there are none.
std::string describe_warnings(std::span<const Outcome> outcomes);

/// A line with the stages in which the workers spent their time, the longest first. Empty if no
/// picture was rendered.
std::string describe_stages(std::span<const Outcome> outcomes);

}  // namespace sightline
