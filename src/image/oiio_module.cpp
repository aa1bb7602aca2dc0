// The module that contains OpenImageIO; no other file includes it.
#include "core/version.h"
#include "image/module.h"

#include <OpenImageIO/color.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace sightline {
namespace {

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

/// A file in memory that has a path, for formats that OpenImageIO can only open by path.
class MemoryFile {
  public:
    MemoryFile() : fd_(memfd_create("sightline", MFD_CLOEXEC)) {
        if (fd_ < 0) throw std::runtime_error("cannot create a file in memory");
    }
    ~MemoryFile() { ::close(fd_); }
    MemoryFile(const MemoryFile&) = delete;

    std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

    void fill(const void* data, size_t size) {
        for (size_t done = 0; done < size;) {
            const ssize_t wrote = ::write(fd_, static_cast<const char*>(data) + done, size - done);
            if (wrote <= 0) throw std::runtime_error("cannot create a file in memory");
            done += static_cast<size_t>(wrote);
        }
    }

    std::vector<unsigned char> contents() const {
        std::vector<unsigned char> bytes(static_cast<size_t>(lseek(fd_, 0, SEEK_END)));
        size_t done = 0;
        while (done < bytes.size()) {
            const ssize_t got =
                pread(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
            if (got <= 0) throw std::runtime_error("cannot read a file in memory");
            done += static_cast<size_t>(got);
        }
        return bytes;
    }

  private:
    int fd_;
};

/// An image whose header has been read. The order of the members matters: the input must be
/// destroyed before the bytes that it reads.
struct Decoder {
    std::unique_ptr<OIIO::Filesystem::IOMemReader> bytes;
    std::unique_ptr<MemoryFile> file;
    std::unique_ptr<ImageInput> input;
    int first_channel = 0;
    ImageLayout shape{};
};

std::string first_line(std::string text) {
    text.erase(std::find(text.begin(), text.end(), '\n'), text.end());
    return text.empty() ? "unknown reason" : text;
}

void set_message(ModuleMessage* message, const std::string& text) {
    const size_t length = std::min(text.size(), sizeof message->text - 1);
    std::memcpy(message->text, text.data(), length);
    message->text[length] = 0;
}

/// Runs `work`. Returns false and a message if it throws.
template <class Work>
bool guarded(ModuleMessage* message, const Work& work) {
    try {
        work();
        return true;
    } catch (const std::bad_alloc&) {
        set_message(message, "not enough memory");
        message->out_of_memory = true;
    } catch (const std::exception& error) {
        set_message(message, first_line(error.what()));
    } catch (...) {
        set_message(message, "unknown reason");
    }
    return false;
}

std::unique_ptr<ImageInput> make_input(const char* format) {
    auto input = ImageInput::create(format);
    if (!input) throw std::runtime_error(first_line(OIIO::geterror()));
    return input;
}

/// The last part of a channel's name: "R" of "beauty.R".
std::string plane(const std::string& channel) { return channel.substr(channel.rfind('.') + 1); }

/// Chooses the channels of an EXR to read: adjacent R, G, B and, if present, A; or Y alone.
void choose_exr_channels(const ImageSpec& spec, Decoder& decoder) {
    const auto is = [&](int i, const char* name) {
        return i < spec.nchannels && plane(spec.channelnames[static_cast<size_t>(i)]) == name;
    };
    for (int i = 0; i < spec.nchannels; ++i) {
        decoder.first_channel = i;
        if (is(i, "R") && is(i + 1, "G") && is(i + 2, "B")) {
            decoder.shape.channels = is(i + 3, "A") ? 4 : 3;
            return;
        }
        if (is(i, "Y")) {
            decoder.shape.channels = 1;
            return;
        }
    }
    throw std::runtime_error("has neither R, G, B nor Y channels");
}

void choose_layout(const char* format, const ImageSpec& spec, Decoder& decoder) {
    if (spec.deep) throw std::runtime_error("deep images are not supported");
    if (spec.depth > 1) throw std::runtime_error("volumes are not supported");
    ImageLayout& shape = decoder.shape;
    shape.floats = spec.format != TypeDesc::UINT8;
    if (std::strcmp(format, "openexr") == 0) {
        shape.width = spec.full_width;
        shape.height = spec.full_height;
        choose_exr_channels(spec, decoder);
        return;
    }
    shape.width = spec.width;
    shape.height = spec.height;
    const bool alpha = spec.alpha_channel == 3;
    shape.channels = spec.nchannels <= 4 ? spec.nchannels : alpha ? 4 : 3;
}

bool supports(const char* format) {
    bool supported = false;
    ModuleMessage ignored;
    guarded(&ignored, [&] {
        supported = ImageInput::create(format) != nullptr;
        if (!supported) OIIO::geterror();
    });
    return supported;
}

void* open(const char* format, const void* file, size_t size, ImageLayout* shape,
           ModuleMessage* message) {
    auto decoder = std::make_unique<Decoder>();
    const bool opened = guarded(message, [&] {
        decoder->input = make_input(format);
        ImageSpec wanted, found;
        wanted["oiio:UnassociatedAlpha"] = 1;
        std::string path = "image";
        if (decoder->input->supports("ioproxy")) {
            decoder->bytes =
                std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<void*>(file), size);
            decoder->input->set_ioproxy(decoder->bytes.get());
        } else {
            decoder->file = std::make_unique<MemoryFile>();
            decoder->file->fill(file, size);
            path = decoder->file->path();
        }
        if (!decoder->input->open(path, found, wanted))
            throw std::runtime_error(first_line(decoder->input->geterror()));
        choose_layout(format, found, *decoder);
    });
    *shape = decoder->shape;
    return opened ? decoder.release() : nullptr;
}

void read_channels(Decoder& decoder, void* pixels) {
    const TypeDesc type = decoder.shape.floats ? TypeDesc::FLOAT : TypeDesc::UINT8;
    ImageInput& input = *decoder.input;
    if (!input.read_image(0, 0, decoder.first_channel,
                          decoder.first_channel + decoder.shape.channels, type, pixels) ||
        input.has_error())
        throw std::runtime_error(first_line(input.geterror()));
}

/// Copies the data window of an EXR into its display window, which is black elsewhere.
void copy_window(const ImageSpec& spec, const ImageLayout& shape, const float* window,
                 float* image) {
    const auto channels = static_cast<size_t>(shape.channels);
    std::fill_n(image,
                static_cast<size_t>(shape.width) * static_cast<size_t>(shape.height) * channels,
                0.0f);
    const int left = spec.x - spec.full_x, top = spec.y - spec.full_y;
    const int x0 = std::max(left, 0), x1 = std::min(left + spec.width, shape.width);
    for (int y = std::max(top, 0); y < std::min(top + spec.height, shape.height) && x0 < x1; ++y) {
        const auto from = static_cast<size_t>(y - top) * static_cast<size_t>(spec.width) +
                          static_cast<size_t>(x0 - left);
        const auto to =
            static_cast<size_t>(y) * static_cast<size_t>(shape.width) + static_cast<size_t>(x0);
        std::copy_n(window + from * channels, static_cast<size_t>(x1 - x0) * channels,
                    image + to * channels);
    }
}

bool read(void* handle, void* pixels, ModuleMessage* message) {
    return guarded(message, [&] {
        Decoder& decoder = *static_cast<Decoder*>(handle);
        const ImageSpec spec = decoder.input->spec();
        const bool whole = std::strcmp(decoder.input->format_name(), "openexr") != 0 ||
                           (spec.x == spec.full_x && spec.y == spec.full_y &&
                            spec.width == spec.full_width && spec.height == spec.full_height);
        if (whole) return read_channels(decoder, pixels);
        decoder.shape.floats = true;
        std::vector<float> window(static_cast<size_t>(spec.width) *
                                  static_cast<size_t>(spec.height) *
                                  static_cast<size_t>(decoder.shape.channels));
        read_channels(decoder, window.data());
        copy_window(spec, decoder.shape, window.data(), static_cast<float*>(pixels));
    });
}

void close(void* decoder) { delete static_cast<Decoder*>(decoder); }

ImageSpec output_spec(const std::string& format, const ImageLayout& shape) {
    ImageSpec spec(shape.width, shape.height, shape.channels,
                   shape.floats ? TypeDesc::FLOAT : TypeDesc::UINT8);
    spec["oiio:UnassociatedAlpha"] = 1;
    spec["oiio:ColorSpace"] = shape.floats ? "Linear" : "sRGB";
    spec["Software"] = std::string("Sightline ") + program_version;
    if (format == "webp") {
        spec["Compression"] = "webp:95";
    } else if (format == "tiff") {
        spec["Compression"] = "zip";
        spec["DateTime"] =
            "";  // otherwise the current time: equal images would give different files
    }
    return spec;
}

void write_pixels(ImageOutput& output, const std::string& path, const ImageSpec& spec,
                  const void* pixels) {
    if (!output.open(path, spec) || !output.write_image(spec.format, pixels) || !output.close())
        throw std::runtime_error(first_line(output.geterror()));
}

bool encode(const char* format, const ImageLayout* shape, const void* pixels,
            void (*take)(void* context, const void* bytes, size_t size), void* context,
            ModuleMessage* message) {
    return guarded(message, [&] {
        const auto output = ImageOutput::create(format);
        if (!output) throw std::runtime_error(first_line(OIIO::geterror()));
        const ImageSpec spec = output_spec(format, *shape);
        // Encode in memory, because not every writer reports a full disk.
        std::vector<unsigned char> bytes;
        // With a proxy, the TIFF writer of OpenImageIO 2.4 produces unreadable files.
        if (output->supports("ioproxy") && std::strcmp(format, "tiff") != 0) {
            OIIO::Filesystem::IOVecOutput buffer(bytes);
            output->set_ioproxy(&buffer);
            write_pixels(*output, "image", spec, pixels);
        } else {
            const MemoryFile file;
            write_pixels(*output, file.path(), spec, pixels);
            bytes = file.contents();
        }
        take(context, bytes.data(), bytes.size());
    });
}

/// Names that configurations give linear light with Rec. 709 primaries.
constexpr const char* linear_names[] = {"lin_rec709",
                                        "Linear Rec.709 (sRGB)",
                                        "lin_srgb",
                                        "Utility - Linear - sRGB",
                                        "Utility - Linear - Rec.709",
                                        "Linear sRGB",
                                        "Linear Rec.709"};

using Processor = OIIO::ColorProcessorHandle;

std::string joined(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    return list.empty() ? "none" : list;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::string linear_space(const OIIO::ColorConfig& config) {
    const std::vector<std::string> names = config.getColorSpaceNames();
    for (const char* name : linear_names)
        if (contains(names, name)) return name;
    const char* role = config.getColorSpaceNameByRole("scene_linear");
    if (!role)
        throw std::runtime_error(
            "has no colour space for linear light: neither the role "
            "scene_linear nor one named lin_rec709");
    return role;
}

Processor make_view(const std::string& file, std::string display, std::string view) {
    if (!OIIO::ColorConfig::supportsOpenColorIO())
        throw std::runtime_error("this machine's OpenImageIO was built without OpenColorIO");
    OIIO::ColorConfig config(file);
    if (config.has_error()) throw std::runtime_error(first_line(config.geterror()));
    const std::vector<std::string> displays = config.getDisplayNames();
    if (display.empty() && config.getDefaultDisplayName()) display = config.getDefaultDisplayName();
    if (!contains(displays, display))
        throw std::runtime_error("has no display '" + display + "'; it has " + joined(displays));
    const std::vector<std::string> views = config.getViewNames(display);
    if (view.empty() && config.getDefaultViewName(display))
        view = config.getDefaultViewName(display);
    if (!contains(views, view))
        throw std::runtime_error("the display '" + display + "' has no view '" + view +
                                 "'; it has " + joined(views));
    Processor processor = config.createDisplayTransform(display, view, linear_space(config));
    if (!processor) throw std::runtime_error(first_line(config.geterror()));
    return processor;
}

void* open_view(const char* config, const char* display, const char* view, ModuleMessage* message) {
    auto processor = std::make_unique<Processor>();
    const bool opened = guarded(message, [&] { *processor = make_view(config, display, view); });
    return opened ? processor.release() : nullptr;
}

void apply_view(const void* processor, float* rgb) {
    (*static_cast<const Processor*>(processor))
        ->apply(rgb, 1, 1, 3, sizeof(float), 3 * sizeof(float), 3 * sizeof(float));
}

void close_view(void* processor) { delete static_cast<Processor*>(processor); }

}  // namespace
}  // namespace sightline

extern "C" const sightline::ImageModule* sightline_image_module() {
    using namespace sightline;
    // Callers decode many images at once, so each gets one thread. OpenEXR gets no thread pool:
    // a static destructor would join its threads, which can hang at exit.
    static const bool configured = OIIO::attribute("threads", 1) &&
                                   OIIO::attribute("exr_threads", -1) &&
                                   OIIO::attribute("openexr:core", 0);
    static const ImageModule module{supports, open,      read,       close,
                                    encode,   open_view, apply_view, close_view};
    static_cast<void>(configured);
    return &module;
}
