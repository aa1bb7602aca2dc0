// The only file that includes OpenEXR.
#include "output/exr.h"

#include "core/error.h"
#include "core/files.h"
#include "output/exr_stream.h"
#include "render/aov.h"

#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledOutputPart.h>
#include <ImfVecAttribute.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

namespace sightline {
namespace {

using Imath::Box2i;
using Type = Channel::Type;

constexpr int exr_tile_size = 64;
constexpr const char* origin_name = "sightline:origin";

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

/// A view of values that are stored row by row over `window`.
template <class T>
Imf::Slice slice_of(const T* values, Imf::PixelType type, const PixelRect& window) {
    return Imf::Slice::Make(type, values, to_box(window), sizeof(T),
                            sizeof(T) * static_cast<size_t>(window.width()));
}

/// Rounded to half; finite values stay finite.
std::vector<half> to_half(const std::vector<float>& values) {
    std::vector<half> result;
    result.reserve(values.size());
    for (const float v : values) {
        result.emplace_back(std::isfinite(v) ? std::clamp(v, -65504.0f, 65504.0f) : v);
    }
    return result;
}

Imf::Compression to_compression(const std::string& name) {
    constexpr Imf::Compression values[] = {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION,
                                           Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION,
                                           Imf::PIZ_COMPRESSION};
    const auto at = std::ranges::find(exr_compressions, name) - std::begin(exr_compressions);
    assert(at < std::ssize(exr_compressions));
    return values[at];
}

/// "depth" of "depth.Z"; "beauty" if the name has no layer.
std::string layer_of(const std::string& channel) {
    const size_t dot = channel.rfind('.');
    return dot == std::string::npos ? "beauty" : channel.substr(0, dot);
}

/// One part: a header and its channels by their index in the film.
struct Part {
    Imf::Header header;
    std::vector<size_t> channels;
};

/// `layer`: of this part; empty if one part has all layers.
Imf::Header make_header(const Film& layout, const PictureMetadata& metadata,
                        const ExrOptions& options, const std::string& layer) {
    Imf::Header header(to_box(layout.display), to_box(layout.window));
    header.compression() = to_compression(options.compression);
    header.setType(options.tiled ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
    if (options.tiled) header.setTileDescription({exr_tile_size, exr_tile_size});
    Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709
    Imf::addWorldToCamera(header, metadata.world_to_camera);
    Imf::addWorldToNDC(header, metadata.world_to_ndc);
    if (metadata.origin) header.insert(origin_name, Imf::V3dAttribute(*metadata.origin));
    for (const auto& [name, text] : metadata.strings) {
        const bool elsewhere =
            name.starts_with("cryptomatte/") && !layer.empty() && !layer.starts_with("Crypto");
        if (!elsewhere) header.insert(name, Imf::StringAttribute(text));
    }
    for (const auto& [name, value] : metadata.numbers)
        header.insert(name, Imf::DoubleAttribute(value));
    return header;
}

std::vector<Part> make_parts(const Film& layout, const PictureMetadata& metadata,
                             const ExrOptions& options) {
    std::vector<Part> parts;
    for (size_t c = 0; c < layout.channels.size(); ++c) {
        const Channel& channel = layout.channels[c];
        const std::string layer = layer_of(channel.name);
        if (layer == shown_layer || layer == through_layer) continue;
        const bool begins = options.multipart && (c == 0 || parts.back().header.name() != layer);
        if (parts.empty() || begins) {
            const std::string part = options.multipart ? layer : "";
            parts.push_back({make_header(layout, metadata, options, part), {}});
            if (options.multipart) parts.back().header.setName(layer);
        }
        Part& part = parts.back();
        part.header.channels().insert(channel.name, Imf::Channel(to_pixel_type(channel.type)));
        part.channels.push_back(c);
    }
    return parts;
}

/// Rows of a film as an OpenEXR frame buffer.
class Rows {
  public:
    Rows(const Film& film, const std::vector<size_t>& channels) {
        halves_.reserve(channels.size());
        for (const size_t c : channels) {
            const Channel& channel = film.channels[c];
            const Imf::PixelType type = to_pixel_type(channel.type);
            if (channel.type == Type::uint32) {
                buffer_.insert(channel.name, slice_of(channel.integers.data(), type, film.window));
            } else if (channel.type == Type::float32) {
                buffer_.insert(channel.name, slice_of(channel.values.data(), type, film.window));
            } else {
                halves_.push_back(to_half(channel.values));
                buffer_.insert(channel.name, slice_of(halves_.back().data(), type, film.window));
            }
        }
    }
    const Imf::FrameBuffer& buffer() const { return buffer_; }

  private:
    std::vector<std::vector<half>> halves_;
    Imf::FrameBuffer buffer_;
};

class ExrWriter : public PictureWriter {
  public:
    ExrWriter(const std::string& path, const Film& layout, const PictureMetadata& metadata,
              const ExrOptions& options)
        : path_(path),
          options_(options),
          parts_(make_parts(layout, metadata, options)),
          threads_(options.threads),
          pending_(path),
          stream_(pending_.writable_path(), path),
          window_(layout.window) {
        collected_.display = layout.display;
        for (const Channel& c : layout.channels)
            collected_.channels.push_back({c.name, c.type, {}, {}});
        guarded([&] {
            std::vector<Imf::Header> headers;
            for (const Part& part : parts_) headers.push_back(part.header);
            file_.emplace(stream_, headers.data(), static_cast<int>(headers.size()));
        });
    }

    void add(const Film& band) override {
        guarded([&] { options_.tiled || options_.multipart ? collect(band) : write_rows(band); });
    }

    void finish(const PictureMetadata& metadata, const std::string& path) override {
        guarded([&] {
            std::vector<Imf::Header> headers;
            for (int i = 0; i < file_->parts(); ++i) headers.push_back(file_->header(i));
            file_.reset();
            rewrite_headers(headers, metadata);
            stream_.finish();
            pending_.commit(path);
        });
    }

  private:
    template <class Action>
    void guarded(const Action& action) {
        try {
            action();
        } catch (const Error&) {
            throw;
        } catch (const std::exception& error) {
            throw Error(fmt::format("{}: cannot write: {}", path_, error.what()));
        }
    }

    // Collects rows until they fill a row of tiles, which begins at the window's top. The same for
    // parts, whose order in the file must not depend on the bands.
    void collect(const Film& band) {
        PixelRect& have = collected_.window;
        for (int y = band.window.y0; y < band.window.y1; ++y) {
            if (have.height() == 0) have = {band.window.x0, y, band.window.x1, y};
            append_row(collected_, band, y);
            if (have.height() < exr_tile_size && have.y1 < window_.y1) continue;
            write_rows(collected_);
            have = {};
            for (Channel& c : collected_.channels) c.values.clear(), c.integers.clear();
        }
    }

    void write_rows(const Film& film) {
        const int row = (film.window.y0 - window_.y0) / exr_tile_size;
        for (size_t i = 0; i < parts_.size(); ++i) {
            const Rows rows(film, parts_[i].channels);
            if (options_.tiled) {
                Imf::TiledOutputPart part(*file_, static_cast<int>(i));
                part.setFrameBuffer(rows.buffer());
                part.writeTiles(0, part.numXTiles() - 1, row, row);
            } else {
                Imf::OutputPart part(*file_, static_cast<int>(i));
                part.setFrameBuffer(rows.buffer());
                part.writePixels(film.window.height());
            }
        }
    }

    // The headers follow the magic number and the version; numbers do not change their size.
    void rewrite_headers(std::vector<Imf::Header>& headers, const PictureMetadata& metadata) {
        stream_.seekp(8);
        for (Imf::Header& header : headers) {
            for (const auto& [name, value] : metadata.numbers)
                header.typedAttribute<Imf::DoubleAttribute>(name).value() = value;
            header.writeTo(stream_, options_.tiled);
        }
    }

    std::string path_;
    ExrOptions options_;
    std::vector<Part> parts_;
    ScopedExrThreads threads_;
    PendingFile pending_;
    ExrOStream stream_;
    PixelRect window_;
    std::optional<Imf::MultiPartOutputFile> file_;
    Film collected_;  // rows of an incomplete row of tiles
};

void read_pixels(Imf::InputPart& part, std::span<Channel> channels, const PixelRect& window) {
    Imf::FrameBuffer buffer;
    for (Channel& channel : channels) {
        const size_t count = pixel_count(window);
        if (channel.type == Type::uint32) {
            channel.integers.resize(count);
            buffer.insert(channel.name, slice_of(channel.integers.data(), Imf::UINT, window));
        } else {
            channel.values.resize(count);
            buffer.insert(channel.name, slice_of(channel.values.data(), Imf::FLOAT, window));
        }
    }
    part.setFrameBuffer(buffer);
    part.readPixels(window.y0, window.y1 - 1);
}

PictureMetadata read_metadata(const Imf::Header& header) {
    PictureMetadata metadata;
    if (Imf::hasWorldToCamera(header)) metadata.world_to_camera = Imf::worldToCamera(header);
    if (Imf::hasWorldToNDC(header)) metadata.world_to_ndc = Imf::worldToNDC(header);
    for (auto it = header.begin(); it != header.end(); ++it) {
        const std::string name = it.name();
        if (name == "name" || name == "type") continue;  // attributes of a part
        const Imf::Attribute& attribute = it.attribute();
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) {
            metadata.strings[name] = text->value();
        } else if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(&attribute)) {
            metadata.numbers[name] = number->value();
        } else if (const auto* point = dynamic_cast<const Imf::V3dAttribute*>(&attribute)) {
            if (name == origin_name) metadata.origin = point->value();
        }
    }
    return metadata;
}

Film read_film(Imf::MultiPartInputFile& file, const std::string& path) {
    Film film;
    film.display = to_rect(file.header(0).displayWindow());
    film.window = to_rect(file.header(0).dataWindow());
    constexpr size_t max_pixels = size_t{1} << 28;
    if (pixel_count(film.window) > max_pixels) throw Error(path + ": too many pixels");
    for (int i = 0; i < file.parts(); ++i) {
        const Imf::Header& header = file.header(i);
        if (header.dataWindow() != file.header(0).dataWindow())
            throw Error(path + ": its parts have different windows");
        const size_t first = film.channels.size();
        for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
            if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
                throw Error(fmt::format("{}: channel {} is subsampled", path, it.name()));
            }
            Channel& channel = film.channels.emplace_back();
            channel.name = it.name();
            channel.type = from_pixel_type(it.channel().type);
        }
        Imf::InputPart part(file, i);
        read_pixels(part, std::span(film.channels).subspan(first), film.window);
    }
    return film;
}

}  // namespace

std::unique_ptr<PictureWriter> make_exr_writer(const std::string& path, const Film& layout,
                                               const PictureMetadata& metadata,
                                               const ExrOptions& options) {
    return std::make_unique<ExrWriter>(path, layout, metadata, options);
}

void write_exr(const std::string& path, const Film& film, const PictureMetadata& metadata,
               const ExrOptions& options) {
    ExrWriter writer(path, film, metadata, options);
    writer.add(film);
    writer.finish(metadata, path);
}

Film read_exr(const std::string& path, PictureMetadata* metadata) {
    try {
        Imf::MultiPartInputFile file(path.c_str(), 0);
        if (metadata) *metadata = read_metadata(file.header(0));
        return read_film(file, path);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        throw Error(fmt::format("{}: cannot read: {}", path, error.what()));
    }
}

}  // namespace sightline
