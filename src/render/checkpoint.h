#pragma once
#include "render/film.h"
#include "render/samples.h"

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sightline {

/// Finished tiles of one picture, kept in a folder until the picture is written. Each process
/// appends to a file of its own, so that several may work on one picture, a kill costs no more
/// than the tiles in flight, and power loss the last seconds.
class Checkpoint {
  public:
    /// Opens the folder, made where it is not there. `key` stands for everything that the tiles'
    /// values depend on: tiles under another key are passed over. Throws Error.
    Checkpoint(std::string folder, uint64_t key);
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;

    /// Whether the tile with this first pixel seems to be there; `restore` decides.
    bool has(int x, int y) const { return places_.contains({x, y}); }

    /// Fills the tile, a film over all pixels of it, and adds what its tracing counted; false
    /// where it is not there whole. Thread-safe.
    bool restore(Film& tile, Counters& counters) const;

    /// Appends the tile. Thread-safe. Throws Error.
    void keep(const Film& tile, const Counters& counters);

    /// Makes what was kept so far survive power loss. Throws Error.
    void sync();

    /// Files in the folder that are of another picture, or of no picture.
    size_t foreign_files() const { return foreign_; }

    /// Removes the folder: the picture is written.
    void remove();

  private:
    struct File;
    struct Place {
        const File* file;
        uint64_t offset;
    };
    void add_file(const std::string& path);
    void create_own();

    std::string folder_;
    uint64_t key_;
    std::vector<std::unique_ptr<File>> files_;
    std::map<std::pair<int, int>, Place> places_;
    size_t foreign_ = 0;
    std::mutex appending_;
    std::unique_ptr<File> own_;  // made with the first tile
    std::chrono::steady_clock::time_point synced_;
};

}  // namespace sightline
