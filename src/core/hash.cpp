#include "core/hash.h"

#include "core/error.h"
#include "core/file_state.h"

#define XXH_INLINE_ALL
#include <fmt/format.h>
#include <xxhash.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace sightline {
namespace {

void check_size(const std::string& path, uint64_t size, uint64_t max_bytes) {
    if (size > max_bytes)
        throw LimitError(
            fmt::format("{}: {} bytes, more than the limit of {}", path, size, max_bytes));
}

}  // namespace

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
    check_size(path, std::filesystem::file_size(path, ignored), max_bytes);
    std::ifstream file(path, std::ios::binary);
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                         XXH3_freeState);
    XXH3_64bits_reset_withSeed(state.get(), 0);
    std::vector<char> piece(1 << 18);
    uint64_t size = 0;
    while (file) {
        file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        size += static_cast<uint64_t>(file.gcount());
        check_size(path, size, max_bytes);
        XXH3_64bits_update(state.get(), piece.data(), static_cast<size_t>(file.gcount()));
    }
    if (!file.eof()) throw Error(path + ": cannot read");
    return XXH3_64bits_digest(state.get());
}

uint64_t hash_shared_file(const std::string& path, uint64_t max_bytes) {
    constexpr size_t max_known = 4096;
    static std::mutex mutex;
    static std::map<std::string, std::pair<FileState, uint64_t>> known;
    const std::lock_guard lock(mutex);
    const auto state = state_of_file(path);
    if (state) check_size(path, state->size, max_bytes);
    const auto found = known.find(path);
    if (state && found != known.end() && found->second.first == *state) return found->second.second;
    const bool is_lasting = state && is_settled(*state, nanoseconds_now());
    const uint64_t hash = hash_file(path, max_bytes);
    if (known.size() >= max_known) known.clear();
    if (is_lasting && state_of_file(path) == state)
        known.insert_or_assign(path, std::pair(*state, hash));
    return hash;
}

}  // namespace sightline
