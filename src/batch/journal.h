#pragma once
// The record of a batch: one JSON line per finished task.
#include "batch/names.h"
#include "batch/task.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace sightline {

/// The journal's name within the batch's folder.
inline constexpr const char* journal_name = "journal.jsonl";

/// An input that a batch found but does not render, and why.
struct PassedOver {
    std::string path;    ///< absolute
    std::string reason;  ///< the rest of a sentence about the path
};

/// An open journal, locked against other batches during its lifetime.
class Journal {
  public:
    /// Opens or creates `path`. If `resume`, existing outcomes are read and an incomplete last
    /// line, left by a power cut, is removed. Throws Error if another process has the journal
    /// open or, without `resume`, if the file is not empty.
    Journal(const std::string& path, bool resume);
    ~Journal();
    Journal(const Journal&) = delete;

    /// Appends lines, which survive a kill once this returns and a power cut after `sync`.
    /// Throws Error.
    void append(const std::vector<Outcome>& outcomes);

    /// Waits until all lines are on the disk. Throws Error.
    void sync();

    const std::string& path() const { return path_; }

    /// Appends a line for each input that was passed over, unless the journal has it. Throws Error.
    void pass_over(const std::vector<PassedOver>& inputs);

    /// How many inputs were passed over, in this run and earlier ones.
    size_t passed_over() const { return passed_over_.size(); }

    /// Makes outcomes of other journals known to `find` without writing them.
    void add_earlier(const std::vector<Outcome>& outcomes);

    /// The last outcome of the task with this key, or nullptr.
    const Outcome* find(const std::string& key) const;

    /// The last outcome of each task by key.
    const std::map<std::string, Outcome>& outcomes() const { return outcomes_; }

  private:
    void read(bool resume);

    std::string path_;
    int fd_ = -1;
    std::map<std::string, Outcome> outcomes_;
    std::set<std::string> passed_over_;  // lines
};

/// The outcomes in a journal that another process may be writing; empty if there is no such file.
/// Skips lines that are not outcomes: incomplete ones, or those of another version.
std::vector<Outcome> read_outcomes(const std::string& path);

/// The names that the assets of the journal's outcomes have, shortest first.
KnownNames read_names(const std::string& path);

}  // namespace sightline
