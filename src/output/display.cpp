#include "output/display.h"

#include "core/srgb.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sightline {
namespace {

/// The product of the matrix m and the colour.
Vec3 mix_channels(const float (&m)[3][3], const Vec3& c) {
    return {m[0][0] * c.x + m[0][1] * c.y + m[0][2] * c.z,
            m[1][0] * c.x + m[1][1] * c.y + m[1][2] * c.z,
            m[2][0] * c.x + m[2][1] * c.y + m[2][2] * c.z};
}

template <class Function>
Vec3 per_channel(const Vec3& c, const Function& f) {
    return {f(c.x), f(c.y), f(c.z)};
}

Vec3 clamp_unit(const Vec3& c) {
    return per_channel(c, [](float x) { return std::clamp(x, 0.0f, 1.0f); });
}

/// Khronos PBR Neutral Tone Mapper, specification 1.0 (2024): base colours up to 0.8 keep their
/// value less Fresnel's 0.04; brighter colours are compressed and desaturated.
Vec3 pbr_neutral(Vec3 color) {
    constexpr float fresnel = 0.04f, start = 0.8f - fresnel, desaturation = 0.15f;
    const float darkest = std::min({color.x, color.y, color.z});
    const float offset =
        darkest < 2 * fresnel ? darkest - darkest * darkest / (4 * fresnel) : fresnel;
    color -= Vec3(offset);
    const float peak = max_component(color);
    if (peak < start) return color;
    constexpr float room = 1 - start;
    const float new_peak = 1 - room * room / (peak + room - start);
    color *= new_peak / peak;
    const float white = 1 - 1 / (desaturation * (peak - new_peak) + 1);
    return color * (1 - white) + Vec3(new_peak * white);
}

/// Stephen Hill's fit of the ACES reference rendering and sRGB output transforms (2016): into the
/// rendering primaries with its desaturation, a rational curve, and back to Rec. 709. No exposure
/// factor is added.
Vec3 aces(const Vec3& color) {
    constexpr float in[3][3] = {{0.59719f, 0.35458f, 0.04823f},
                                {0.07600f, 0.90834f, 0.01566f},
                                {0.02840f, 0.13383f, 0.83777f}};
    constexpr float out[3][3] = {{1.60475f, -0.53108f, -0.07367f},
                                 {-0.10208f, 1.10813f, -0.00605f},
                                 {-0.00327f, -0.07276f, 1.07602f}};
    const auto curve = [](float x) {
        return (x * (x + 0.0245786f) - 0.000090537f) /
               (x * (0.983729f * x + 0.4329510f) + 0.238081f);
    };
    return clamp_unit(mix_channels(out, per_channel(mix_channels(in, color), curve)));
}

/// One half of AgX's sigmoid: a line through the pivot that bends, by `power`, to end at `rise`
/// after `run`.
struct SigmoidHalf {
    static constexpr float slope = 2;
    float run, rise, power;
    float scale = slope * run / std::pow(std::pow(slope * run / rise, power) - 1, 1 / power);

    float operator()(float distance) const {
        const float straight = slope * distance;
        return straight / std::pow(1 + std::pow(straight / scale, power), 1 / power);
    }
};

/// AgX's sigmoid over encoded stops; middle grey is its pivot.
float agx_curve(float x) {
    constexpr float pivot_x = 10 / 16.5f, pivot_y = 0.5f;
    static const SigmoidHalf toe{pivot_x, pivot_y, 3}, shoulder{1 - pivot_x, 1 - pivot_y, 3.25f};
    return x > pivot_x ? pivot_y + shoulder(x - pivot_x) : pivot_y - toe(pivot_x - x);
}

/// AgX by Troy Sobotka, base look, with the Rec. 2020 primaries that Blender's configuration uses:
/// the primaries are moved inwards, 16.5 stops around middle grey pass through the sigmoid, and
/// the primaries are moved outwards again.
Vec3 agx(const Vec3& color) {
    constexpr float to_2020[3][3] = {
        {0.6274f, 0.3293f, 0.0433f}, {0.0691f, 0.9195f, 0.0113f}, {0.0164f, 0.0880f, 0.8956f}};
    constexpr float to_709[3][3] = {{1.6605f, -0.5876f, -0.0728f},
                                    {-0.1246f, 1.1329f, -0.0083f},
                                    {-0.0182f, -0.1006f, 1.1187f}};
    constexpr float inset[3][3] = {{0.856627153f, 0.095121241f, 0.048251606f},
                                   {0.137318973f, 0.761241991f, 0.101439036f},
                                   {0.111898213f, 0.076799419f, 0.811302368f}};
    constexpr float outset[3][3] = {{1.127100582f, -0.110606643f, -0.016493939f},
                                    {-0.141329763f, 1.157823702f, -0.016493939f},
                                    {-0.141329763f, -0.110606643f, 1.251936407f}};
    const auto tone = [](float x) {
        constexpr float middle_grey = 0.18f, below = 10, above = 6.5f;
        const float stops = std::log2(std::max(x, 1e-10f) / middle_grey);
        return agx_curve(std::clamp((stops + below) / (below + above), 0.0f, 1.0f));
    };
    const Vec3 toned = per_channel(mix_channels(inset, mix_channels(to_2020, color)), tone);
    // The curve's result is encoded for a display of power 2.2.
    const Vec3 linear = per_channel(mix_channels(outset, toned),
                                    [](float x) { return std::pow(std::max(x, 0.0f), 2.2f); });
    return clamp_unit(mix_channels(to_709, linear));
}

/// Replaces NaN and negative values by 0, and limits infinity.
Vec3 sanitize_radiance(const Vec3& color) {
    return per_channel(color, [](float x) { return x > 0 ? std::min(x, 1e9f) : 0.0f; });
}

uint8_t to_byte(float unit) {
    return static_cast<uint8_t>(std::clamp(unit, 0.0f, 1.0f) * 255 + 0.5f);
}

/// The beauty layer: red, green, blue and alpha, and what is shown as it is, which may be nullptr.
struct Beauty {
    const Channel* color[3];
    const Channel* alpha;
    const Channel* shown[3];
    const Channel* shown_share;
    const Channel* through[3];
    const Channel* through_share;

    explicit Beauty(const Film& film)
        : color{film.find("R"), film.find("G"), film.find("B")},
          alpha(film.find("A")),
          shown{film.find("shown.R"), film.find("shown.G"), film.find("shown.B")},
          shown_share(film.find("shown.share")),
          through{film.find("through.R"), film.find("through.G"), film.find("through.B")},
          through_share(film.find("through.share")) {
        assert(color[0] && color[1] && color[2]);
    }

    Vec3 at(size_t i, float scale) const {
        return Vec3(color[0]->values[i], color[1]->values[i], color[2]->values[i]) * scale;
    }

    static constexpr float rounding = 1e-5f;  ///< of a share

    /// The colour for a display, unpremultiplied by the coverage `a`. The rest of the pixel is tone
    /// mapped as if it filled the pixel, so that the edge between both is antialiased.
    Vec3 display_color(size_t i, const DisplayTransform& map, float scale, float a) const {
        if (!shown_share || !(shown_share->values[i] > 0)) return map(at(i, a > 0 ? scale / a : 0));
        const Vec3 as_is(shown[0]->values[i], shown[1]->values[i], shown[2]->values[i]);
        const float lit = a - shown_share->values[i];
        Vec3 sum = as_is;
        if (lit > rounding) sum += map((at(i, 1) - as_is) * (scale / lit)) * lit;
        return a > 0 ? sum / a : Vec3(0, 0, 0);
    }

    /// The colour for a display of the pixel with a background of this colour.
    Vec3 display_color_before(size_t i, const DisplayTransform& map, float scale,
                              const Vec3& background) const {
        Vec3 as_is = value(through, i) * background;
        float share = through_share->values[i];
        Vec3 lit = value(color, i);
        if (shown_share) {
            as_is += value(shown, i);
            share += shown_share->values[i];
            lit -= value(shown, i);
        }
        const float lit_share = 1 - share;
        return lit_share > rounding ? as_is + map(lit * (scale / lit_share)) * lit_share : as_is;
    }

  private:
    static Vec3 value(const Channel* const (&channels)[3], size_t i) {
        return {channels[0]->values[i], channels[1]->values[i], channels[2]->values[i]};
    }
};

Vec3 code_values(const Vec3& color) {
    return per_channel(color, [](float x) { return std::clamp(encode_srgb(x), 0.0f, 1.0f); });
}

/// Code values and alpha of the pixel that is `over` when it is laid over the backdrop, and nearly
/// `over_black` over black. All are code values.
Vec4 fit_alpha(const Vec3& over, const Vec3& over_black, const Vec3& backdrop) {
    const Vec3 gained = over - over_black;
    const float sum = backdrop.x + backdrop.y + backdrop.z;
    float alpha = sum > 0 ? 1 - (gained.x + gained.y + gained.z) / sum : 1;
    for (int c = 0; c < 3; ++c) {  // so that a colour between black and white does it
        if (backdrop[c] > 0) alpha = std::max(alpha, 1 - over[c] / backdrop[c]);
        if (backdrop[c] < 1) alpha = std::max(alpha, (over[c] - backdrop[c]) / (1 - backdrop[c]));
    }
    // In whole steps of 1/255, so that the colour is that of the alpha that is written.
    alpha = std::round(std::clamp(alpha, 0.0f, 1.0f) * 255) / 255;
    if (!(alpha > 0)) return {0, 0, 0, 0};
    const Vec3 color = clamp_unit((over - backdrop * (1 - alpha)) * (1 / alpha));
    return {color.x, color.y, color.z, alpha};
}

Image empty_picture(const Film& film, int channels) {
    Image image;
    image.width = film.window.width();
    image.height = film.window.height();
    image.channels = channels;
    return image;
}

size_t pixel_count(const Image& image) {
    return static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
}

}  // namespace

Vec3 tone_map(ToneMap map, const Vec3& color) {
    switch (map) {
        case ToneMap::linear:
            return color;
        case ToneMap::pbr_neutral:
            return pbr_neutral(sanitize_radiance(color));
        case ToneMap::aces:
            return aces(sanitize_radiance(color));
        case ToneMap::agx:
            return agx(sanitize_radiance(color));
    }
    return color;
}

Vec3 DisplayTransform::operator()(const Vec3& color) const {
    if (!view) return tone_map(map, color);
    return per_channel(view->code_values(sanitize_radiance(color)),
                       [](float code) { return decode_srgb(std::clamp(code, 0.0f, 1.0f)); });
}

Image display_picture(const Film& film, const DisplayTransform& map, float exposure, bool alpha,
                      const Vec3& backdrop) {
    const Beauty beauty(film);
    const bool keep_alpha = alpha && beauty.alpha;
    const bool fit = keep_alpha && beauty.through_share;
    const Vec3 backdrop_code = code_values(backdrop);
    Image image = empty_picture(film, keep_alpha ? 4 : 3);
    const size_t pixels = pixel_count(image);
    image.bytes.reserve(pixels * static_cast<size_t>(image.channels));
    const float scale = std::exp2(exposure);
    for (size_t i = 0; i < pixels; ++i) {
        if (fit) {
            const auto before = [&](const Vec3& color) {
                return code_values(beauty.display_color_before(i, map, scale, color));
            };
            const Vec4 fitted = fit_alpha(before(backdrop), before(Vec3(0)), backdrop_code);
            for (const float c : {fitted.x, fitted.y, fitted.z, fitted.w})
                image.bytes.push_back(to_byte(c));
            continue;
        }
        const float a = keep_alpha ? std::clamp(beauty.alpha->values[i], 0.0f, 1.0f) : 1;
        const Vec3 color = beauty.display_color(i, map, scale, a);
        for (const float c : {color.x, color.y, color.z}) {
            image.bytes.push_back(to_byte(encode_srgb(c)));
        }
        if (keep_alpha) image.bytes.push_back(to_byte(a));
    }
    return image;
}

Image linear_picture(const Film& film, float exposure) {
    const Beauty beauty(film);
    Image image = empty_picture(film, 3);
    const size_t pixels = pixel_count(image);
    image.floats.reserve(pixels * 3);
    const float scale = std::exp2(exposure);
    for (size_t i = 0; i < pixels; ++i) {
        const Vec3 color = beauty.at(i, scale);
        image.floats.insert(image.floats.end(), {color.x, color.y, color.z});
    }
    return image;
}

}  // namespace sightline
