#include "image/hdr_orientation.h"

#include <algorithm>
#include <string_view>

namespace sightline {
namespace {

bool is_axis(std::string_view text) {
    return text.size() >= 2 && (text[0] == '+' || text[0] == '-') &&
           (text[1] == 'X' || text[1] == 'Y');
}

void replace(std::vector<std::byte>& file, size_t at, std::string_view text) {
    std::ranges::transform(text, file.begin() + static_cast<ptrdiff_t>(at),
                           [](char c) { return static_cast<std::byte>(c); });
}

}  // namespace

std::optional<HdrOrientation> hdr_orientation(std::span<const std::byte> file) {
    const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
    HdrOrientation result;
    result.at = text.find("\n\n");
    if (result.at == std::string_view::npos) return std::nullopt;
    result.at += 2;
    const std::string_view line = text.substr(result.at, text.substr(result.at, 64).find('\n'));
    const size_t second = line.find_first_of("+-", 1);
    if (second == std::string_view::npos) return std::nullopt;
    const std::string_view first_axis = line.substr(0, 2), second_axis = line.substr(second, 2);
    if (!is_axis(first_axis) || !is_axis(second_axis) || first_axis[1] == second_axis[1])
        return std::nullopt;
    result.second_axis = result.at + second;
    result.by_columns = first_axis[1] == 'X';
    const std::string_view x = result.by_columns ? first_axis : second_axis;
    const std::string_view y = result.by_columns ? second_axis : first_axis;
    result.from_right = x[0] == '-';
    result.from_bottom = y[0] == '+';  // y grows upwards
    return result;
}

std::vector<std::byte> as_upright_hdr(std::span<const std::byte> file,
                                      const HdrOrientation& orientation) {
    std::vector<std::byte> result(file.begin(), file.end());
    replace(result, orientation.at, "-Y");
    replace(result, orientation.second_axis, "+X");
    return result;
}

Image upright(const Image& scanlines, const HdrOrientation& orientation) {
    Image result = scanlines;
    if (orientation.by_columns) std::swap(result.width, result.height);
    const auto channels = static_cast<size_t>(result.channels);
    const auto width = static_cast<size_t>(result.width);
    const auto height = static_cast<size_t>(result.height);
    for (size_t y = 0; y < height; ++y) {
        for (size_t x = 0; x < width; ++x) {
            const size_t column = orientation.from_right ? width - 1 - x : x;
            const size_t row = orientation.from_bottom ? height - 1 - y : y;
            const size_t from =
                orientation.by_columns ? column * height + row : row * width + column;
            std::copy_n(&scanlines.floats[from * channels], channels,
                        &result.floats[(y * width + x) * channels]);
        }
    }
    return result;
}

}  // namespace sightline
