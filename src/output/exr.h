#pragma once
#include "render/film.h"

#include <map>

namespace sightline {

/// Metadata of a picture. Matrices go out under the standard names worldToCamera and worldToNDC.
struct PictureInfo {
    Mat4 world_to_camera, world_to_ndc;
    std::map<std::string, std::string> strings;  ///< attribute name → text
    std::map<std::string, float> numbers;
};

/// Writes all channels of the film as a scanline EXR (ZIP, lossless); the data window is the crop.
/// The file appears whole or not at all, and is the same for any number of threads. Throws Error.
void write_exr(const std::string& path, const Film& film, const PictureInfo& info,
               unsigned threads = 1);

/// Reads back every channel of an EXR that write_exr wrote, in the order of their names, and its
/// metadata where `info` is given. Throws Error.
Film read_exr(const std::string& path, PictureInfo* info = nullptr);

}  // namespace sightline
