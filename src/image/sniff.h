#pragma once
// A guard in front of the decoders: recognises the format and rejects headers with which a decoder
// would allocate memory without bound.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline {

enum class ImageFormat { png, jpeg, webp, avif, hdr, exr, tiff, gif, bmp };

/// The format of an image file by its first bytes; empty if it is not supported.
std::optional<ImageFormat> sniff_image(std::span<const std::byte> file);

/// Rejects, from the file's bytes alone, images for which the decoder would allocate without bound
/// before it reports their size, and JPEGs of endless scans. `name` is for messages. Throws Error.
void check_image_header(std::span<const std::byte> file, ImageFormat format, uint64_t max_pixels,
                        const std::string& name);

/// Throws Error if an image has no pixels, LimitError if it has more than `max_pixels`, or a side
/// above 65536.
void check_image_size(uint64_t width, uint64_t height, uint64_t max_pixels,
                      const std::string& name);

/// The bytes that decoding a level of the image (see WantedLevel) takes at most, by its header: of
/// the whole image if that is held before; 0 if only decoding tells.
uint64_t decoded_bytes(std::span<const std::byte> file, int level = 0);

/// The width and the height in the header of an image of 8-bit values; zeros for other images and
/// if only decoding tells.
std::array<int, 2> byte_image_size(std::span<const std::byte> file);

/// The format's usual name: "PNG", "JPEG" ….
const char* to_string(ImageFormat format);

}  // namespace sightline
