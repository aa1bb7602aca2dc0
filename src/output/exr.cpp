// The only file that knows OpenEXR.
#include "output/exr.h"

#include "core/error.h"
#include "core/files.h"

#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

namespace sightline {
namespace {

using Imath::Box2i;
using Type = Channel::Type;

/// A file that remembers that a write failed: Imf::OutputFile writes its last bytes in its
/// destructor, where it swallows every exception.
class Stream : public Imf::OStream {
  public:
    Stream(const std::string& temporary, const std::string& path)
        : OStream(path.c_str()), path_(path), file_(std::fopen(temporary.c_str(), "wb")) {
        if (!file_) fail();
    }
    ~Stream() override {
        if (file_) std::fclose(file_);
    }

    void write(const char bytes[], int count) override {
        const auto size = static_cast<size_t>(count);
        if (std::fwrite(bytes, 1, size, file_) != size) fail();
        position_ += size;
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t position) override {
        if (fseeko(file_, static_cast<off_t>(position), SEEK_SET) != 0) fail();
        position_ = position;
    }

    /// Throws Error if any write failed, also one whose exception was swallowed.
    void finish() {
        const int closed = std::fclose(std::exchange(file_, nullptr));
        if (error_ == 0 && closed != 0) error_ = errno;
        if (error_ != 0) throw Error(message());
    }

  private:
    [[noreturn]] void fail() {
        if (error_ == 0) error_ = errno;
        throw Error(message());
    }
    std::string message() const {
        return fmt::format("{}: cannot write: {}", path_, std::strerror(error_));
    }

    std::string path_;
    std::FILE* file_;
    uint64_t position_ = 0;
    int error_ = 0;
};

/// OpenEXR's pool of threads for the duration of a write. It is emptied again because a pool that
/// lives until the end of the process can hang there.
struct ThreadPool {
    explicit ThreadPool(unsigned threads) {
        Imf::setGlobalThreadCount(threads > 1 ? static_cast<int>(threads) : 0);
    }
    ~ThreadPool() { Imf::setGlobalThreadCount(0); }
    ThreadPool(const ThreadPool&) = delete;
};

/// EXR's windows include their last pixel.
Box2i to_box(const PixelRect& r) { return {{r.x0, r.y0}, {r.x1 - 1, r.y1 - 1}}; }
PixelRect to_rect(const Box2i& b) { return {b.min.x, b.min.y, b.max.x + 1, b.max.y + 1}; }

size_t pixel_count(const PixelRect& r) {
    return static_cast<size_t>(r.width()) * static_cast<size_t>(r.height());
}

Imf::PixelType to_pixel_type(Type type) {
    switch (type) {
        case Type::half:
            return Imf::HALF;
        case Type::float32:
            return Imf::FLOAT;
        case Type::uint32:
            return Imf::UINT;
    }
    return Imf::FLOAT;
}

Type from_pixel_type(Imf::PixelType type) {
    return type == Imf::HALF ? Type::half : type == Imf::UINT ? Type::uint32 : Type::float32;
}

/// A view of values that lie row by row over `window`.
template <class T>
Imf::Slice slice_of(const T* values, Imf::PixelType type, const PixelRect& window) {
    return Imf::Slice::Make(type, values, to_box(window), sizeof(T),
                            sizeof(T) * static_cast<size_t>(window.width()));
}

/// Rounded to half; what is finite stays finite.
std::vector<half> to_half(const std::vector<float>& values) {
    std::vector<half> result;
    result.reserve(values.size());
    for (const float v : values) {
        result.emplace_back(std::isfinite(v) ? std::clamp(v, -65504.0f, 65504.0f) : v);
    }
    return result;
}

Imf::Header make_header(const Film& film, const PictureInfo& info) {
    Imf::Header header(to_box(film.display), to_box(film.window));
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709
    Imf::addWorldToCamera(header, info.world_to_camera);
    Imf::addWorldToNDC(header, info.world_to_ndc);
    for (const auto& [name, text] : info.strings) {
        header.insert(name, Imf::StringAttribute(text));
    }
    for (const auto& [name, number] : info.numbers) {
        header.insert(name, Imf::FloatAttribute(number));
    }
    for (const Channel& channel : film.channels) {
        header.channels().insert(channel.name, Imf::Channel(to_pixel_type(channel.type)));
    }
    return header;
}

void write_pixels(Imf::OutputFile& file, const Film& film) {
    Imf::FrameBuffer buffer;
    std::vector<std::vector<half>> halves;
    halves.reserve(film.channels.size());
    for (const Channel& channel : film.channels) {
        const Imf::PixelType type = to_pixel_type(channel.type);
        if (channel.type == Type::uint32) {
            buffer.insert(channel.name, slice_of(channel.integers.data(), type, film.window));
        } else if (channel.type == Type::float32) {
            buffer.insert(channel.name, slice_of(channel.values.data(), type, film.window));
        } else {
            halves.push_back(to_half(channel.values));
            buffer.insert(channel.name, slice_of(halves.back().data(), type, film.window));
        }
    }
    file.setFrameBuffer(buffer);
    file.writePixels(film.window.height());
}

void read_pixels(Imf::InputFile& file, Film& film) {
    Imf::FrameBuffer buffer;
    for (Channel& channel : film.channels) {
        const size_t count = pixel_count(film.window);
        if (channel.type == Type::uint32) {
            channel.integers.resize(count);
            buffer.insert(channel.name, slice_of(channel.integers.data(), Imf::UINT, film.window));
        } else {
            channel.values.resize(count);
            buffer.insert(channel.name, slice_of(channel.values.data(), Imf::FLOAT, film.window));
        }
    }
    file.setFrameBuffer(buffer);
    file.readPixels(film.window.y0, film.window.y1 - 1);
}

PictureInfo read_info(const Imf::Header& header) {
    PictureInfo info;
    if (Imf::hasWorldToCamera(header)) info.world_to_camera = Imf::worldToCamera(header);
    if (Imf::hasWorldToNDC(header)) info.world_to_ndc = Imf::worldToNDC(header);
    for (auto it = header.begin(); it != header.end(); ++it) {
        const std::string name = it.name();
        if (name == "pixelAspectRatio" || name == "screenWindowWidth") continue;
        const Imf::Attribute& attribute = it.attribute();
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) {
            info.strings[name] = text->value();
        } else if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) {
            info.numbers[name] = number->value();
        }
    }
    return info;
}

Film read_film(Imf::InputFile& file, const std::string& path) {
    Film film;
    film.display = to_rect(file.header().displayWindow());
    film.window = to_rect(file.header().dataWindow());
    constexpr size_t max_pixels = size_t{1} << 28;
    if (pixel_count(film.window) > max_pixels) throw Error(path + ": too many pixels");
    const Imf::ChannelList& channels = file.header().channels();
    for (auto it = channels.begin(); it != channels.end(); ++it) {
        if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
            throw Error(fmt::format("{}: channel {} is subsampled", path, it.name()));
        }
        Channel& channel = film.channels.emplace_back();
        channel.name = it.name();
        channel.type = from_pixel_type(it.channel().type);
    }
    read_pixels(file, film);
    return film;
}

}  // namespace

void write_exr(const std::string& path, const Film& film, const PictureInfo& info,
               unsigned threads) {
    write_atomically(path, [&](const std::string& temporary) {
        try {
            const ThreadPool pool(threads);
            Stream stream(temporary, path);
            {
                Imf::OutputFile file(stream, make_header(film, info));
                write_pixels(file, film);
            }
            stream.finish();
        } catch (const Error&) {
            throw;
        } catch (const std::exception& error) {
            throw Error(fmt::format("{}: cannot write: {}", path, error.what()));
        }
    });
}

Film read_exr(const std::string& path, PictureInfo* info) {
    try {
        Imf::InputFile file(path.c_str(), 0);
        if (info) *info = read_info(file.header());
        return read_film(file, path);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        throw Error(fmt::format("{}: cannot read: {}", path, error.what()));
    }
}

}  // namespace sightline
