#pragma once
// Small pictures for the contact sheet, and what changed against an earlier run.
#include "batch/task.h"
#include "image/image.h"

namespace sightline {

/// What a batch keeps for itself below its folder.
inline constexpr const char* private_folder = ".sightline";

/// Where the thumbnail of a picture of that name stands, below the batch's folder.
std::string thumbnail_path(const std::string& name);

/// Where finished tiles of a large picture of that name are kept until it is written.
std::string tiles_path(const std::string& name);

/// Writes an 8-bit picture, averaged down to at most 192 pixels a side, as a JPEG.
void write_thumbnail(const std::string& path, const Image& picture);

/// How the task's first picture differs from that of the same name in the folder `compare_to`
/// (empty: not compared). Where it does, a thumbnail of the earlier one is kept beside the new one.
/// `current`: where that picture is, relative to `folder`.
Change compare_with_earlier(const Task& task, const std::string& folder, const std::string& current,
                            const std::string& compare_to);

}  // namespace sightline
