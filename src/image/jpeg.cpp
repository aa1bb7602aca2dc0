#include "image/jpeg.h"

#include "core/error.h"
#include "image/halving.h"
#include "image/sniff.h"

#include <fmt/format.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <new>
// libjpeg's headers need <cstdio> before them.
#include <jerror.h>
#include <jpeglib.h>

namespace sightline {
namespace {

/// libjpeg's decoder. Its errors are jumps, so the functions that it runs in have no destructors.
class Decoder {
  public:
    Decoder() {
        info_.err = jpeg_std_error(&errors_);
        info_.client_data = this;
        errors_.error_exit = on_error;
        errors_.emit_message = on_message;
    }
    ~Decoder() { jpeg_destroy_decompress(&info_); }
    Decoder(const Decoder&) = delete;

    /// Each returns false on damage, which `reason` then describes.
    bool read_header(std::span<const std::byte> file) {
        if (setjmp(jump_) != 0) return false;
        jpeg_create_decompress(&info_);
        jpeg_mem_src(&info_, reinterpret_cast<const unsigned char*>(file.data()), file.size());
        jpeg_read_header(&info_, TRUE);
        is_cmyk = info_.jpeg_color_space == JCS_CMYK || info_.jpeg_color_space == JCS_YCCK;
        if (is_cmyk) info_.out_color_space = JCS_CMYK;
        jpeg_calc_output_dimensions(&info_);
        return true;
    }

    /// Starts with the coefficients: all scans of a progressive file. The pixels are decoded at
    /// 1/2^shrink of the size, by a transform of fewer coefficients.
    bool start(int shrink) {
        if (setjmp(jump_) != 0) return false;
        info_.scale_num = 1;
        info_.scale_denom = 1u << shrink;
        jpeg_start_decompress(&info_);
        return true;
    }

    bool read_row(uint8_t* row) {
        if (setjmp(jump_) != 0) return false;
        return jpeg_read_scanlines(&info_, &row, 1) == 1;
    }

    int width() const { return static_cast<int>(info_.output_width); }
    int height() const { return static_cast<int>(info_.output_height); }
    int channels() const { return info_.output_components; }

    /// Whether each bit of each coefficient was in the scans that have been read. Of a sequential
    /// file in several scans it is not known.
    bool has_all_scans() {
        if (!info_.progressive_mode) return jpeg_has_multiple_scans(&info_) == 0;
        for (int c = 0; c < info_.num_components; ++c)
            if (!std::all_of(info_.coef_bits[c], info_.coef_bits[c] + DCTSIZE2,
                             [](int missing_bits) { return missing_bits == 0; }))
                return false;
        return true;
    }

    bool is_out_of_memory() const { return errors_.msg_code == JERR_OUT_OF_MEMORY; }

    std::string reason() const {
        switch (errors_.msg_code) {
            case JERR_BAD_PRECISION:
                return fmt::format("{} bits in a channel instead of 8", info_.data_precision);
            case JERR_SOF_UNSUPPORTED:
                return "a lossless or hierarchical JPEG cannot be decoded";
            case JERR_NO_IMAGE:
                return "damaged JPEG: no pixels";
            default:
                return "damaged JPEG: its pixels are damaged or cut off";
        }
    }

    bool is_cmyk = false;
    bool has_end = true;

  private:
    static Decoder& of(j_common_ptr info) { return *static_cast<Decoder*>(info->client_data); }

    [[noreturn]] static void on_error(j_common_ptr info) { std::longjmp(of(info).jump_, 1); }

    /// A negative level is a warning of damaged data; the decoder puts an end behind the last byte.
    static void on_message(j_common_ptr info, int level) {
        if (level >= 0) return;
        if (info->err->msg_code != JWRN_JPEG_EOF) on_error(info);
        of(info).has_end = false;
    }

    jpeg_decompress_struct info_{};
    jpeg_error_mgr errors_{};
    std::jmp_buf jump_{};
};

/// Adobe stores 255 minus the inks, so that colours are products.
void cmyk_to_rgb(const std::vector<uint8_t>& cmyk, uint8_t* rgb) {
    for (size_t i = 0; i < cmyk.size(); i += 4)
        for (size_t c = 0; c < 3; ++c)
            *rgb++ = static_cast<uint8_t>((cmyk[i + c] * cmyk[i + 3] + 127) / 255);
}

/// libjpeg's encoder. Its errors are jumps, so the functions that it runs in have no destructors.
class Encoder {
  public:
    Encoder() {
        info_.err = jpeg_std_error(&errors_);
        info_.client_data = this;
        errors_.error_exit = on_error;
    }
    ~Encoder() {
        jpeg_destroy_compress(&info_);
        std::free(bytes);
    }
    Encoder(const Encoder&) = delete;

    /// Returns false if memory is short, the only error that there can be.
    bool write(const Image& image) {
        if (setjmp(jump_) != 0) {
            bytes = nullptr;  // libjpeg may have freed what it points to
            return false;
        }
        jpeg_create_compress(&info_);
        jpeg_mem_dest(&info_, &bytes, &size);
        info_.image_width = static_cast<JDIMENSION>(image.width);
        info_.image_height = static_cast<JDIMENSION>(image.height);
        info_.input_components = image.channels;
        info_.in_color_space = image.channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
        jpeg_set_defaults(&info_);
        jpeg_set_quality(&info_, 95, TRUE);
        for (int c = 0; c < info_.num_components; ++c)  // colours at full resolution
            info_.comp_info[c].h_samp_factor = info_.comp_info[c].v_samp_factor = 1;
        jpeg_start_compress(&info_, TRUE);
        const size_t row_bytes =
            static_cast<size_t>(image.width) * static_cast<size_t>(image.channels);
        for (size_t y = 0; y < static_cast<size_t>(image.height); ++y) {
            auto* row = const_cast<JSAMPROW>(&image.bytes[y * row_bytes]);
            jpeg_write_scanlines(&info_, &row, 1);
        }
        jpeg_finish_compress(&info_);
        return true;
    }

    unsigned char* bytes = nullptr;
    unsigned long size = 0;

  private:
    [[noreturn]] static void on_error(j_common_ptr info) {
        std::longjmp(static_cast<Encoder*>(info->client_data)->jump_, 1);
    }

    jpeg_compress_struct info_{};
    jpeg_error_mgr errors_{};
    std::jmp_buf jump_{};
};

}  // namespace

std::vector<std::byte> encode_jpeg(const Image& image, const std::string& name) {
    if (image.width > JPEG_MAX_DIMENSION || image.height > JPEG_MAX_DIMENSION) {
        throw Error(fmt::format("{}: {} x {} pixels, but a JPEG has at most {} a side", name,
                                image.width, image.height, JPEG_MAX_DIMENSION));
    }
    Encoder encoder;
    if (!encoder.write(image)) throw std::bad_alloc();
    const auto* begin = reinterpret_cast<const std::byte*>(encoder.bytes);
    return {begin, begin + encoder.size};
}

Image decode_jpeg(std::span<const std::byte> file, const std::string& name,
                  const ImageLimits& limits, const WantedLevel& wanted) {
    Decoder decoder;
    const auto check = [&](bool succeeded) {
        if (!succeeded && decoder.is_out_of_memory()) throw std::bad_alloc();
        if (!succeeded) throw Error(fmt::format("{}: {}", name, decoder.reason()));
    };
    check(decoder.read_header(file));
    check_image_size(static_cast<uint64_t>(decoder.width()),
                     static_cast<uint64_t>(decoder.height()), limits.max_pixels, name);
    if (decoder.channels() > 4)
        throw Error(fmt::format("{}: a JPEG of {} channels", name, decoder.channels()));
    const int level = exact_level(decoder.width(), decoder.height(), wanted.level);
    // The transform's means are of code values. Two levels of those of colours are made here, in
    // linear light: with one, fine print on a sign came out visibly darker.
    constexpr int largest_shrink = 3;
    // Of inks there are none: colours are products of two.
    const int finer = decoder.is_cmyk ? level : wanted.srgb ? 2 : 1;
    const int shrink = std::clamp(level - finer, 0, largest_shrink);
    check(decoder.start(shrink));
    Image image;
    image.width = decoder.width();
    image.height = decoder.height();
    image.channels = decoder.is_cmyk ? 3 : decoder.channels();
    image.level = shrink;
    const int height = image.height;
    std::vector<uint8_t> cmyk(decoder.is_cmyk ? static_cast<size_t>(image.width) * 4 : 0);
    RowHalver rows(image, level - shrink, wanted.srgb);
    for (int y = 0; y < height; ++y) {
        check(decoder.read_row(decoder.is_cmyk ? cmyk.data() : rows.row()));
        if (decoder.is_cmyk) cmyk_to_rgb(cmyk, rows.row());
        rows.finish_row();
    }
    if (!decoder.has_end && !decoder.has_all_scans())
        throw Error(name + ": damaged JPEG: truncated between its scans");
    if (!decoder.has_end) {
        image.damage = ImageDamage::jpeg_end;
        image.damage_place = "no end marker";
    }
    return image;
}

}  // namespace sightline
