#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// Damage of a file that costs no pixel.
enum class ImageDamage { png_checksum, png_end, jpeg_end };

/// A decoded image: rows from the top, pixels from the left, channels interleaved.
/// Exactly one of `bytes` (8-bit, as stored: sRGB colours stay encoded) and `floats`
/// (16-bit and float sources; linear for HDR and EXR) holds width·height·channels values.
struct Image {
    int width = 0, height = 0;
    int channels = 0;  ///< 1 grey, 2 grey+alpha, 3 RGB, 4 RGBA
    int level = 0;     ///< of the pyramid: the file has 2^level times the width and the height
    std::vector<uint8_t> bytes;
    std::vector<float> floats;
    std::optional<ImageDamage> damage;  ///< what was passed over
    std::string damage_place;           ///< what and where, in words
    bool by_module = false;             ///< OpenImageIO has decoded it

    bool empty() const { return width == 0; }
    size_t memory() const { return bytes.size() + floats.size() * sizeof(float); }
};

/// Limits for images from untrusted files.
struct ImageLimits {
    uint64_t max_pixels = 1ull << 26;  ///< per image, checked from the header before decoding
    /// Of a file that read_image reads: what max_pixels of four floats take.
    uint64_t max_file_bytes = 1ull << 30;
};

/// Which level of an image's pyramid to decode. Each level has half the width and the height of the
/// one before, and means of 2 × 2 of its pixels.
struct WantedLevel {
    int level = 0;      ///< 0: the image itself
    bool srgb = false;  ///< colours are sRGB-encoded: means are those of linear light

    bool operator==(const WantedLevel&) const = default;
};

/// Decodes a PNG, JPEG, WebP, AVIF, HDR, EXR, TIFF, GIF or BMP, recognised by its content.
/// Alpha stays as stored: straight, except in EXR. The image covers an EXR's display window. The
/// orientation of an HDR is applied; that of EXIF, gamma and colour profiles are not. `name` is
/// for messages. The level is finer than wanted where the size is no multiple of 2^level, and 0 for
/// images of floats. A coarse level of a JPEG is decoded at 1/2, 1/4 or 1/8, one level finer than
/// wanted or, of sRGB-encoded colours, two, and halved. Throws Error on other formats, on damage
/// that costs pixels, and beyond the limits.
Image decode_image(std::span<const std::byte> file, const std::string& name,
                   const ImageLimits& limits = {}, const WantedLevel& wanted = {});

/// Decodes an image file. Throws Error as decode_image does, and LimitError if it is larger than
/// the limit.
Image read_image(const std::string& path, const ImageLimits& limits = {});

}  // namespace sightline
