#pragma once
// What a batch has done so far: one JSON line for each finished task.
#include "batch/task.h"

#include <map>
#include <string>
#include <vector>

namespace sightline {

/// An open journal, locked against other batches for as long as it lives.
class Journal {
  public:
    /// Opens or creates `path`. `keep`: what stands there is read and continued; otherwise it must
    /// hold no outcome, and Error says to use --resume. A last line that a power cut left
    /// unfinished is removed. Throws Error where another process has it open.
    Journal(const std::string& path, bool keep);
    ~Journal();
    Journal(const Journal&) = delete;

    /// Appends: the outcomes survive a kill when it returns, a power cut after `sync`. Throws
    /// Error.
    void append(const std::vector<Outcome>& outcomes);

    /// Waits for the disk. Throws Error.
    void sync();

    const std::string& path() const { return path_; }

    /// Takes over what other journals say, for `find` alone.
    void recall(const std::vector<Outcome>& outcomes);

    /// The last outcome of the task, or nullptr.
    const Outcome* find(const std::string& key) const;

    /// The last outcome of each task by key.
    const std::map<std::string, Outcome>& outcomes() const { return outcomes_; }

  private:
    void read(bool keep);

    std::string path_;
    int fd_ = -1;
    std::map<std::string, Outcome> outcomes_;
};

/// The outcomes of a journal that another process may be writing; nothing where it is missing.
/// Lines that are no outcome (unfinished, or of another program) are left out.
std::vector<Outcome> read_outcomes(const std::string& path);

}  // namespace sightline
