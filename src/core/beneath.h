#pragma once
// Files that strangers' files name: opened only if they lie below a folder.
#include <string>

namespace sightline {

enum class Resolver {
    kernel,         ///< openat2, where the kernel has it; otherwise the same as by_components
    by_components,  ///< one folder after the other
};

/// Opens a file below `folder` for reading and returns its descriptor, or -1 with errno set: EXDEV
/// if the path leaves the folder on its way, by "..", an absolute path or a link. Links are
/// followed if they are relative and lead to places below the folder. What is checked is what is
/// opened, even if links are swapped meanwhile. Never blocks.
int open_beneath(const std::string& folder, const std::string& path,
                 Resolver resolver = Resolver::kernel);

}  // namespace sightline
