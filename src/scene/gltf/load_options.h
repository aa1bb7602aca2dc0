#pragma once
#include "image/image.h"

#include <cstdint>
#include <optional>
#include <string>

namespace sightline {

/// What stands for a base colour texture whose image is missing or damaged.
enum class MissingTexture {
    factor,  ///< the factor alone
    checker  ///< squares in magenta and black
};

/// Which parts of a file to load, and the limits that guard against hostile files.
struct LoadOptions {
    std::string scene;           ///< name or index; empty: the file's default, or its first
    std::string variant;         ///< of KHR_materials_variants, name or index; empty: none
    std::string animation;       ///< name, index or "all"; empty: the first if `time` is set
    std::optional<float> time;   ///< seconds; unset: the rest pose, or 0 if `animation` is set
    bool strict = false;         ///< refuse the file at its first fault (docs/faults.md)
    bool allow_outside = false;  ///< allow URIs that leave the file's folder
    bool decode_images = true;   ///< false: images stay empty
    /// Report the faults of all that the file holds, not only of what this scene needs.
    bool find_all_faults = false;
    ImageLimits images;
    uint64_t max_elements = 1ull << 29;         ///< elements of one accessor
    uint64_t max_accessor_values = 1ull << 32;  ///< numbers read from all accessors together
    uint64_t max_file_bytes = 1ull << 33;       ///< size of each file read
    uint64_t max_texture_memory = 0;  ///< MiB of all decoded images; 0: half of the machine's
    MissingTexture missing_texture = MissingTexture::factor;
};

}  // namespace sightline
