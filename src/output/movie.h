#pragma once
// Films: files of moving pictures, which the ffmpeg program makes of frames.
#include "output/options.h"

#include <span>
#include <stop_token>
#include <string>

namespace sightline {

/// What all frames of a film have in common.
struct MovieOptions {
    int width = 0, height = 0;  ///< pixels
    double fps = 24;            ///< frames per second
    bool alpha = false;         ///< keep the frames' alpha
    bool show_progress = false;
};

/// Of a frame: libavutil holds fewer than 2^28 pixels.
inline constexpr uint64_t max_movie_pixels = uint64_t{1} << 27;
inline constexpr uint64_t max_frame_bytes = uint64_t{1} << 34;

/// Whether the path's ending is one of films alone: .mp4 .webm .gif.
bool is_movie(const std::string& path);

/// Whether the path's ending is one of films, .webp included, which holds still pictures, too.
bool can_be_movie(const std::string& path);

/// The options of a film of pictures that the command describes.
MovieOptions movie_options(const RenderCommand& command, double fps);

/// A message if the film's format cannot hold such frames; else "".
std::string movie_problem(const std::string& path, const MovieOptions& options);

/// Throws Error if there is no ffmpeg program, or if it cannot write one of the films.
void check_ffmpeg(std::span<const std::string> movies);

/// Makes a film of PNG files. It appears whole, or not at all: until then it grows in `folder`,
/// which is on the same file system. The same frames give the same bytes with the same ffmpeg.
/// False after a stop request. Throws Error with what ffmpeg says.
bool write_movie(const std::string& path, std::span<const std::string> frames,
                 const MovieOptions& options, const std::string& folder, std::stop_token stop = {});

}  // namespace sightline
