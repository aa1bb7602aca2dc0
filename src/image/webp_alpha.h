#pragma once
// A work-around for OpenImageIO 2, which multiplies and divides a WebP's colours by alpha in 8
// bits.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

/// The same WebP marked as opaque, so that a decoder returns its colours as stored, not multiplied
/// by alpha.
std::vector<std::byte> without_webp_alpha(std::span<const std::byte> file);

/// An opaque, lossy WebP with an alpha plane added, one byte per pixel.
std::vector<std::byte> with_webp_alpha(std::span<const std::byte> opaque, uint32_t width,
                                       uint32_t height, std::span<const uint8_t> alpha);

}  // namespace sightline
