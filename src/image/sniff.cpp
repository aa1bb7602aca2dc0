#include "image/sniff.h"

#include "core/bytes.h"
#include "core/error.h"
#include "image/halving.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace sightline {
namespace {

struct Size {
    uint64_t width, height;
};

/// Part of the file as text, for comparisons; empty beyond the end.
std::string_view text(std::span<const std::byte> file, size_t offset = 0,
                      size_t count = std::string_view::npos) {
    const std::string_view all(reinterpret_cast<const char*>(file.data()), file.size());
    return offset > all.size() ? std::string_view() : all.substr(offset, count);
}

/// `count` bytes of the file; none if it ends before.
std::span<const std::byte> part(std::span<const std::byte> file, size_t offset, size_t count) {
    if (offset + count > file.size()) return {};
    return file.subspan(offset, count);
}

uint64_t big(std::span<const std::byte> file, size_t offset, size_t count) {
    return big_endian(part(file, offset, count));
}

uint64_t little(std::span<const std::byte> file, size_t offset, size_t count) {
    return little_endian(part(file, offset, count));
}

/// The frame header (ITU-T T.81, B.2.2) is the first segment C0 … CF except C4, C8 and CC.
std::optional<Size> jpeg_size(std::span<const std::byte> file) {
    size_t at = 2;
    while (at + 9 < file.size()) {
        if (big(file, at, 1) != 0xff) return std::nullopt;
        const uint64_t marker = big(file, at + 1, 1);
        if (marker == 0xff)
            ++at;
        else if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 &&
                 marker != 0xcc)
            return Size{big(file, at + 7, 2), big(file, at + 5, 2)};
        else
            at += 2 + big(file, at + 2, 2);
    }
    return std::nullopt;
}

/// A decoder passes over the whole image once per scan of a progressive JPEG, in up to half a
/// nanosecond for each pixel; usual files have about ten. In coded data FF is never followed by DA.
void check_jpeg_scans(std::span<const std::byte> file, uint64_t pixels, const std::string& name) {
    constexpr uint64_t most = 200, full_size = 1 << 24;  // above that size, fewer
    const uint64_t max_scans = std::min(most, most * full_size / std::max(pixels, uint64_t{1}));
    uint64_t scans = 0;
    for (size_t at = text(file).find("\xff\xda"); at != std::string_view::npos;
         at = text(file).find("\xff\xda", at + 2))
        if (++scans > max_scans)
            throw Error(fmt::format("{}: JPEG with more than {} scans", name, max_scans));
}

std::optional<Size> webp_size(std::span<const std::byte> file) {
    const std::string_view chunk = text(file, 12, 4);
    if (chunk == "VP8X") return Size{little(file, 24, 3) + 1, little(file, 27, 3) + 1};
    if (chunk == "VP8 ") return Size{little(file, 26, 2) & 0x3fff, little(file, 28, 2) & 0x3fff};
    if (chunk == "VP8L") {
        const uint64_t bits = little(file, 21, 4);
        return Size{(bits & 0x3fff) + 1, (bits >> 14 & 0x3fff) + 1};
    }
    return std::nullopt;
}

/// The largest image spatial extents box: an image may be a grid of smaller ones.
std::optional<Size> avif_size(std::span<const std::byte> file) {
    std::optional<Size> largest;
    for (size_t at = text(file).find("ispe"); at != std::string_view::npos;
         at = text(file).find("ispe", at + 4)) {
        const Size size{big(file, at + 8, 4), big(file, at + 12, 4)};
        if (!largest || size.width * size.height > largest->width * largest->height) largest = size;
    }
    return largest;
}

/// Of a BITMAPCOREHEADER, 12 bytes long, or of a BITMAPINFOHEADER and those that extend it, in
/// which a negative height marks rows from the top.
Size bmp_size(std::span<const std::byte> file) {
    if (little(file, 14, 4) == 12) return {little(file, 18, 2), little(file, 20, 2)};
    const auto height = static_cast<int32_t>(static_cast<uint32_t>(little(file, 22, 4)));
    return {little(file, 18, 4), static_cast<uint64_t>(std::abs(int64_t{height}))};
}

/// The size in the header, for formats whose decoders allocate by it while opening.
std::optional<Size> claimed_size(std::span<const std::byte> file, ImageFormat format) {
    switch (format) {
        case ImageFormat::png:
            return Size{big(file, 16, 4), big(file, 20, 4)};
        case ImageFormat::jpeg:
            return jpeg_size(file);
        case ImageFormat::webp:
            return webp_size(file);
        case ImageFormat::avif:
            return avif_size(file);
        case ImageFormat::gif:
            return Size{little(file, 6, 2), little(file, 8, 2)};
        case ImageFormat::bmp:
            return bmp_size(file);
        default:
            return Size{1, 1};  // the decoder reports it before it allocates
    }
}

/// OpenEXR allocates attributes, lines and tiles when it opens a file, so this checks the sizes in
/// the headers ("OpenEXR File Layout"). OpenEXR itself reports other errors.
void check_exr_header(std::span<const std::byte> file, uint64_t max_pixels,
                      const std::string& name) {
    constexpr uint64_t max_tile_pixels = 1 << 24;
    const auto corner = [&](size_t offset) {
        return static_cast<int32_t>(static_cast<uint32_t>(little(file, offset, 4)));
    };
    const auto extent = [&](size_t from, size_t to) -> uint64_t {
        const int64_t length = int64_t{corner(to)} - corner(from) + 1;
        return length > 0 ? static_cast<uint64_t>(length) : 0;
    };
    const bool multipart = (little(file, 4, 4) & 0x1000) != 0;
    for (size_t at = 8; at < file.size();) {
        if (file[at] == std::byte{0}) {
            ++at;
            if (!multipart || at >= file.size() || file[at] == std::byte{0}) return;
        }
        const std::string_view attribute = text(file, at, text(file, at, 256).find('\0'));
        const size_t type_at = at + attribute.size() + 1;
        const std::string_view type = text(file, type_at, text(file, type_at, 256).find('\0'));
        const size_t value = type_at + type.size() + 1 + 4;
        if (attribute.size() > 255 || type.size() > 255 || value > file.size()) return;
        if (type == "box2i" && (attribute == "dataWindow" || attribute == "displayWindow")) {
            check_image_size(extent(value, value + 8), extent(value + 4, value + 12), max_pixels,
                             name);
        } else if (type == "tiledesc") {
            check_image_size(little(file, value, 4), little(file, value + 4, 4), max_tile_pixels,
                             name + ": tiles");
        }
        const uint64_t size = little(file, value - 4, 4);
        if (size > file.size() - value)
            throw Error(fmt::format("{}: damaged EXR: attribute {} is truncated", name, attribute));
        at = value + size;
    }
}

/// Whether a level is made of the rows as they are decoded, so that the image is never held whole.
bool has_ordered_rows(std::span<const std::byte> file, ImageFormat format) {
    const bool is_interlaced = format == ImageFormat::png && big(file, 28, 1) != 0;
    return format == ImageFormat::jpeg || (format == ImageFormat::png && !is_interlaced);
}

bool is_deep_png(std::span<const std::byte> file, ImageFormat format) {
    return format == ImageFormat::png && big(file, 24, 1) == 16;
}

}  // namespace

const char* to_string(ImageFormat format) {
    constexpr const char* names[] = {"PNG", "JPEG", "WebP", "AVIF", "HDR",
                                     "EXR", "TIFF", "GIF",  "BMP"};
    return names[static_cast<size_t>(format)];
}

std::optional<ImageFormat> sniff_image(std::span<const std::byte> file) {
    using namespace std::string_view_literals;
    const std::string_view start = text(file, 0, 16);
    if (start.starts_with("\x89PNG\r\n\x1a\n"sv)) return ImageFormat::png;
    if (start.starts_with("\xff\xd8\xff"sv)) return ImageFormat::jpeg;
    if (start.starts_with("RIFF"sv) && text(file, 8, 4) == "WEBP") return ImageFormat::webp;
    if (text(file, 4, 4) == "ftyp") {
        const std::string_view brands = text(file, 8, std::min<uint64_t>(big(file, 0, 4), 128));
        if (brands.find("avif") != std::string_view::npos) return ImageFormat::avif;
    }
    if (start.starts_with("#?RADIANCE"sv) || start.starts_with("#?RGBE"sv)) return ImageFormat::hdr;
    if (start.starts_with("\x76\x2f\x31\x01"sv)) return ImageFormat::exr;
    if (start.starts_with("II*\0"sv) || start.starts_with("MM\0*"sv)) return ImageFormat::tiff;
    if (start.starts_with("GIF87a"sv) || start.starts_with("GIF89a"sv)) return ImageFormat::gif;
    if (start.starts_with("BM"sv) && file.size() >= 26) return ImageFormat::bmp;
    return std::nullopt;
}

void check_image_size(uint64_t width, uint64_t height, uint64_t max_pixels,
                      const std::string& name) {
    constexpr uint64_t max_side = 1 << 16;
    if (width == 0 || height == 0) throw Error(name + ": the image has no pixels");
    if (width > max_side || height > max_side) {
        throw LimitError(
            fmt::format("{}: {} x {} pixels, more than {} a side", name, width, height, max_side));
    }
    if (width > max_pixels / height) {
        throw LimitError(
            fmt::format("{}: {} x {} pixels, more than the limit of {} "
                        "(--max-image-pixels)",
                        name, width, height, max_pixels));
    }
}

uint64_t decoded_bytes(std::span<const std::byte> file, int level) {
    const std::optional<ImageFormat> format = sniff_image(file);
    if (!format) return 0;
    const bool is_known =
        *format != ImageFormat::hdr && *format != ImageFormat::exr && *format != ImageFormat::tiff;
    const std::optional<Size> size = claimed_size(file, *format);
    if (!is_known || !size) return 0;
    constexpr uint64_t channels = 4, max_side = 1ull << 31;
    const uint64_t pixels = std::min(size->width, max_side) * std::min(size->height, max_side);
    if (is_deep_png(file, *format)) return pixels * channels * sizeof(float);
    if (!has_ordered_rows(file, *format)) return pixels * channels;
    const auto [width, height] = byte_image_size(file);
    return pixels * channels >> 2 * exact_level(width, height, level);
}

std::array<int, 2> byte_image_size(std::span<const std::byte> file) {
    const std::optional<ImageFormat> format = sniff_image(file);
    if (!format || is_deep_png(file, *format)) return {0, 0};
    if (*format == ImageFormat::hdr || *format == ImageFormat::exr || *format == ImageFormat::tiff)
        return {0, 0};
    const std::optional<Size> size = claimed_size(file, *format);
    constexpr uint64_t max_side = 1 << 16;
    if (!size || size->width > max_side || size->height > max_side) return {0, 0};
    return {static_cast<int>(size->width), static_cast<int>(size->height)};
}

void check_image_header(std::span<const std::byte> file, ImageFormat format, uint64_t max_pixels,
                        const std::string& name) {
    const std::optional<Size> size = claimed_size(file, format);
    if (!size) throw Error(fmt::format("{}: damaged {}: no header", name, to_string(format)));
    check_image_size(size->width, size->height, max_pixels, name);
    if (format == ImageFormat::jpeg) check_jpeg_scans(file, size->width * size->height, name);
    if (format == ImageFormat::exr) check_exr_header(file, max_pixels, name);
}

}  // namespace sightline
