#include "image/image.h"

#include "core/error.h"
#include "core/files.h"
#include "image/module.h"
#include "image/sniff.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace sightline {
namespace {

/// The name of the format in OpenImageIO.
const char* plugin(ImageFormat format) {
    constexpr const char* names[] = {"png", "jpeg", "webp", "heif", "hdr", "openexr", "tiff"};
    return names[static_cast<size_t>(format)];
}

const ImageModule& module_for(ImageFormat format, const std::string& name) {
    const ImageModule& module = image_module();
    if (!module.knows(plugin(format))) {
        throw Error(fmt::format("{}: this machine's OpenImageIO has no {} support", name,
                                to_string(format)));
    }
    return module;
}

size_t value_count(const Image& image) {
    return static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
           static_cast<size_t>(image.channels);
}

Image allocate(const PictureShape& shape) {
    Image image;
    image.width = shape.width;
    image.height = shape.height;
    image.channels = shape.channels;
    if (shape.floats) {
        image.floats.resize(value_count(image));
    } else {
        image.bytes.resize(value_count(image));
    }
    return image;
}

}  // namespace

Image decode_image(std::span<const std::byte> file, const std::string& name,
                   const ImageLimits& limits) {
    const std::optional<ImageFormat> format = sniff_image(file);
    if (!format) throw Error(name + ": not a PNG, JPEG, WebP, AVIF, HDR, EXR or TIFF picture");
    check_image_header(file, *format, limits.max_pixels, name);

    const ImageModule& module = module_for(*format, name);
    const auto fail = [&](const ModuleMessage& message) {
        throw Error(
            fmt::format("{}: cannot decode {}: {}", name, to_string(*format), message.text));
    };
    ModuleMessage message{};
    PictureShape shape{};
    const std::unique_ptr<void, void (*)(void*)> decoder(
        module.open(plugin(*format), file.data(), file.size(), &shape, &message), module.close);
    if (!decoder) fail(message);
    if (shape.width < 0 || shape.height < 0 || shape.channels < 1) fail({"impossible size"});
    check_image_size(static_cast<uint64_t>(shape.width), static_cast<uint64_t>(shape.height),
                     limits.max_pixels, name);
    Image image = allocate(shape);
    void* pixels = shape.floats ? static_cast<void*>(image.floats.data()) : image.bytes.data();
    if (!module.read(decoder.get(), pixels, &message)) fail(message);
    return image;
}

Image read_image(const std::string& path, const ImageLimits& limits) {
    constexpr uint64_t max_bytes = 1ull << 32;
    return decode_image(read_file(path, max_bytes), path, limits);
}

namespace {

ImageFormat format_of(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (ending == ".png") return ImageFormat::png;
    if (ending == ".jpg" || ending == ".jpeg") return ImageFormat::jpeg;
    if (ending == ".tif" || ending == ".tiff") return ImageFormat::tiff;
    if (ending == ".webp") return ImageFormat::webp;
    if (ending == ".hdr") return ImageFormat::hdr;
    throw Error(path + ": unknown ending; known: .png .jpg .tif .webp .hdr");
}

/// The picture with as many channels as the format can hold: without alpha, grey spread to RGB.
template <class T>
std::vector<T> with_channels(const std::vector<T>& values, int from, int to) {
    const auto in = static_cast<size_t>(from), out = static_cast<size_t>(to);
    std::vector<T> result;
    result.reserve(values.size() / in * out);
    for (size_t i = 0; i < values.size(); i += in) {
        for (size_t c = 0; c < out; ++c) {
            const bool alpha = c == 3;
            result.push_back(values[i + (alpha ? in - 1 : in < 3 ? 0 : c)]);
        }
    }
    return result;
}

int channels_for(ImageFormat format, int channels) {
    switch (format) {
        case ImageFormat::jpeg:
            return channels < 3 ? 1 : 3;
        case ImageFormat::hdr:
            return 3;
        case ImageFormat::webp:
            return channels % 2 == 0 ? 4 : 3;
        default:
            return channels;
    }
}

}  // namespace

void write_image(const std::string& path, const Image& image) {
    const ImageFormat format = format_of(path);
    const bool floats = !image.floats.empty();
    if (floats != (format == ImageFormat::hdr) && format != ImageFormat::tiff) {
        throw Error(fmt::format("{}: {} holds {} values", path, to_string(format),
                                floats ? "8-bit" : "float"));
    }
    const int channels = channels_for(format, image.channels);
    Image changed;
    const Image* source = &image;
    if (channels != image.channels) {
        changed.floats = with_channels(image.floats, image.channels, channels);
        changed.bytes = with_channels(image.bytes, image.channels, channels);
        source = &changed;
    }
    const ImageModule& module = module_for(format, path);
    const PictureShape shape{image.width, image.height, channels, floats};
    const void* pixels = floats ? static_cast<const void*>(source->floats.data())
                                : static_cast<const void*>(source->bytes.data());
    std::vector<std::byte> file;
    const auto take = [](void* context, const void* data, size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        static_cast<std::vector<std::byte>*>(context)->assign(begin, begin + size);
    };
    ModuleMessage message{};
    if (!module.encode(plugin(format), &shape, pixels, take, &file, &message)) {
        throw Error(fmt::format("{}: cannot encode {}: {}", path, to_string(format), message.text));
    }
    write_file(path, file);
}

}  // namespace sightline
