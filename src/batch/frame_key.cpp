#include "batch/frame_key.h"

#include "core/hash.h"
#include "core/version.h"

#include <fmt/format.h>

namespace sightline {

uint64_t frame_key(const Settings& settings, std::span<const SourceFile> inputs,
                   const std::string& isa) {
    // A zero byte after each piece keeps the texts of different frames different.
    std::string text = std::string(program_version) + '\0';
    text += isa + '\0';
    for (const SourceFile& input : inputs) text += fmt::format("{:016x}\n", input.hash);
    for (const auto& [option, value] : settings) text += option + '\0' + value + '\0';
    return hash_text(text);
}

}  // namespace sightline
