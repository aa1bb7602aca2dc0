#pragma once
// What a person or a script sees of a running batch.
#include "batch/task.h"

#include <chrono>
#include <fstream>
#include <string>

namespace sightline {

/// A bar on stderr where that is a terminal, a line for each failure, and the event log.
class BatchReport {
  public:
    /// `log`: file to append a JSON line per event to; empty: none. Throws Error.
    BatchReport(size_t tasks, const std::string& log, bool show_bar);
    ~BatchReport();
    BatchReport(const BatchReport&) = delete;

    void begin(const Task& task, unsigned threads);
    void end(const Outcome& outcome);
    /// Brings the bar up to date.
    void tick();

  private:
    void event(nlohmann::json fields);
    void clear_bar();

    std::string log_path_;
    std::ofstream log_;
    size_t tasks_, done_ = 0, failed_ = 0, skipped_ = 0;
    bool show_bar_, drawn_ = false;
    std::chrono::steady_clock::time_point start_;
};

}  // namespace sightline
