#include "batch/journal.h"

#include "core/error.h"
#include "core/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace sightline {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
    throw Error(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

std::string read_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

// The outcomes in all complete lines, in order.
std::vector<Outcome> parse_lines(const std::string& text) {
    std::vector<Outcome> outcomes;
    for (size_t begin = 0, end; (end = text.find('\n', begin)) != std::string::npos;
         begin = end + 1) {
        try {
            outcomes.push_back(outcome_from_json(
                nlohmann::json::parse(text.begin() + static_cast<std::ptrdiff_t>(begin),
                                      text.begin() + static_cast<std::ptrdiff_t>(end))));
        } catch (const nlohmann::json::exception&) {
            // Damaged by a power cut, or of another version: the task is done again.
        } catch (const std::logic_error&) {
            // The same: a hash is not a number.
        }
    }
    return outcomes;
}

// The line of an input that was passed over.
std::string line_of(const PassedOver& input) {
    return nlohmann::json{{"passed_over", bytes_to_json(input.path)}, {"reason", input.reason}}
        .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

bool is_record(const nlohmann::json& line) {
    return line.is_object() &&
           ((line.contains("key") && line.contains("verdict")) || line.contains("passed_over"));
}

/// False if no line can have been written by a batch. A power cut may leave lines incomplete or
/// with zeros, and another version may have written other fields.
bool is_journal(const std::string& text) {
    std::istringstream lines(text);
    bool is_empty = true;
    for (std::string line; std::getline(lines, line);) {
        const auto parsed = nlohmann::json::parse(line, nullptr, false);
        if (is_record(parsed)) return true;
        const bool damaged = line.find('\0') != std::string::npos || lines.eof();
        is_empty = is_empty && (line.empty() || (damaged && line[0] == '{') || line[0] == '\0');
    }
    return is_empty;
}

}  // namespace

Journal::Journal(const std::string& path, bool resume) : path_(path) {
    fd_ = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd_ < 0 && errno == ELOOP)
        throw Error(path + ": is a link; remove it or choose another --out");
    if (fd_ < 0) fail(path, "cannot write");
    try {
        if (flock(fd_, LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK)
                throw Error(path +
                            ": another batch is running in this folder; wait for it or choose "
                            "another --out");
            fail(path, "cannot lock");
        }
        read(resume);
    } catch (...) {
        close(fd_);
        throw;
    }
}

Journal::~Journal() { close(fd_); }

void Journal::read(bool resume) {
    const std::string text = read_text(path_);
    if (!text.empty() && !resume)
        throw Error(fmt::format(
            "{}: the folder holds an earlier batch; continue it with --resume or choose "
            "another --out",
            path_));
    if (!is_journal(text))
        throw Error(path_ + ": is not the journal of a batch; choose another --out");
    for (Outcome& outcome : parse_lines(text))
        outcomes_.insert_or_assign(outcome.key, std::move(outcome));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.find("\"passed_over\"") != std::string::npos) passed_over_.insert(line);
    const size_t complete = text.rfind('\n') + 1;  // npos + 1 is 0: no complete line
    if (complete < text.size() && ftruncate(fd_, static_cast<off_t>(complete)) != 0)
        fail(path_, "cannot write");
}

void Journal::append(const std::vector<Outcome>& outcomes) {
    std::string text;
    for (const Outcome& outcome : outcomes) {
        text += to_json(outcome).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        text += '\n';
        outcomes_.insert_or_assign(outcome.key, outcome);
    }
    if (!write_all(fd_, std::as_bytes(std::span(text)))) fail(path_, "cannot write");
}

void Journal::pass_over(const std::vector<PassedOver>& inputs) {
    std::string text;
    for (const PassedOver& input : inputs) {
        const std::string line = line_of(input);
        if (passed_over_.insert(line).second) text += line + '\n';
    }
    if (!write_all(fd_, std::as_bytes(std::span(text)))) fail(path_, "cannot write");
}

void Journal::sync() {
    if (fdatasync(fd_) != 0) fail(path_, "cannot write");
}

void Journal::add_earlier(const std::vector<Outcome>& outcomes) {
    for (const Outcome& outcome : outcomes) outcomes_.insert_or_assign(outcome.key, outcome);
}

const Outcome* Journal::find(const std::string& key) const {
    const auto found = outcomes_.find(key);
    return found == outcomes_.end() ? nullptr : &found->second;
}

std::vector<Outcome> read_outcomes(const std::string& path) {
    return std::filesystem::exists(path) ? parse_lines(read_text(path)) : std::vector<Outcome>();
}

KnownNames read_names(const std::string& path) {
    KnownNames names;
    for (const Outcome& outcome : read_outcomes(path))
        if (!outcome.asset.empty()) names[outcome.asset].push_back(outcome.asset_name);
    for (auto& [asset, list] : names) {
        std::ranges::sort(list, {}, [](const std::string& n) { return std::pair(n.size(), n); });
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return names;
}

}  // namespace sightline
