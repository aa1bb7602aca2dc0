#pragma once
// The films of `render`: which pictures are their frames, and what has been kept of them.
#include "batch/names.h"
#include "batch/task.h"
#include "output/movie.h"
#include "output/movie_frames.h"

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace sightline {

/// The films of one command. Pictures become their frames in the order in which they are added; a
/// frame is written as a PNG beside the film.
class RenderMovies {
  public:
    RenderMovies() = default;
    /// `names`: templates of the films' paths, each film in all of them. `resume`: use the frames
    /// that an earlier run has kept.
    RenderMovies(std::vector<std::string> names, double fps, bool resume);

    bool empty() const { return names_.empty(); }

    /// Makes the picture the next frame of the film of its names: adds the frame's file to the
    /// pictures that the command writes.
    void add(RenderCommand& command, const Settings& settings, const NameFields& fields);

    /// The paths of all films.
    std::vector<std::string> paths() const;

    /// Throws CLI::ValidationError if a format cannot hold its film, Error if there is no ffmpeg
    /// that writes them all, or no place for them.
    void check();

    /// "turn.mp4, frame 3": what the picture with this index is a frame of.
    std::string describe(size_t picture) const;

    /// "36 frames, 1.5 s": of the film that the picture is a frame of.
    std::string describe_length(size_t picture) const;

    /// Whether an earlier run has kept the picture's frame, made of files with these contents. If
    /// it is damaged, `note` says so.
    bool has_kept(size_t picture, std::span<const SourceFile> inputs, std::string& note);

    /// The picture has been rendered.
    void keep(size_t picture, std::span<const SourceFile> inputs);

    /// The picture's render was interrupted: removes what there is of it.
    void drop(size_t picture) const;

    /// Whether the picture is the last of its film.
    bool ends_film(size_t picture) const;

    /// Writes the film that the picture ends in all its formats and removes the frames that were
    /// kept. Returns the paths; none after a stop request. Throws Error.
    std::vector<std::string> write(size_t picture, const std::stop_token& stop);

    /// Removes all frames that are kept.
    void discard();

    /// Says what is kept after an early end: "12 of 36 frames are kept in turn.mp4.frames"; "" if
    /// nothing is.
    std::string describe_kept() const;

  private:
    struct Movie {
        std::vector<std::string> paths;
        MovieOptions options;
        size_t frames = 0, done = 0;
        std::unique_ptr<MovieFrames> kept;
    };
    struct Frame {
        size_t movie, number;
        Settings settings;
    };
    uint64_t key_of(const Frame& frame, std::span<const SourceFile> inputs) const;

    std::vector<std::string> names_;
    double fps_ = 24;
    bool resume_ = false;
    std::string isa_;
    std::map<std::string, size_t> index_;  // of films by their first path
    std::vector<Movie> movies_;
    std::vector<Frame> frames_;  // by picture
};

/// Moves the paths that are films to the result: those of formats for films alone, and of .webp
/// without {frame} if the pictures are a sequence.
std::vector<std::string> take_movies(std::vector<std::string>& outputs, bool is_sequence);

}  // namespace sightline
