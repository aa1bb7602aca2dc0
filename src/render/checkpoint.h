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

/// Finished tiles of one picture, in a folder until the picture is written. Each process appends to
/// its own file, so that several may work on one picture. A killed process loses only the tiles in
/// progress, a power failure the last seconds.
class Checkpoint {
  public:
    /// Opens the folder or makes it. `key` is a hash of everything that the values of tiles depend
    /// on; tiles with another key are ignored. Throws Error.
    Checkpoint(std::string folder, uint64_t key);
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;

    /// True if there is a record of the tile with this first pixel; restore() checks it.
    bool has(int x, int y) const { return records_.contains({x, y}); }

    /// Fills `tile`, a film over all pixels of the tile, and adds its counters; false if it has no
    /// undamaged record. Thread-safe.
    bool restore(Film& tile, Counters& counters) const;

    /// Appends a finished tile. Thread-safe. Throws Error.
    void keep(const Film& tile, const Counters& counters);

    /// Syncs the tiles so far to disk. Throws Error.
    void sync();

    /// Number of files in the folder with another key, or that hold no tiles.
    size_t foreign_files() const { return foreign_; }

    /// Removes the tiles, and the folder unless it holds other files, once the picture is written.
    void remove();

  private:
    struct File;
    struct Record {
        const File* file;
        uint64_t offset;
    };
    void add_file(const std::string& path);
    void create_own();

    std::string folder_;
    uint64_t key_;
    std::vector<std::unique_ptr<File>> files_;
    std::map<std::pair<int, int>, Record> records_;
    size_t foreign_ = 0;
    std::mutex appending_;
    std::unique_ptr<File> own_;  // made with the first tile
    std::chrono::steady_clock::time_point synced_;
};

}  // namespace sightline
