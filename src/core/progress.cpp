#include "core/progress.h"

#include "core/message.h"
#include "core/text.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace sightline {

Progress::Progress(std::string label, uint64_t total, bool show)
    : label_(std::move(label)),
      total_(std::max<uint64_t>(total, 1)),
      show_(show && isatty(STDERR_FILENO)),
      start_(std::chrono::steady_clock::now()),
      last_(start_) {}

Progress::~Progress() {
    if (show_ && last_ != start_) print_message("\r\033[K");
}

void Progress::advance(uint64_t done) {
    const uint64_t now_done = done_.fetch_add(done, std::memory_order_relaxed) + done;
    if (!show_) return;
    const std::unique_lock lock(drawing_, std::try_to_lock);
    if (!lock) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    draw(now_done);
}

void Progress::draw(uint64_t done) {
    const double part = static_cast<double>(done) / static_cast<double>(total_);
    const double spent = std::chrono::duration<double>(last_ - start_).count();
    const int filled = static_cast<int>(part * 30);
    print_message("\r\033[K{} [{:#<{}}{:.<{}}] {:3.0f} %  {} left", label_, "", filled, "",
                  30 - filled, part * 100, clock_text(spent * (1 - part) / part));
}

}  // namespace sightline
