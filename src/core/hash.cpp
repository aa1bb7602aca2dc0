#include "core/hash.h"

#include "core/error.h"

#define XXH_INLINE_ALL
#include <fmt/format.h>
#include <xxhash.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

namespace sightline {

uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed) {
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

uint64_t hash_text(const std::string& text, uint64_t seed) {
    return hash_bytes(std::as_bytes(std::span(text)), seed);
}

uint64_t hash_file(const std::string& path, uint64_t max_bytes) {
    // Opening a pipe or device could block.
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) throw Error(path + ": does not exist");
    if (!std::filesystem::is_regular_file(path, ignored))
        throw Error(path + ": not a regular file");
    if (const uint64_t size = std::filesystem::file_size(path, ignored); size > max_bytes)
        throw LimitError(
            fmt::format("{}: {} bytes, more than the limit of {}", path, size, max_bytes));
    std::ifstream file(path, std::ios::binary);
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                         XXH3_freeState);
    XXH3_64bits_reset_withSeed(state.get(), 0);
    std::vector<char> piece(1 << 18);
    while (file) {
        file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        XXH3_64bits_update(state.get(), piece.data(), static_cast<size_t>(file.gcount()));
    }
    if (!file.eof()) throw Error(path + ": cannot read");
    return XXH3_64bits_digest(state.get());
}

}  // namespace sightline
