#include "scene/view_names.h"

#include "core/error.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace sightline {
namespace {

constexpr int max_views = 100'000;
constexpr const char* ring_word = "ring:";
constexpr const char* sphere_word = "sphere:";

struct Entry {
    const char* name;
    ViewAngles angles;
};

// The isometric view has equal angles to all three axes.
constexpr Entry entries[] = {
    {"fit", fit_view},
    {"fit-sphere", fit_view},
    {"front", {0, 0}},
    {"back", {180, 0}},
    {"left", {270, 0}},
    {"right", {90, 0}},
    {"top", {0, 90}},
    {"bottom", {0, -90}},
    {"three-quarter", {45, 20}},
    {"three-quarter-left", {315, 20}},
    {"three-quarter-right", {45, 20}},
    {"iso", {45, 35.264389682754654}},
};

struct SineCosine {
    double sine, cosine;
};

// Exact for multiples of 90°, whose radians are not.
SineCosine sine_cosine(double degrees) {
    int quadrant = 0;
    const double rest = std::remquo(degrees, 90, &quadrant) * (M_PI / 180);
    const double s = std::sin(rest), c = std::cos(rest);
    switch (quadrant & 3) {
        case 0:
            return {s, c};
        case 1:
            return {c, -s};
        case 2:
            return {-s, -c};
        default:
            return {-c, s};
    }
}

template <class Number>
std::optional<Number> parse_number(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    if (!std::isfinite(static_cast<double>(value))) return std::nullopt;
    return value;
}

// Empty if the text is not two numbers with a slash between them.
std::optional<ViewAngles> parse_angles(std::string_view text) {
    const size_t slash = text.find('/');
    if (slash == std::string_view::npos) return std::nullopt;
    const auto azimuth = parse_number<double>(text.substr(0, slash));
    const auto elevation = parse_number<double>(text.substr(slash + 1));
    if (!azimuth || !elevation) return std::nullopt;
    return ViewAngles{*azimuth, *elevation};
}

void check_angles(const ViewAngles& angles, const std::string& text) {
    if (text == "3/4")
        throw Error(
            "'3/4' is taken for neither the view three-quarter nor the angles 3.0/4; "
            "write one of these");
    if (std::fabs(angles.azimuth) > 360)
        throw Error(fmt::format("'{}' has an azimuth outside -360 to 360 degrees", text));
    if (std::fabs(angles.elevation) > 90)
        throw Error(fmt::format("'{}' has an elevation outside -90 to 90 degrees", text));
}

// At most two decimals; at least three digits before them where `pad` is set.
std::string short_number(double value, bool pad) {
    std::string text = pad ? fmt::format("{:06.2f}", value) : fmt::format("{:.2f}", value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text == "-0" ? "0" : text;
}

double positive_turn(double degrees) {
    const double rest = std::fmod(degrees, 360);
    return rest < 0 ? rest + 360 : rest;
}

NamedView view_at(const ViewAngles& angles) {
    const double azimuth = positive_turn(std::round(angles.azimuth * 100) / 100);
    return {fmt::format("az{}_el{}", short_number(azimuth, true),
                        short_number(angles.elevation, false)),
            fmt::format("{}/{}", positive_turn(angles.azimuth), angles.elevation)};
}

std::vector<NamedView> ring_views(const std::string& element) {
    const Ring ring = parse_ring(element.substr(std::string_view(ring_word).size()), ring_word);
    const ViewAngles start = ring.start.value_or(ViewAngles());
    std::vector<NamedView> views;
    for (int i = 0; i < ring.count; ++i)
        views.push_back(view_at({start.azimuth + 360.0 * i / ring.count, start.elevation}));
    return views;
}

std::vector<NamedView> sphere_views(const std::string& element) {
    const std::string number = element.substr(std::string_view(sphere_word).size());
    const int count = parse_number<int>(number).value_or(0);
    if (count < 1 || count > max_views)
        throw Error(fmt::format("'{}' is not a sphere of 1 to {} views such as sphere:12", element,
                                max_views));
    const double golden_angle = 180 * (3 - std::sqrt(5.0));
    const size_t digits = fmt::format("{}", count).size();
    std::vector<NamedView> views;
    for (int i = 0; i < count; ++i) {
        const double height = 1 - (2.0 * i + 1) / count;
        const ViewAngles angles{std::fmod(golden_angle * i, 360), std::asin(height) * (180 / M_PI)};
        views.push_back({fmt::format("sphere{}_{:0{}}", count, i + 1, digits),
                         fmt::format("{}/{}", angles.azimuth, angles.elevation)});
    }
    return views;
}

}  // namespace

Mat4 view_rotation(const ViewAngles& angles) {
    const auto [sin_a, cos_a] = sine_cosine(angles.azimuth);
    const auto [sin_e, cos_e] = sine_cosine(angles.elevation);
    const Vec3d rows[3] = {{cos_a, 0, -sin_a},
                           {-sin_a * sin_e, cos_e, -cos_a * sin_e},
                           {sin_a * cos_e, sin_e, cos_a * cos_e}};
    Mat4 rotation;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) rotation[r][c] = static_cast<float>(rows[r][c]);
    return rotation;
}

std::span<const std::string> view_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> result;
        for (const Entry& entry : entries) result.emplace_back(entry.name);
        return result;
    }();
    return names;
}

std::string describe_views() {
    return fmt::format("{}, AZIMUTH/ELEVATION such as 30/20", fmt::join(view_names(), ", "));
}

std::optional<ViewAngles> find_view(const std::string& view) {
    for (const Entry& entry : entries)
        if (view == entry.name) return entry.angles;
    if (view.starts_with(ring_word) || view.starts_with(sphere_word))
        throw Error(fmt::format("'{}' stands for several views, which only --views takes", view));
    const auto angles = parse_angles(view);
    if (angles) check_angles(*angles, view);
    return angles;
}

std::vector<NamedView> expand_view(const std::string& element) {
    if (element.starts_with(ring_word)) return ring_views(element);
    if (element.starts_with(sphere_word)) return sphere_views(element);
    const auto angles = parse_angles(element);
    if (!angles) return {{element, element}};
    check_angles(*angles, element);
    return {view_at(*angles)};
}

Ring parse_ring(const std::string& text, const std::string& prefix) {
    const size_t at = text.find('@');
    const auto refuse = [&] {
        throw Error(
            fmt::format("'{0}{1}' is not {0}N, {0}N@ELEVATION or {0}N@AZIMUTH/ELEVATION "
                        "with N from 1 to {2}, such as {0}8@20",
                        prefix, text, max_views));
    };
    const auto count = parse_number<int>(std::string_view(text).substr(0, at));
    if (!count || *count < 1 || *count > max_views) refuse();
    Ring ring{*count, std::nullopt};
    if (at == std::string::npos) return ring;
    const std::string start = text.substr(at + 1);
    ring.start = parse_angles(start.find('/') == std::string::npos ? "0/" + start : start);
    if (!ring.start) refuse();
    check_angles(*ring.start, prefix + text);
    return ring;
}

}  // namespace sightline
