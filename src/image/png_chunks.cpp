#include "image/png_chunks.h"

#include "core/bytes.h"
#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>

namespace sightline {
namespace {

using CrcTables = std::array<std::array<uint32_t, 256>, 8>;

/// tables[k][b]: the checksum of byte b followed by k zeros, for steps of eight bytes (PNG
/// specification, annex D; "slicing by 8").
constexpr CrcTables make_crc_tables() {
    CrcTables tables{};
    for (uint32_t b = 0; b < 256; ++b) {
        uint32_t crc = b;
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
        tables[0][b] = crc;
    }
    for (size_t k = 1; k < 8; ++k) {
        for (size_t b = 0; b < 256; ++b) {
            const uint32_t crc = tables[k - 1][b];
            tables[k][b] = crc >> 8 ^ tables[0][crc & 255];
        }
    }
    return tables;
}

constexpr CrcTables tables = make_crc_tables();

uint32_t checksum(std::span<const std::byte> data) {
    const auto byte = [&](size_t i) { return std::to_integer<uint32_t>(data[i]); };
    uint32_t crc = 0xffffffffu;
    size_t i = 0;
    for (; i + 8 <= data.size(); i += 8) {
        crc ^= byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24;
        crc = tables[7][crc & 255] ^ tables[6][crc >> 8 & 255] ^ tables[5][crc >> 16 & 255] ^
              tables[4][crc >> 24] ^ tables[3][byte(i + 4)] ^ tables[2][byte(i + 5)] ^
              tables[1][byte(i + 6)] ^ tables[0][byte(i + 7)];
    }
    for (; i < data.size(); ++i) crc = crc >> 8 ^ tables[0][(crc ^ byte(i)) & 255];
    return ~crc;
}

uint32_t read_uint32(std::span<const std::byte> file, size_t offset) {
    return static_cast<uint32_t>(big_endian(file.subspan(offset, 4)));
}

}  // namespace

void check_png_chunks(std::span<const std::byte> file, const std::string& name) {
    const auto fail = [&](const std::string& what, size_t offset) {
        throw Error(fmt::format("{}: damaged PNG: {} at byte {}", name, what, offset));
    };
    for (size_t at = 8;;) {
        if (file.size() - std::min(at, file.size()) < 12) fail("truncated: no end chunk", at);
        const uint32_t length = read_uint32(file, at);
        const std::string type(reinterpret_cast<const char*>(&file[at + 4]), 4);
        const auto letter = [](unsigned char c) { return c < 128 && std::isalpha(c); };
        if (!std::all_of(type.begin(), type.end(), letter)) fail("chunk of unknown type", at);
        if (length > file.size() - at - 12) fail("truncated " + type + " chunk", at);
        if (checksum(file.subspan(at + 4, length + 4)) != read_uint32(file, at + 8 + length))
            fail("wrong checksum of " + type + " chunk", at);
        if (type == "IEND") return;
        at += 12 + size_t{length};
    }
}

}  // namespace sightline
