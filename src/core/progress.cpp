#include "core/progress.h"

#include "core/message.h"
#include "core/text.h"

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

using nlohmann::ordered_json;

std::atomic<ProgressForm> chosen_form{ProgressForm::automatic};

double rounded(double seconds) { return std::round(seconds * 1000) / 1000; }

}  // namespace

void set_progress_form(ProgressForm form) { chosen_form = form; }

ProgressForm progress_form() { return chosen_form; }

void write_progress_line(const ordered_json& fields) {
    write_message(fields.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

void add_progress_times(ordered_json& fields, double spent, double part) {
    fields["elapsed_s"] = rounded(spent);
    fields["eta_s"] = nullptr;
    if (part > 0) fields["eta_s"] = rounded(spent * std::max(0.0, 1 - part) / part);
}

Progress::Progress(std::string stage, ProgressName name, uint64_t total, bool show)
    : stage_(std::move(stage)),
      name_(std::move(name)),
      total_(total),
      bar_(show && progress_form() == ProgressForm::automatic && isatty(STDERR_FILENO)),
      json_(progress_form() == ProgressForm::json),
      start_(Clock::now()),
      last_(start_) {
    if (json_) write_line(0, 0, 0);
}

Progress::~Progress() {
    if (bar_ && last_ != start_) print_message("\r\033[K");
}

void Progress::advance(uint64_t done) {
    const uint64_t now_done = done_.fetch_add(done, std::memory_order_relaxed) + done;
    if (!bar_ && !json_) return;
    if (json_ && now_done >= total_) {
        const std::lock_guard lock(showing_);
        return show(now_done);
    }
    const std::unique_lock lock(showing_, std::try_to_lock);
    if (!lock) return;
    if (Clock::now() - last_ < std::chrono::milliseconds(json_ ? 250 : 100)) return;
    // Another thread may have shown more in between.
    show(std::max(now_done, done_.load(std::memory_order_relaxed)));
}

void Progress::show(uint64_t done) {
    last_ = Clock::now();
    const double part = total_ ? static_cast<double>(done) / static_cast<double>(total_) : 1.0;
    const double spent = std::chrono::duration<double>(last_ - start_).count();
    json_ ? write_line(done, part, spent) : draw(part, spent);
}

void Progress::write_line(uint64_t done, double part, double spent) const {
    ordered_json fields = {{"stage", stage_}};
    if (!name_.name.empty()) fields["name"] = name_.name;
    if (name_.count) fields["number"] = name_.number, fields["of"] = name_.count;
    fields["done"] = done;
    fields["total"] = total_;
    add_progress_times(fields, spent, part);
    write_progress_line(fields);
}

void Progress::draw(double part, double spent) const {
    std::string label = name_.name.empty() ? stage_ : printable(name_.name);
    if (name_.count) label += fmt::format(" ({} of {})", name_.number, name_.count);
    const int filled = static_cast<int>(part * 30);
    print_message("\r\033[K{} [{:#<{}}{:.<{}}] {:3.0f} %  {} left", label, "", filled, "",
                  30 - filled, part * 100, clock_text(spent * (1 - part) / part));
}

}  // namespace sightline
