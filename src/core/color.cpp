#include "core/color.h"

#include "core/error.h"
#include "core/srgb.h"
#include "core/suggest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <vector>

namespace sightline {
namespace {

struct NamedColor {
    const char* name;
    uint32_t code;  // RRGGBB
};

constexpr NamedColor named_colors[] = {
    {"white", 0xFFFFFF},     {"black", 0x000000},    {"gray", 0x808080},
    {"grey", 0x808080},      {"silver", 0xC0C0C0},   {"lightgray", 0xD3D3D3},
    {"lightgrey", 0xD3D3D3}, {"darkgray", 0xA9A9A9}, {"darkgrey", 0xA9A9A9},
    {"red", 0xFF0000},       {"maroon", 0x800000},   {"orange", 0xFFA500},
    {"yellow", 0xFFFF00},    {"olive", 0x808000},    {"lime", 0x00FF00},
    {"green", 0x008000},     {"cyan", 0x00FFFF},     {"aqua", 0x00FFFF},
    {"teal", 0x008080},      {"blue", 0x0000FF},     {"navy", 0x000080},
    {"magenta", 0xFF00FF},   {"fuchsia", 0xFF00FF},  {"purple", 0x800080},
    {"pink", 0xFFC0CB},      {"brown", 0xA52A2A},    {"beige", 0xF5F5DC},
    {"ivory", 0xFFFFF0},
};

Vec3 decode(uint32_t code) {
    const auto channel = [&](int shift) {
        return decode_srgb(static_cast<float>((code >> shift) & 255) / 255);
    };
    return {channel(16), channel(8), channel(0)};
}

std::optional<Vec3> parse_hexadecimal(const std::string& text) {
    const std::string digits = text.substr(1);
    if (digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
        return std::nullopt;
    std::string code = digits;
    if (digits.size() == 3)
        code = {digits[0], digits[0], digits[1], digits[1], digits[2], digits[2]};
    if (code.size() != 6) return std::nullopt;
    return decode(static_cast<uint32_t>(std::stoul(code, nullptr, 16)));
}

std::optional<Vec3> parse_numbers(const std::string& text) {
    Vec3 c(0, 0, 0);
    char rest = 0;
    if (std::sscanf(text.c_str(), "%f,%f,%f%c", &c.x, &c.y, &c.z, &rest) != 3) return std::nullopt;
    if (!is_finite(c)) return std::nullopt;
    if (std::min({c.x, c.y, c.z}) < 0 || max_component(c) > 1)
        throw Error(
            fmt::format("'{}' has numbers outside 0 to 1: they are linear light; code "
                        "values are written as in #FFCC00, and white is 1,1,1 or white",
                        text));
    return c;
}

}  // namespace

Vec3 parse_color(const std::string& text) {
    for (const NamedColor& color : named_colors)
        if (text == color.name) return decode(color.code);
    const std::optional<Vec3> color =
        text.starts_with('#') ? parse_hexadecimal(text) : parse_numbers(text);
    if (color) return *color;
    std::vector<std::string> names;
    for (const NamedColor& named : named_colors) names.emplace_back(named.name);
    throw Error(
        fmt::format("'{}' is not a colour: a name such as white, #RRGGBB, or three linear "
                    "numbers R,G,B from 0 to 1{}",
                    text, did_you_mean(text, names)));
}

}  // namespace sightline
