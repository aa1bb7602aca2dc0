#pragma once
// Thumbnails for the contact sheet, and the comparison with an earlier run.
#include "batch/task.h"
#include "image/image.h"
#include "output/output_folder.h"

namespace sightline {

/// Path of the thumbnail of the picture `name`, relative to the batch's folder.
std::string thumbnail_path(const std::string& name);

/// Folder for finished tiles of the large picture `name` until it is written; relative, too.
std::string tiles_path(const std::string& name);

/// Writes an 8-bit picture as a JPEG, scaled down to at most 192 pixels a side.
void write_thumbnail(const std::string& path, const Image& picture);

/// Compares the task's first output, at `current` relative to `folder`, with the file of the same
/// name in `compare_to` (empty: not compared). If they differ, writes a thumbnail of the earlier
/// picture beside the new one.
Change compare_with_earlier(const Task& task, const std::string& folder, const std::string& current,
                            const std::string& compare_to);

}  // namespace sightline
