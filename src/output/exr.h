#pragma once
#include "output/picture_writer.h"

#include <memory>

namespace sightline {

/// The layout of an EXR file.
struct ExrOptions {
    bool tiled = false;      ///< tiles of 64×64 pixels, else scanlines
    bool multipart = false;  ///< a part for each layer, else all in one
    std::string compression = "zip";
    unsigned threads = 1;  ///< for compression
};

/// The values of `compression`; all are lossless.
inline constexpr const char* exr_compressions[] = {"none", "rle", "zips", "zip", "piz"};

/// An EXR with the channels of `layout` (its values are not read) and its window as data window.
/// The same bytes for any number of threads. Throws Error.
std::unique_ptr<PictureWriter> make_exr_writer(const std::string& path, const Film& layout,
                                               const PictureMetadata& metadata,
                                               const ExrOptions& options = {});

/// Writes a whole film. Throws Error.
void write_exr(const std::string& path, const Film& film, const PictureMetadata& metadata,
               const ExrOptions& options = {});

/// Reads every channel of an EXR that write_exr wrote, in the order of their names within their
/// parts, and its metadata if `metadata` is not null. Throws Error.
Film read_exr(const std::string& path, PictureMetadata* metadata = nullptr);

}  // namespace sightline
