#pragma once
// WebP's alpha, past OpenImageIO 2, which multiplies and divides colours by it in 8 bits.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

/// The same WebP marked as opaque, so that a decoder gives its colours as they are stored and not
/// multiplied by alpha.
std::vector<std::byte> without_webp_alpha(std::span<const std::byte> file);

/// An opaque, lossy WebP with a plane of alpha added, a byte per pixel.
std::vector<std::byte> with_webp_alpha(std::span<const std::byte> opaque, uint32_t width,
                                       uint32_t height, std::span<const uint8_t> alpha);

}  // namespace sightline
