#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline {

enum class ImageFormat { png, jpeg, webp, avif, hdr, exr, tiff };

/// The format of a picture, by its first bytes; nothing where it is none of ours.
std::optional<ImageFormat> sniff_image(std::span<const std::byte> file);

/// Refuses, from the file's bytes alone, what would make its decoder allocate without bound before
/// it tells the picture's size, and a PNG whose chunks are damaged (libpng would print so itself).
/// `name` is for messages. Throws Error.
void check_image_header(std::span<const std::byte> file, ImageFormat format, uint64_t max_pixels,
                        const std::string& name);

/// Throws Error when a picture has no pixel, more than `max_pixels`, or an absurd side.
void check_image_size(uint64_t width, uint64_t height, uint64_t max_pixels,
                      const std::string& name);

/// How people write the format: "PNG", "JPEG" ….
const char* to_string(ImageFormat format);

}  // namespace sightline
