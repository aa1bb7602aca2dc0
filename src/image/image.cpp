#include "image/image.h"

#include "core/error.h"
#include "core/files.h"
#include "image/halving.h"
#include "image/hdr_orientation.h"
#include "image/jpeg.h"
#include "image/module.h"
#include "image/png.h"
#include "image/sniff.h"
#include "image/webp_alpha.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>

namespace sightline {
namespace {

size_t value_count(const Image& image) {
    return static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
           static_cast<size_t>(image.channels);
}

Image allocate(const ImageLayout& shape) {
    Image image;
    image.width = shape.width;
    image.height = shape.height;
    image.channels = shape.channels;
    if (shape.floats)
        image.floats.resize(value_count(image));
    else
        image.bytes.resize(value_count(image));
    return image;
}

Image decode(std::span<const std::byte> file, ImageFormat format, const std::string& name,
             const ImageLimits& limits) {
    const ImageModule& module = image_module_for(format, name);
    const auto fail = [&](const ModuleMessage& message) {
        if (message.out_of_memory) throw std::bad_alloc();
        throw Error(fmt::format("{}: cannot decode {}: {}", name, to_string(format), message.text));
    };
    ModuleMessage message{};
    ImageLayout shape{};
    const std::unique_ptr<void, void (*)(void*)> decoder(
        module.open(module_format(format), file.data(), file.size(), &shape, &message),
        module.close);
    if (!decoder) fail(message);
    if (shape.width < 0 || shape.height < 0 || shape.channels < 1) fail({"impossible size", false});
    check_image_size(static_cast<uint64_t>(shape.width), static_cast<uint64_t>(shape.height),
                     limits.max_pixels, name);
    Image image = allocate(shape);
    void* pixels = shape.floats ? static_cast<void*>(image.floats.data()) : image.bytes.data();
    if (!module.read(decoder.get(), pixels, &message)) fail(message);
    return image;
}

/// Decodes a WebP's colours again, without alpha, because OpenImageIO 2.4 multiplies them by alpha
/// and loses them if it is 0.
void restore_webp_colors(Image& image, std::span<const std::byte> file, const std::string& name,
                         const ImageLimits& limits) {
    const Image opaque = decode(without_webp_alpha(file), ImageFormat::webp, name, limits);
    if (opaque.channels != 3 || opaque.bytes.size() / 3 != image.bytes.size() / 4) return;
    for (size_t from = 0, to = 0; to < image.bytes.size(); from += 3, to += 4)
        std::copy_n(&opaque.bytes[from], 3, &image.bytes[to]);
}

Image decode_hdr(std::span<const std::byte> file, const std::string& name,
                 const ImageLimits& limits) {
    const std::optional<HdrOrientation> orientation = hdr_orientation(file);
    if (!orientation || orientation->is_upright())
        return decode(file, ImageFormat::hdr, name, limits);
    const std::vector<std::byte> scanlines = as_upright_hdr(file, *orientation);
    return upright(decode(scanlines, ImageFormat::hdr, name, limits), *orientation);
}

}  // namespace

Image decode_image(std::span<const std::byte> file, const std::string& name,
                   const ImageLimits& limits, const WantedLevel& wanted) {
    const std::optional<ImageFormat> format = sniff_image(file);
    if (!format)
        throw Error(name + ": not a PNG, JPEG, WebP, AVIF, HDR, EXR, TIFF, GIF or BMP image");
    check_image_header(file, *format, limits.max_pixels, name);
    if (*format == ImageFormat::png) return decode_png(file, name, limits, wanted);
    if (*format == ImageFormat::jpeg) return decode_jpeg(file, name, limits, wanted);
    if (*format == ImageFormat::hdr) return decode_hdr(file, name, limits);
    Image image = decode(file, *format, name, limits);
    image.by_module = true;
    if (*format == ImageFormat::webp && image.channels == 4)
        restore_webp_colors(image, file, name, limits);
    keep_level(image, wanted);
    return image;
}

Image read_image(const std::string& path, const ImageLimits& limits) {
    return decode_image(read_file(path, limits.max_file_bytes), path, limits);
}

}  // namespace sightline
