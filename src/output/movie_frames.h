#pragma once
#include <cstddef>
#include <cstdint>

#include <string>
#include <vector>

namespace sightline {

/// Finished frames of a film, PNG files in a folder beside it until the film is whole. Each has the
/// key of all that its pixels depend on in its name, so that a later run knows which it can use.
class MovieFrames {
  public:
    /// For the film at `path`; the folder is made when it is needed. `use_earlier`: has() also
    /// finds what an earlier run has left.
    MovieFrames(const std::string& path, bool use_earlier);
    /// Removes the folder if it is empty.
    ~MovieFrames();
    MovieFrames(const MovieFrames&) = delete;

    const std::string& folder() const { return folder_; }

    /// Makes the folder unless it exists. Throws Error.
    void make_folder() const;

    /// Where to write a frame.
    std::string path(size_t frame) const;

    /// The finished frame was written to path(): gives it its name. Throws Error.
    void keep(size_t frame, uint64_t key);

    /// Whether the frame has been kept with this key, by an earlier run, too. If its file is
    /// damaged, it is removed, and `note` says so.
    bool has(size_t frame, uint64_t key, std::string& note);

    /// Removes what an interrupted render has left of a frame.
    void drop(size_t frame) const;

    /// All frames that has() has found or keep() has kept, in order.
    std::vector<std::string> files() const;

    /// Removes all frames, those of earlier runs, too.
    void remove();

  private:
    std::string name(size_t frame, uint64_t key) const;

    std::string folder_;
    bool use_earlier_;
    std::vector<std::string> files_;  // by frame
};

}  // namespace sightline
