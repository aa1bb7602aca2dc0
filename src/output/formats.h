#pragma once
#include "output/options.h"
#include "output/picture_writer.h"

#include <memory>
#include <span>

namespace sightline {

/// Whether the path's ending, in small or capital letters, is ".exr".
bool is_exr(const std::string& path);

/// Whether OpenImageIO writes the format of the path's ending.
bool is_written_by_module(const std::string& path);

/// A message if the background is to be transparent and a format cannot hold that; else "".
std::string alpha_problem(const LightOptions& light, std::span<const std::string> pictures);

/// A message with all formats if the path's ending is none of them; else "".
std::string format_problem(const std::string& path);

/// All files that a render with these options writes: pictures, data, statistics and rays.
std::vector<std::string> files_of(const OutputOptions& output);

/// Throws Error if no file can be written there: its folder does not exist or is not writable, or
/// the path exists and is not a regular file.
void check_place(const std::string& path);

/// Throws Error as check_place, or for an unknown format.
void check_output(const std::string& path);

/// A writer for the format of the path's ending. An EXR is written row by row, any other format at
/// the end. `layout`: the channels and windows of the picture. `alpha`: keep it where the format
/// can.
std::unique_ptr<PictureWriter> make_picture_writer(const std::string& path, const Film& layout,
                                                   const PictureMetadata& metadata,
                                                   const OutputOptions& options, bool alpha);

}  // namespace sightline
