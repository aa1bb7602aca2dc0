#pragma once
#include "output/display.h"
#include "output/exr.h"

namespace sightline {

/// How a film becomes a display picture.
struct DisplaySettings {
    ToneMap tone_map = ToneMap::pbr_neutral;
    float exposure = 0;  ///< stops
    bool alpha = false;  ///< keep the alpha channel where the format has one
};

/// Throws Error if the path's ending names no known format (the message lists them) or its folder
/// does not exist or cannot be written, so that nobody waits for a picture which cannot be kept.
void check_output(const std::string& path);

/// Writes the film to `path` in the format of its ending; an EXR is compressed by `threads`.
void write_picture(const std::string& path, const Film& film, const PictureInfo& info,
                   const DisplaySettings& settings, unsigned threads = 1);

/// The tone map of that name ("none", "pbr-neutral", "aces", "agx").
ToneMap parse_tone_map(const std::string& name);

}  // namespace sightline
