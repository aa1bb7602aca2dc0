#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace sightline {

/// A progress bar on stderr with percentage and remaining time, if `show` and stderr is a terminal.
/// `advance` is thread-safe and cheap.
class Progress {
  public:
    Progress(std::string label, uint64_t total, bool show);
    ~Progress();
    Progress(const Progress&) = delete;

    void advance(uint64_t done = 1);

  private:
    void draw(uint64_t done);

    std::string label_;
    uint64_t total_;
    bool show_;
    std::atomic<uint64_t> done_{0};
    std::chrono::steady_clock::time_point start_;
    std::mutex drawing_;
    std::chrono::steady_clock::time_point last_;
};

}  // namespace sightline
