#pragma once
// Progress and events of a running batch, for people and scripts.
#include "batch/task.h"

#include <chrono>
#include <fstream>
#include <span>
#include <string>

namespace sightline {

/// A progress bar if stderr is a terminal, a line on stderr per failure or blank picture, and the
/// event log.
class BatchReport {
  public:
    /// `log`: file that gets a JSON line per event, appended; empty: none. Throws Error.
    BatchReport(size_t tasks, const std::string& log, bool show_bar);
    ~BatchReport();
    BatchReport(const BatchReport&) = delete;

    void task_started(const Task& task, unsigned threads);
    void task_finished(const Outcome& outcome);
    void update_bar();

  private:
    void log_event(nlohmann::json fields);
    void clear_bar();

    std::string log_path_;
    std::ofstream log_;
    size_t tasks_, done_ = 0, failed_ = 0, skipped_ = 0;
    bool show_bar_, drawn_ = false;
    std::chrono::steady_clock::time_point start_;
};

/// A line about the pictures that were drawn with faults: how many, and in how many pictures the
/// three most frequent kinds of fault are. Empty if there are none.
std::string describe_faults(std::span<const Outcome> outcomes);

/// A line with the stages in which the workers spent their time, the longest first. Empty if no
/// picture was rendered.
std::string describe_stages(std::span<const Outcome> outcomes);

}  // namespace sightline
