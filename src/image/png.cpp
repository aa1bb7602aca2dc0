#include "image/png.h"

#include "core/bytes.h"
#include "core/error.h"
#include "image/halving.h"
#include "image/sniff.h"

#include <fmt/format.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <csetjmp>
#include <cstring>
#include <new>
#include <string_view>

namespace sightline {
namespace {

constexpr size_t signature_size = 8;

/// A chunk of the file, which has all its bytes.
struct Chunk {
    size_t offset;
    std::string type;
    std::span<const std::byte> bytes;  ///< with length, type and checksum
    bool has_right_checksum;

    bool is_ancillary() const { return std::islower(static_cast<unsigned char>(type[0])) != 0; }
    bool makes_pixels() const {
        return type == "IHDR" || type == "PLTE" || type == "tRNS" || type == "IDAT";
    }
};

/// Reads the chunk at `offset`, or says in `fault` why there is none.
std::optional<Chunk> read_chunk(std::span<const std::byte> file, size_t offset,
                                std::string& fault) {
    constexpr size_t frame = 12;
    const size_t left = file.size() - offset;
    if (left < frame) {
        fault = fmt::format("truncated: no end chunk at byte {}", offset);
        return {};
    }
    const uint64_t length = big_endian(file.subspan(offset, 4));
    std::string type(reinterpret_cast<const char*>(&file[offset + 4]), 4);
    if (!std::ranges::all_of(type, [](unsigned char c) { return c < 128 && std::isalpha(c); })) {
        fault = fmt::format("chunk of unknown type at byte {}", offset);
        return {};
    }
    if (length > left - frame) {
        fault = fmt::format("truncated {} chunk at byte {}", type, offset);
        return {};
    }
    const auto bytes = file.subspan(offset, frame + length), checked = bytes.subspan(4, length + 4);
    const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size());
    return Chunk{offset, std::move(type), bytes, sum == big_endian(bytes.last(4))};
}

/// libpng's push reader, which can be stopped at the last pixel: its pull reader inflates all that
/// lies behind. Its errors are jumps, so what it calls has no destructors.
class Reader {
  public:
    Reader()
        : png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning)),
          info_(png_ ? png_create_info_struct(png_) : nullptr) {
        if (!info_) {
            png_destroy_read_struct(&png_, &info_, nullptr);
            throw std::bad_alloc();
        }
        // The checksums have been checked.
        png_set_crc_action(png_, PNG_CRC_QUIET_USE, PNG_CRC_QUIET_USE);
        png_set_progressive_read_fn(png_, this, on_info, on_row, nullptr);
    }
    ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    Reader(const Reader&) = delete;

    /// Decodes the next bytes of the file. Returns false if they are damaged.
    bool feed(std::span<const std::byte> bytes) {
        const bool decoded = process(bytes);
        if (is_out_of_memory_) throw std::bad_alloc();
        return decoded;
    }

    bool has_header() const { return channels > 0; }
    bool is_interlaced() const { return png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE; }
    bool has_all_rows() const {
        if (is_interlaced()) return png_get_current_pass_number(png_) > 6;
        return png_get_current_row_number(png_) >= height;
    }

    // Of the decoded rows; known when the header of the first IDAT chunk has been read.
    uint32_t width = 0, height = 0;
    int channels = 0, bits = 0;
    size_t row_bytes = 0;
    // Where rows go, one of them; set before the first bytes of pixels are fed.
    uint8_t* pixels = nullptr;
    RowHalver* rows = nullptr;  ///< of an image that is not interlaced

  private:
    bool process(std::span<const std::byte> bytes) {
        if (setjmp(png_jmpbuf(png_)) != 0) return false;
        auto* data = const_cast<png_bytep>(reinterpret_cast<const png_byte*>(bytes.data()));
        png_process_data(png_, info_, data, bytes.size());
        return true;
    }

    [[noreturn]] static void on_error(png_structp png, png_const_charp text) {
        // libpng and zlib: "Out of memory", "insufficient memory".
        if (std::strstr(text, " memory")) {
            static_cast<Reader*>(png_get_error_ptr(png))->is_out_of_memory_ = true;
        }
        png_longjmp(png, 1);
    }
    static void on_warning(png_structp, png_const_charp) {}

    static void on_info(png_structp png, png_infop info) {
        auto& reader = *static_cast<Reader*>(png_get_progressive_ptr(png));
        png_set_expand(png);
        if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
        png_set_interlace_handling(png);
        png_read_update_info(png, info);
        reader.width = png_get_image_width(png, info);
        reader.height = png_get_image_height(png, info);
        reader.channels = png_get_channels(png, info);
        reader.bits = png_get_bit_depth(png, info);
        reader.row_bytes = png_get_rowbytes(png, info);
    }

    static void on_row(png_structp png, png_bytep row, png_uint_32 y, int) {
        const auto& reader = *static_cast<Reader*>(png_get_progressive_ptr(png));
        if (reader.rows) {
            std::memcpy(reader.rows->row(), row, reader.row_bytes);
            return reader.rows->finish_row();
        }
        png_progressive_combine_row(png, reader.pixels + y * reader.row_bytes, row);
    }

    png_structp png_;
    png_infop info_;
    bool is_out_of_memory_ = false;
};

/// libpng's writer. Its errors are jumps, so the functions that it runs in have no destructors.
class Writer {
  public:
    Writer()
        : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning)),
          info_(png_ ? png_create_info_struct(png_) : nullptr) {}
    ~Writer() { png_destroy_write_struct(&png_, &info_); }
    Writer(const Writer&) = delete;

    /// Both return false if memory is short, the only error that there can be.
    bool write(const Image& image) {
        if (!info_ || setjmp(png_jmpbuf(png_)) != 0) return false;
        begin(image.width, image.height, image.channels, 8);
        png_set_sRGB(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
        png_write_info(png_, info_);
        const size_t row_bytes = png_get_rowbytes(png_, info_);
        for (int y = 0; y < image.height; ++y)
            png_write_row(png_, &image.bytes[static_cast<size_t>(y) * row_bytes]);
        png_write_end(png_, info_);
        return true;
    }
    bool write(const DataImage& image, std::span<png_text> texts) {
        if (!info_ || setjmp(png_jmpbuf(png_)) != 0) return false;
        begin(image.width, image.height, image.channels, 16);
        png_set_text(png_, info_, texts.data(), static_cast<int>(texts.size()));
        png_write_info(png_, info_);
        if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
        const size_t row = static_cast<size_t>(image.width * image.channels);
        for (int y = 0; y < image.height; ++y)
            png_write_row(png_, reinterpret_cast<png_const_bytep>(
                                    &image.values[static_cast<size_t>(y) * row]));
        png_write_end(png_, info_);
        return true;
    }

    std::vector<std::byte> file;

  private:
    void begin(int width, int height, int channels, int bits) {
        constexpr int color_types[] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                       PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
        png_set_write_fn(png_, this, on_bytes, nullptr);
        png_set_compression_level(png_, 4);  // a third of the time of 6, 5 % larger
        png_set_IHDR(png_, info_, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
                     bits, color_types[channels], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                     PNG_FILTER_TYPE_DEFAULT);
    }

    [[noreturn]] static void on_error(png_structp png, png_const_charp) { png_longjmp(png, 1); }
    static void on_warning(png_structp, png_const_charp) {}

    static bool append(std::vector<std::byte>& file, const png_byte* data, size_t size) {
        try {
            const auto* begin = reinterpret_cast<const std::byte*>(data);
            file.insert(file.end(), begin, begin + size);
            return true;
        } catch (const std::bad_alloc&) {
            return false;
        }
    }
    static void on_bytes(png_structp png, png_bytep data, size_t size) {
        if (!append(static_cast<Writer*>(png_get_io_ptr(png))->file, data, size))
            png_longjmp(png, 1);
    }

    png_structp png_;
    png_infop info_;
};

std::vector<float> to_floats(const std::vector<uint8_t>& words) {
    std::vector<float> floats(words.size() / 2);
    for (size_t i = 0; i < floats.size(); ++i) {
        uint16_t word;
        std::memcpy(&word, &words[2 * i], sizeof word);
        floats[i] = static_cast<float>(word) * (1.0f / 65535.0f);
    }
    return floats;
}

/// Makes room for the pixels, once the reader has the header. Rows that come in order go through
/// `rows`, so that only the wanted level is held.
void allocate(Reader& reader, const std::string& name, const ImageLimits& limits,
              const WantedLevel& wanted, Image& image, std::optional<RowHalver>& rows) {
    check_image_size(reader.width, reader.height, limits.max_pixels, name);
    image.width = static_cast<int>(reader.width);
    image.height = static_cast<int>(reader.height);
    image.channels = reader.channels;
    if (reader.bits == 8 && !reader.is_interlaced()) {
        const int level = exact_level(image.width, image.height, wanted.level);
        reader.rows = &rows.emplace(image, level, wanted.srgb);
        return;
    }
    image.bytes.resize(reader.row_bytes * reader.height);
    reader.pixels = image.bytes.data();
}

/// Decodes the chunks up to the last pixel and returns the offset behind them. Damage
/// that costs no pixel is named in `image`.
size_t decode_chunks(std::span<const std::byte> file, const std::string& name,
                     const ImageLimits& limits, const WantedLevel& wanted, Image& image) {
    const auto fail = [&](const std::string& what) {
        throw Error(fmt::format("{}: damaged PNG: {}", name, what));
    };
    if (file.size() < signature_size) fail("it ends in its signature");
    std::optional<RowHalver> rows;
    Reader reader;
    reader.feed(file.first(signature_size));
    size_t at = signature_size;
    while (!reader.has_header() || !reader.has_all_rows()) {
        std::string fault;
        const std::optional<Chunk> chunk = read_chunk(file, at, fault);
        if (!chunk) fail(fault);
        at += chunk->bytes.size();
        const std::string place = fmt::format("{} chunk at byte {}", chunk->type, chunk->offset);
        if (chunk->type == "IEND") fail("pixels are missing before the " + place);
        if (!chunk->has_right_checksum) {
            if (!chunk->is_ancillary()) fail("wrong checksum of " + place);
            image.damage = ImageDamage::png_checksum;
            image.damage_place = "wrong checksum of " + place;
            continue;
        }
        if (!chunk->makes_pixels()) {
            if (!chunk->is_ancillary()) fail("unknown critical " + place);
            continue;
        }
        constexpr size_t head = 8;
        if (!reader.feed(chunk->bytes.first(head))) fail("misplaced or impossible " + place);
        if (reader.has_header() && !reader.pixels && !rows)
            allocate(reader, name, limits, wanted, image, rows);
        if (!reader.feed(chunk->bytes.subspan(head))) fail("damaged " + place);
    }
    if (reader.bits == 16) {
        image.floats = to_floats(image.bytes);
        image.bytes = {};
    }
    if (!rows) keep_level(image, wanted);
    return at;
}

}  // namespace

Image decode_png(std::span<const std::byte> file, const std::string& name,
                 const ImageLimits& limits, const WantedLevel& wanted) {
    Image image;
    size_t at = decode_chunks(file, name, limits, wanted, image);
    for (std::string type; type != "IEND";) {
        std::string fault;
        const std::optional<Chunk> chunk = read_chunk(file, at, fault);
        if (!chunk) {
            image.damage = ImageDamage::png_end;
            image.damage_place = fault;
            break;
        }
        if (!chunk->has_right_checksum) {
            image.damage = ImageDamage::png_checksum;
            image.damage_place =
                fmt::format("wrong checksum of {} chunk at byte {}", chunk->type, at);
        }
        type = chunk->type;
        at += chunk->bytes.size();
    }
    return image;
}

std::vector<std::byte> encode_png(const Image& image) {
    Writer writer;
    if (!writer.write(image)) throw std::bad_alloc();
    return std::move(writer.file);
}

std::vector<std::byte> encode_png(const DataImage& image) {
    std::vector<png_text> texts;
    for (const auto& [keyword, text] : image.texts) {
        png_text& entry = texts.emplace_back();
        entry.compression = PNG_TEXT_COMPRESSION_NONE;
        entry.key = const_cast<char*>(keyword.c_str());
        entry.text = const_cast<char*>(text.c_str());
        entry.text_length = text.size();
    }
    Writer writer;
    if (!writer.write(image, texts)) throw std::bad_alloc();
    return std::move(writer.file);
}

}  // namespace sightline
