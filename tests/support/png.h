#pragma once
// PNG files made byte by byte.
#include "core/files.h"

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

namespace sightline {

using Bytes = std::vector<std::byte>;

inline Bytes read_bytes(const std::string& path, uint64_t max_bytes) {
    const FileBytes bytes = read_file(path, max_bytes);
    return {bytes.begin(), bytes.end()};
}

inline void append(Bytes& to, std::initializer_list<int> values) {
    for (const int value : values) to.push_back(static_cast<std::byte>(value));
}

inline void append_big(Bytes& to, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        to.push_back(static_cast<std::byte>(value >> shift));
    }
}

inline uint32_t crc(std::span<const std::byte> data) {
    uint32_t result = 0xffffffff;
    for (const std::byte byte : data) {
        result ^= std::to_integer<uint32_t>(byte);
        for (int k = 0; k < 8; ++k) result = result >> 1 ^ (result & 1 ? 0xedb88320u : 0u);
    }
    return ~result;
}

inline void append_chunk(Bytes& png, const std::string& type, const Bytes& data) {
    append_big(png, static_cast<uint32_t>(data.size()));
    const size_t start = png.size();
    for (const char c : type) png.push_back(static_cast<std::byte>(c));
    png.insert(png.end(), data.begin(), data.end());
    append_big(png, crc(std::span(png).subspan(start)));
}

/// A zlib stream of one uncompressed block.
inline Bytes stored(const Bytes& content) {
    Bytes data;
    const int size = static_cast<int>(content.size());
    append(data, {0x78, 0x01, 1, size & 255, size >> 8, ~size & 255, ~size >> 8 & 255});
    data.insert(data.end(), content.begin(), content.end());
    uint32_t a = 1, b = 0;
    for (const std::byte byte : content) {
        a = (a + std::to_integer<uint32_t>(byte)) % 65521;
        b = (b + a) % 65521;
    }
    append_big(data, b << 16 | a);
    return data;
}

/// `rows` are the filtered rows, each beginning with its filter type; those of the passes one after
/// the other if the PNG is interlaced.
struct Png {
    uint32_t width, height;
    int depth, color_type;
    Bytes palette, transparency, rows;
    bool interlaced = false;

    Bytes file() const {
        Bytes png;
        append(png, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'});
        Bytes header;
        append_big(header, width);
        append_big(header, height);
        append(header, {depth, color_type, 0, 0, interlaced ? 1 : 0});
        append_chunk(png, "IHDR", header);
        if (!palette.empty()) append_chunk(png, "PLTE", palette);
        if (!transparency.empty()) append_chunk(png, "tRNS", transparency);
        append_chunk(png, "IDAT", stored(rows));
        append_chunk(png, "IEND", {});
        return png;
    }
};

inline Bytes bytes(std::initializer_list<int> values) {
    Bytes result;
    append(result, values);
    return result;
}

/// A PNG of one colour.
inline Bytes plain_png(uint32_t size, int red) {
    Bytes rows;
    for (uint32_t y = 0; y < size; ++y) {
        append(rows, {0});
        for (uint32_t x = 0; x < size; ++x) append(rows, {red, 0, 0});
    }
    return Png{size, size, 8, 2, {}, {}, rows}.file();
}

}  // namespace sightline
