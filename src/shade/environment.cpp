#include "shade/environment.h"

#include "core/parallel.h"
#include "core/sampler.h"
#include "core/srgb.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace sightline {
namespace {

/// Above this, sums over the texels of the largest image would overflow, as infinity does.
constexpr float max_radiance = 1e30f;

float sanitized(float v) { return v > max_radiance ? Environment::largest_half : v > 0 ? v : 0; }

std::vector<Vec3> linear_pixels(const Image& image, size_t& overflowed) {
    std::array<float, 256> table;
    for (size_t i = 0; i < 256; ++i) table[i] = decode_srgb(static_cast<float>(i) / 255.0f);
    const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    const auto channels = static_cast<size_t>(image.channels);
    const size_t green = channels >= 3 ? 1 : 0, blue = channels >= 3 ? 2 : 0;
    std::vector<Vec3> pixels(count);
    for (size_t i = 0; i < count; ++i) {
        if (image.bytes.empty()) {
            const float* p = &image.floats[i * channels];
            pixels[i] = {sanitized(p[0]), sanitized(p[green]), sanitized(p[blue])};
            overflowed += p[0] > max_radiance || p[green] > max_radiance || p[blue] > max_radiance;
        } else {
            const uint8_t* p = &image.bytes[i * channels];
            pixels[i] = {table[p[0]], table[p[green]], table[p[blue]]};
        }
    }
    return pixels;
}

/// See EnvironmentTables::guides.
void build_guide(const float* cumulative, int count, int32_t* guide) {
    int step = 0;
    constexpr int buckets = EnvironmentTables::buckets;
    for (int b = 0; b <= buckets; ++b) {
        const float target = static_cast<float>(b) / buckets * cumulative[count - 1];
        while (step < count - 1 && cumulative[step] <= target) ++step;
        guide[b] = step;
    }
}

/// Solid angle of a row of cells of EnvironmentTables, over 2π.
double row_solid_angle(size_t row, size_t height) {
    const double half_step = static_cast<double>(pi) / (2.0 * static_cast<double>(height));
    const double middle = 2.0 * static_cast<double>(row) * half_step;
    const double top = std::max(0.0, middle - half_step);
    const double bottom = std::min(static_cast<double>(pi), middle + half_step);
    return std::cos(top) - std::cos(bottom);
}

/// Of the polar angle of a row's directions.
float row_sine(size_t row, int height) {
    return std::sin(pi * (static_cast<float>(row) + 0.5f) / static_cast<float>(height));
}

/// The y of a row's directions.
float row_height(int row, int height) {
    return std::cos(pi * (static_cast<float>(row) + 0.5f) / static_cast<float>(height));
}

/// The direction of a texel's centre.
Vec3 texel_direction(const EnvironmentTables& t, int x, int y) {
    const float phi =
        2 * pi * ((static_cast<float>(x) + 0.5f) / static_cast<float>(t.width) - 0.5f);
    const float sine = row_sine(static_cast<size_t>(y), t.height);
    const float px = std::cos(phi) * sine, pz = std::sin(phi) * sine;
    return {t.cos_rotation * px + t.sin_rotation * pz, row_height(y, t.height),
            t.cos_rotation * pz - t.sin_rotation * px};
}

/// The part of the unit from `i` on that lies between.
float overlap(int i, float low, float high) {
    return std::min(static_cast<float>(i + 1), high) - std::max(static_cast<float>(i), low);
}

/// The mean of what becomes texel (x, y) of an image that is not larger.
Vec3 mean_of_texels(const EnvironmentTables& from, const EnvironmentTables& to, int x, int y) {
    const float across = static_cast<float>(from.width) / static_cast<float>(to.width);
    const float down = static_cast<float>(from.height) / static_cast<float>(to.height);
    const float left = static_cast<float>(x) * across, top = static_cast<float>(y) * down;
    Vec3 sum(0, 0, 0);
    for (int v = static_cast<int>(top); v < from.height && overlap(v, top, top + down) > 0; ++v)
        for (int u = static_cast<int>(left); u < from.width && overlap(u, left, left + across) > 0;
             ++u)
            sum += from.pixels[static_cast<size_t>(v) * static_cast<size_t>(from.width) +
                               static_cast<size_t>(u)] *
                   (overlap(v, top, top + down) * overlap(u, left, left + across));
    return sum * (1 / (across * down));
}

/// The mean of the texels about one, by a normal distribution of the angle to it.
Vec3 spot_mean(const EnvironmentTables& t, int row, int column, float deviation) {
    const float step = pi / static_cast<float>(t.height), reach = 3 * deviation;
    const float theta = step * (static_cast<float>(row) + 0.5f);
    const int rows = static_cast<int>(std::ceil(reach / step));
    Vec3 sum(0, 0, 0);
    float weights = 0;
    for (int y = std::max(row - rows, 0); y <= std::min(row + rows, t.height - 1); ++y) {
        const float other = step * (static_cast<float>(y) + 0.5f);
        const float sines = std::sin(theta) * std::sin(other), cosines = std::cos(theta - other);
        // cos of the angle = cosines − sines · (1 − cos Δφ): the columns that are within reach.
        const float within = (cosines - std::cos(std::min(reach, pi))) / sines;
        if (within < 0) continue;
        const float angle = within >= 2 ? pi : std::acos(1 - within);
        const float column_step = 2 * pi / static_cast<float>(t.width);
        const int columns = std::min(static_cast<int>(angle / column_step), t.width / 2);
        for (int dx = -columns; dx < std::min(columns + 1, t.width - columns); ++dx) {
            const float cosine =
                cosines - sines * (1 - std::cos(column_step * static_cast<float>(dx)));
            const float distance = std::acos(std::clamp(cosine, -1.0f, 1.0f)) / deviation;
            const float weight = std::exp(-distance * distance / 2) * std::sin(other);
            const int x = (column + dx + t.width) % t.width;
            sum += t.pixels[static_cast<size_t>(y * t.width + x)] * weight;
            weights += weight;
        }
    }
    return sum * (1 / weights);
}

}  // namespace

Environment::Environment(const Image& image, float rotation, float brightness) {
    assert(!image.empty());
    tables_.width = image.width;
    tables_.height = image.height;
    tables_.pixels = linear_pixels(image, overflowed_texels_);
    if (brightness != 1)
        for (Vec3& pixel : tables_.pixels) pixel *= brightness;
    tables_.cos_rotation = std::cos(rotation);
    tables_.sin_rotation = std::sin(rotation);
    build_tables();
}

void Environment::build_tables() {
    EnvironmentTables& t = tables_;
    const auto width = static_cast<size_t>(t.width), height = static_cast<size_t>(t.height);
    std::vector<float> above(width), below(width);
    const auto read_row = [&](size_t y, std::vector<float>& row) {
        for (size_t x = 0; x < width; ++x) row[x] = luminance(t.pixels[y * width + x]);
    };
    read_row(0, above);
    t.marginal.resize(height + 1);
    t.conditional.resize((height + 1) * width);
    double power = 0;
    for (size_t r = 0; r <= height; ++r) {
        read_row(std::min(r, height - 1), below);
        float* cumulative = &t.conditional[r * width];
        double sum = 0;
        float previous = above[width - 1] + below[width - 1];
        for (size_t c = 0; c < width; ++c) {
            const float column = above[c] + below[c];
            sum += static_cast<double>(previous + column) * 0.25;
            cumulative[c] = static_cast<float>(sum);
            previous = column;
        }
        power += sum * row_solid_angle(r, height);
        t.marginal[r] = static_cast<float>(power);
        above.swap(below);
    }
    t.guides.resize((height + 2) * EnvironmentTables::guide_size);
    build_guide(t.marginal.data(), t.height + 1, t.guides.data());
    for (size_t r = 0; r <= height; ++r)
        build_guide(&t.conditional[r * width], t.width,
                    &t.guides[(r + 1) * EnvironmentTables::guide_size]);
    // Within a row of cells the pdf per area of the image is luminance · solid angle / row height.
    t.row_density.resize(height + 1);
    const double texels = static_cast<double>(width) * static_cast<double>(height);
    for (size_t r = 0; r <= height; ++r) {
        const double row_height = r == 0 || r == height ? 0.5 : 1;
        const double scale = texels / (2 * static_cast<double>(pi) * static_cast<double>(pi));
        t.row_density[r] =
            static_cast<float>(row_solid_angle(r, height) / row_height * scale / power);
    }
}

void Environment::look_up(std::span<const Vec3> directions, std::span<Vec3> radiance,
                          std::span<float> pdfs) const {
    look_up_environment(tables_, directions, radiance, is_black() ? std::span<float>() : pdfs);
    if (is_black()) std::fill(pdfs.begin(), pdfs.end(), 0.0f);
}

Vec3 Environment::radiance(const Vec3& d) const {
    Vec3 color;
    look_up({&d, 1}, {&color, 1}, {});
    return color;
}

Vec3 Environment::mean_radiance() const {
    constexpr uint32_t n = 1024;
    Vec3 sum(0, 0, 0);
    for (uint32_t i = 0; i < n; ++i) {
        const Vec2 u = sample_2d(i, 0);
        const float y = 1 - 2 * u.y, r = std::sqrt(std::fmax(0.0f, 1 - y * y));
        sum += radiance({r * std::cos(2 * pi * u.x), y, r * std::sin(2 * pi * u.x)});
    }
    return sum * (1.0f / n);
}

Vec3 Environment::integral() const {
    const Sample any = sample({0.5f, 0.5f});
    if (!(any.pdf > 0)) return Vec3(0, 0, 0);
    Vec3 sum(0, 0, 0);
    const auto width = static_cast<size_t>(tables_.width);
    for (size_t y = 0; y < static_cast<size_t>(tables_.height); ++y) {
        Vec3 row(0, 0, 0);
        for (size_t x = 0; x < width; ++x) row += tables_.pixels[y * width + x];
        sum += row * row_sine(y, tables_.height);
    }
    return sum * (luminance(any.radiance) / any.pdf / luminance(sum));
}

Environment Environment::changed(const std::function<Vec3(float y, const Vec3& radiance)>& change,
                                 int columns) const {
    Environment result;
    EnvironmentTables& to = result.tables_;
    to.width = columns;
    to.height = std::max(1, static_cast<int>(int64_t{tables_.height} * columns / tables_.width));
    to.cos_rotation = tables_.cos_rotation;
    to.sin_rotation = tables_.sin_rotation;
    to.pixels.resize(static_cast<size_t>(to.height) * static_cast<size_t>(columns));
    parallel_for(static_cast<size_t>(to.height), [&](size_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < columns; ++x) {
            const Vec3 radiance = columns > tables_.width
                                      ? this->radiance(texel_direction(to, x, y))
                                      : mean_of_texels(tables_, to, x, y);
            to.pixels[row * static_cast<size_t>(columns) + static_cast<size_t>(x)] =
                change(row_height(y, to.height), radiance);
        }
    });
    result.build_tables();
    return result;
}

Environment Environment::blurred(float radius) const {
    // Two texels for the standard deviation, and interpolation between; more show nothing.
    const auto columns = static_cast<int>(std::clamp(8 * pi / radius, 64.0f, 2048.0f));
    Environment result = changed([](float, const Vec3& radiance) { return radiance; }, columns);
    const EnvironmentTables& from = result.tables_;
    std::vector<Vec3> pixels(from.pixels.size());
    parallel_for(static_cast<size_t>(from.height), [&](size_t row) {
        for (int x = 0; x < from.width; ++x)
            pixels[row * static_cast<size_t>(from.width) + static_cast<size_t>(x)] =
                spot_mean(from, static_cast<int>(row), x, radius / 2);
    });
    result.tables_.pixels = std::move(pixels);
    result.build_tables();
    return result;
}

float Environment::pdf(const Vec3& d) const {
    Vec3 color;
    float density = 0;
    look_up({&d, 1}, {&color, 1}, {&density, 1});
    return density;
}

void Environment::sample(std::span<const float> u, std::span<const float> v,
                         std::span<Sample> samples) const {
    if (is_black()) {
        std::fill(samples.begin(), samples.end(), Sample{Vec3(0, 1, 0), Vec3(0), 0});
    } else {
        sample_environment(tables_, u, v, samples);
    }
}

Environment::Sample Environment::sample(Vec2 u) const {
    Sample result;
    sample({&u.x, 1}, {&u.y, 1}, {&result, 1});
    return result;
}

bool Environment::is_black() const { return !(tables_.marginal.back() > 0); }

}  // namespace sightline
