#include "image/write_image.h"

#include "core/error.h"
#include "core/files.h"
#include "image/jpeg.h"
#include "image/module.h"
#include "image/png.h"
#include "image/sniff.h"
#include "image/webp_alpha.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

using Bytes = std::vector<std::byte>;

ImageFormat format_of(const std::string& path) {
    const std::string extension = extension_of(path);
    if (extension == ".png") return ImageFormat::png;
    if (extension == ".jpg" || extension == ".jpeg") return ImageFormat::jpeg;
    if (extension == ".tif" || extension == ".tiff") return ImageFormat::tiff;
    if (extension == ".webp") return ImageFormat::webp;
    if (extension == ".hdr") return ImageFormat::hdr;
    throw Error(path + ": unknown extension; known: .png .jpg .tif .webp .hdr");
}

/// How many channels the encoder gets.
int channels_for(ImageFormat format, int channels) {
    switch (format) {
        case ImageFormat::jpeg:
            return channels < 3 ? 1 : 3;
        case ImageFormat::webp:  // write_image adds alpha
        case ImageFormat::hdr:
            return 3;
        default:
            return channels;
    }
}

/// Drops alpha or expands grey to RGB.
template <class T>
std::vector<T> with_channels(const std::vector<T>& values, int from, int to) {
    const auto in = static_cast<size_t>(from), out = static_cast<size_t>(to);
    std::vector<T> result;
    result.reserve(values.size() / in * out);
    for (size_t i = 0; i < values.size(); i += in)
        for (size_t c = 0; c < out; ++c) result.push_back(values[i + (in < 3 ? 0 : c)]);
    return result;
}

Bytes encode(const std::string& path, const Image& image, ImageFormat format) {
    if (format == ImageFormat::png) return encode_png(image);
    if (format == ImageFormat::jpeg) return encode_jpeg(image, path);
    const bool floats = !image.floats.empty();
    const void* pixels = floats ? static_cast<const void*>(image.floats.data())
                                : static_cast<const void*>(image.bytes.data());
    const ImageLayout shape{image.width, image.height, image.channels, floats};
    Bytes file;
    const auto take = [](void* context, const void* data, size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        static_cast<Bytes*>(context)->assign(begin, begin + size);
    };
    ModuleMessage message{};
    if (!image_module_for(format, path)
             .encode(module_format(format), &shape, pixels, take, &file, &message))
        throw Error(fmt::format("{}: cannot encode {}: {}", path, to_string(format), message.text));
    return file;
}

/// The values of the last of 2 or 4 channels; empty if all pixels are opaque.
std::vector<uint8_t> alpha_of(const Image& image) {
    std::vector<uint8_t> alpha;
    const auto channels = static_cast<size_t>(image.channels);
    if (channels % 2 != 0) return alpha;
    for (size_t i = channels - 1; i < image.bytes.size(); i += channels)
        alpha.push_back(image.bytes[i]);
    if (std::all_of(alpha.begin(), alpha.end(), [](uint8_t a) { return a == 255; })) alpha.clear();
    return alpha;
}

}  // namespace

void write_image(const std::string& path, const Image& image) {
    const ImageFormat format = format_of(path);
    const bool floats = !image.floats.empty();
    if (floats != (format == ImageFormat::hdr) && format != ImageFormat::tiff) {
        throw Error(fmt::format("{}: {} does not hold {} values", path, to_string(format),
                                floats ? "float" : "8-bit"));
    }
    const int channels = channels_for(format, image.channels);
    Bytes file;
    if (channels == image.channels) {
        file = encode(path, image, format);
    } else {
        Image changed;
        changed.width = image.width;
        changed.height = image.height;
        changed.channels = channels;
        changed.floats = with_channels(image.floats, image.channels, channels);
        changed.bytes = with_channels(image.bytes, image.channels, channels);
        file = encode(path, changed, format);
    }
    if (format == ImageFormat::webp) {
        const std::vector<uint8_t> alpha = alpha_of(image);
        if (!alpha.empty())
            file = with_webp_alpha(file, static_cast<uint32_t>(image.width),
                                   static_cast<uint32_t>(image.height), alpha);
    }
    write_file(path, file);
}

}  // namespace sightline
