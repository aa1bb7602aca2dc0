#pragma once
#include "output/picture_writer.h"

#include <memory>

namespace sightline {

/// How an EXR is laid out.
struct ExrOptions {
    bool tiled = false;      ///< tiles of 64×64 pixels, else scanlines
    bool multipart = false;  ///< a part for each layer, else all in one
    std::string compression = "zip";
    unsigned threads = 1;  ///< to compress by
};

/// The names that `compression` may have; all of them are lossless.
inline constexpr const char* exr_compressions[] = {"none", "rle", "zips", "zip", "piz"};

/// An EXR of the channels of `layout` (whose values are not read), whose data window is the film's
/// window. The same bytes for any number of threads. Throws Error.
std::unique_ptr<PictureWriter> make_exr_writer(const std::string& path, const Film& layout,
                                               const PictureInfo& info,
                                               const ExrOptions& options = {});

/// Writes a whole film. Throws Error.
void write_exr(const std::string& path, const Film& film, const PictureInfo& info,
               const ExrOptions& options = {});

/// Reads back every channel of an EXR that was written here, in the order of their names within
/// their parts, and its metadata where `info` is given. Throws Error.
Film read_exr(const std::string& path, PictureInfo* info = nullptr);

}  // namespace sightline
