#include "image/webp_alpha.h"

#include "core/bytes.h"

#include <algorithm>
#include <cstring>
#include <string_view>

namespace sightline {

// RFC 9649: RIFF chunks of a four-letter name, a little-endian size and a body of even length.

namespace {

void append(std::vector<std::byte>& file, std::string_view text) {
    for (const char c : text) file.push_back(static_cast<std::byte>(c));
}

void append(std::vector<std::byte>& file, size_t number, int bytes) {
    for (int i = 0; i < bytes; ++i) file.push_back(static_cast<std::byte>(number >> 8 * i));
}

}  // namespace

std::vector<std::byte> without_webp_alpha(std::span<const std::byte> file) {
    std::vector<std::byte> opaque(file.begin(), file.end());
    constexpr size_t head = 8;
    for (size_t at = 12; at + head < opaque.size();) {
        std::byte* const name = &opaque[at];
        const size_t size = little_endian(std::span(opaque).subspan(at + 4, 4));
        const auto is = [&](const char* other) { return std::memcmp(name, other, 4) == 0; };
        if (size > opaque.size() - at - head) break;
        if (is("VP8X") && size > 0)
            opaque[at + head] &= ~std::byte{0x10};
        else if (is("ALPH"))
            std::memcpy(name, "none", 4);  // chunks of unknown name are skipped
        else if (is("VP8L") && size > 4)
            opaque[at + head + 4] &= ~std::byte{0x10};
        at += head + size + size % 2;
    }
    return opaque;
}

std::vector<std::byte> with_webp_alpha(std::span<const std::byte> opaque, uint32_t width,
                                       uint32_t height, std::span<const uint8_t> alpha) {
    std::vector<std::byte> file;
    append(file, "RIFF");
    append(file, 0, 4);  // the size, below
    append(file, "WEBPVP8X");
    append(file, 10, 4);
    append(file, 0x10, 4);  // has alpha
    append(file, width - 1, 3);
    append(file, height - 1, 3);
    append(file, "ALPH");
    append(file, alpha.size() + 1, 4);
    append(file, 0, 1);  // neither filtered nor compressed
    for (const uint8_t a : alpha) file.push_back(static_cast<std::byte>(a));
    if (alpha.size() % 2 == 0) append(file, 0, 1);
    const auto chunks = opaque.subspan(std::min<size_t>(12, opaque.size()));
    file.insert(file.end(), chunks.begin(), chunks.end());
    for (size_t i = 0; i < 4; ++i) file[4 + i] = static_cast<std::byte>((file.size() - 8) >> 8 * i);
    return file;
}

}  // namespace sightline
