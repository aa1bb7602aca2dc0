#include "scene/gltf/container.h"

#include "core/bytes.h"
#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace sightline {
namespace {

constexpr uint32_t magic_gltf = 0x46546C67, chunk_json = 0x4E4F534A, chunk_bin = 0x004E4942;

uint32_t read_uint32(std::span<const std::byte> bytes, size_t offset) {
    return static_cast<uint32_t>(little_endian(bytes.subspan(offset, 4)));
}

std::string_view text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
    static constexpr auto values = [] {
        std::array<int8_t, 256> table{};
        table.fill(-1);
        constexpr std::string_view digits =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (size_t i = 0; i < digits.size(); ++i) {
            table[static_cast<uint8_t>(digits[i])] = static_cast<int8_t>(i);
        }
        return table;
    }();
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    if (text.size() % 4 == 1) return {};
    std::vector<std::byte> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int value = values[static_cast<uint8_t>(c)];
        if (value < 0) return {};
        bits = bits << 6 | static_cast<uint32_t>(value);
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes.push_back(static_cast<std::byte>(bits >> count & 0xff));
        }
    }
    return bytes;
}

GltfContainer split_glb(std::span<const std::byte> file, const std::string& path) {
    const auto fail = [&](size_t offset, const std::string& reason) {
        throw Error(fmt::format("{}: GLB, byte {}: {}", path, offset, reason));
    };
    if (file.size() < 12) fail(0, "the header is truncated");
    if (const uint32_t version = read_uint32(file, 4); version != 2) {
        fail(4, fmt::format("version {} instead of 2", version));
    }
    GltfContainer container;
    const uint32_t length = read_uint32(file, 8);
    if (length > file.size()) {
        fail(8, fmt::format("the header says {} bytes, but there are {}", length, file.size()));
    }
    if (length < file.size()) container.warnings.insert("GLB: bytes after its end are ignored");

    bool have_json = false;
    for (size_t offset = 12, index = 0; offset < length; ++index) {
        if (length - offset < 8) fail(offset, "a chunk's header is truncated");
        const uint32_t size = read_uint32(file, offset), type = read_uint32(file, offset + 4);
        offset += 8;
        if (size > length - offset) fail(offset - 8, "the chunk is longer than the file");
        const auto data = file.subspan(offset, size);
        if (index == 0) {
            if (type != chunk_json) fail(offset - 4, "the first chunk is not JSON");
            container.json = text(data);
            have_json = true;
        } else if (index == 1 && type == chunk_bin) {
            container.bin = data;
        } else if (type == chunk_json || type == chunk_bin) {
            container.warnings.insert("GLB: a misplaced or second chunk is ignored");
        }
        offset += size;
        // The last chunk's padding may be missing; chunks after an unpadded one are not found.
        if (size % 4 != 0)
            container.warnings.insert("GLB: a chunk's length is not a multiple of 4");
    }
    if (!have_json) fail(12, "there is no JSON chunk");
    return container;
}

}  // namespace

GltfContainer split_container(std::span<const std::byte> file, const std::string& path) {
    if (file.size() >= 4 && read_uint32(file, 0) == magic_gltf) return split_glb(file, path);
    GltfContainer container;
    container.json = text(file);
    return container;
}

std::optional<std::string> percent_decode(std::string_view text) {
    std::string decoded;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        if (text.size() - i < 3) return {};
        const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
        if (high < 0 || low < 0) return {};
        decoded += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return decoded;
}

bool is_data_uri(std::string_view uri) {
    constexpr std::string_view scheme = "data:";
    return uri.size() >= scheme.size() &&
           std::equal(scheme.begin(), scheme.end(), uri.begin(),
                      [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b + 32 : b); });
}

std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) return {};
    const std::string_view type = uri.substr(0, comma), data = uri.substr(comma + 1);
    const bool base64 = type.ends_with(";base64");
    if (base64 && data.find('%') == std::string_view::npos) return decode_base64(data);
    const auto decoded = percent_decode(data);
    if (!decoded) return {};
    if (base64) return decode_base64(*decoded);
    const auto bytes = std::as_bytes(std::span(*decoded));
    return std::vector(bytes.begin(), bytes.end());
}

}  // namespace sightline
