#pragma once
#include "output/display.h"
#include "output/exr.h"

#include <memory>

namespace sightline {

/// How a film becomes a display picture.
struct DisplaySettings {
    ToneMap tone_map = ToneMap::pbr_neutral;
    float exposure = 0;  ///< stops
    bool alpha = false;  ///< keep the alpha channel where the format has one
};

/// Whether the path's ending, in small or capital letters, asks for an EXR.
bool is_exr(const std::string& path);

/// What is wrong where the path's ending names no known format, with a list of those; else "".
std::string format_problem(const std::string& path);

/// Throws Error if nothing can be written there: the folder does not exist or may not be written,
/// or what is there is no regular file.
void check_place(const std::string& path);

/// Throws Error as check_place, or if there is no such format.
void check_output(const std::string& path);

/// How pictures are written.
struct WriteSettings {
    DisplaySettings display;
    ExrOptions exr;
};

/// A picture in the format of the path's ending. An EXR is written as it comes; any other format
/// keeps what it shows (3 or 4 bytes a pixel, for .hdr 12) until the end.
std::unique_ptr<PictureWriter> make_picture_writer(const std::string& path, const Film& layout,
                                                   const PictureInfo& info,
                                                   const WriteSettings& settings);

/// Gathers the beauty layer as the 8-bit picture that display_picture makes.
class DisplayGatherer {
  public:
    /// `window`: of the whole picture.
    DisplayGatherer(const DisplaySettings& settings, const PixelRect& window)
        : settings_(settings), window_(window) {}
    void add(const Film& band);
    const Image& picture() const { return picture_; }

  private:
    DisplaySettings settings_;
    PixelRect window_;
    Image picture_;
};

/// The tone map of that name ("none", "pbr-neutral", "aces", "agx").
ToneMap parse_tone_map(const std::string& name);

}  // namespace sightline
