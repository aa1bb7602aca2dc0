#pragma once
#include "batch/task.h"
#include "scene/scene.h"

#include <span>

namespace sightline {

/// A hash of all that the pixels of a film's frame depend on: the program's version, the contents
/// of the files that were read, Embree's instruction set, and the picture's options.
uint64_t frame_key(const Settings& settings, std::span<const SourceFile> inputs,
                   const std::string& isa);

}  // namespace sightline
