#include "shade/environment.h"

#include "core/srgb.h"
#include "shade/fast_math.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace sightline {
namespace {

float usable(float v) { return v > 0 && v < std::numeric_limits<float>::max() ? v : 0; }

std::vector<Vec3> linear_pixels(const Image& image) {
    std::array<float, 256> table;
    for (size_t i = 0; i < 256; ++i) table[i] = decode_srgb(static_cast<float>(i) / 255.0f);
    const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    const auto channels = static_cast<size_t>(image.channels);
    const size_t green = channels >= 3 ? 1 : 0, blue = channels >= 3 ? 2 : 0;
    std::vector<Vec3> pixels(count);
    for (size_t i = 0; i < count; ++i) {
        if (image.bytes.empty()) {
            const float* p = &image.floats[i * channels];
            pixels[i] = {usable(p[0]), usable(p[green]), usable(p[blue])};
        } else {
            const uint8_t* p = &image.bytes[i * channels];
            pixels[i] = {table[p[0]], table[p[green]], table[p[blue]]};
        }
    }
    return pixels;
}

/// Where u·(last value) falls in a cumulative table, and how far into that step in [0,1).
struct Step {
    int index;
    float fraction;
};

/// Where each of `buckets` equal parts of the range begins in a cumulative table, so that a search
/// touches one or two of its cache lines (Chen & Asau 1974, "On Generating Random Variates from an
/// Empirical Distribution").
constexpr int buckets = 256;
constexpr int guide_size = buckets + 1;

void build_guide(const float* cumulative, int count, uint32_t* guide) {
    uint32_t step = 0;
    for (int b = 0; b <= buckets; ++b) {
        const float target = static_cast<float>(b) / buckets * cumulative[count - 1];
        while (static_cast<int>(step) < count - 1 && cumulative[step] <= target) ++step;
        guide[b] = step;
    }
}

Step invert(const float* cumulative, int count, const uint32_t* guide, float u) {
    const float target = u * cumulative[count - 1];
    const int bucket = std::min(static_cast<int>(u * buckets), buckets - 1);
    const float* found =
        std::upper_bound(cumulative + guide[bucket], cumulative + guide[bucket + 1], target);
    const int index = static_cast<int>(found - cumulative);
    const float low = index > 0 ? cumulative[index - 1] : 0;
    const float size = cumulative[index] - low;
    const float fraction = size > 0 ? (target - low) / size : 0;
    return {index, std::clamp(fraction, 0.0f, 0.99999994f)};
}

/// Solid angle of a row of cells, over 2π.
double row_solid_angle(size_t row, size_t height) {
    const double half_step = static_cast<double>(pi) / (2.0 * static_cast<double>(height));
    const double middle = 2.0 * static_cast<double>(row) * half_step;
    const double top = std::max(0.0, middle - half_step);
    const double bottom = std::min(static_cast<double>(pi), middle + half_step);
    return std::cos(top) - std::cos(bottom);
}

/// Inverts the cumulative distribution of a density that runs linearly from a to b on [0,1].
float sample_linear(float a, float b, float u) {
    const float sum = a + b;
    if (!(sum > 0)) return u;
    // The root written so that it stays exact for a = b.
    const float denominator = a + std::sqrt(a * a * (1 - u) + b * b * u);
    return denominator > 0 ? std::min(1.0f, u * sum / denominator) : 0;
}

}  // namespace

Environment::Environment(const Image& picture, float rotation, bool importance)
    : width_(picture.width),
      height_(picture.height),
      pixels_(linear_pixels(picture)),
      cos_rotation_(std::cos(rotation)),
      sin_rotation_(std::sin(rotation)) {
    assert(!picture.empty());
    if (importance) build_tables();
}

void Environment::build_tables() {
    const auto width = static_cast<size_t>(width_), height = static_cast<size_t>(height_);
    std::vector<float> above(width), below(width);
    const auto read_row = [&](size_t y, std::vector<float>& row) {
        for (size_t x = 0; x < width; ++x) row[x] = luminance(pixels_[y * width + x]);
    };
    read_row(0, above);
    marginal_.resize(height + 1);
    conditional_.resize((height + 1) * width);
    double power = 0;
    for (size_t r = 0; r <= height; ++r) {
        read_row(std::min(r, height - 1), below);
        float* cumulative = &conditional_[r * width];
        double sum = 0;
        float previous = above[width - 1] + below[width - 1];
        for (size_t c = 0; c < width; ++c) {
            const float column = above[c] + below[c];
            sum += static_cast<double>(previous + column) * 0.25;
            cumulative[c] = static_cast<float>(sum);
            previous = column;
        }
        power += sum * row_solid_angle(r, height);
        marginal_[r] = static_cast<float>(power);
        above.swap(below);
    }
    guides_.resize((height + 2) * guide_size);
    build_guide(marginal_.data(), height_ + 1, guides_.data());
    for (size_t r = 0; r <= height; ++r)
        build_guide(&conditional_[r * width], width_, &guides_[(r + 1) * guide_size]);
    // Inside a row the density per picture area is luminance · solid angle / height of the row.
    row_density_.resize(height + 1);
    const double texels = static_cast<double>(width) * static_cast<double>(height);
    for (size_t r = 0; r <= height; ++r) {
        const double row_height = r == 0 || r == height ? 0.5 : 1;
        const double scale = texels / (2 * static_cast<double>(pi) * static_cast<double>(pi));
        row_density_[r] =
            static_cast<float>(row_solid_angle(r, height) / row_height * scale / power);
    }
}

Vec2 Environment::picture_uv(const Vec3& d) const {
    const float x = cos_rotation_ * d.x - sin_rotation_ * d.z;
    const float z = sin_rotation_ * d.x + cos_rotation_ * d.z;
    const float level = std::sqrt(x * x + z * z);
    return {fast_atan2(z, x) * (0.5f / pi) + 0.5f, fast_atan2(level, d.y) * (1 / pi)};
}

Vec3 Environment::lookup(float x, float y) const {
    const int left = floor_to_int(x), top = floor_to_int(y);
    const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
    const int x0 = left < 0 ? width_ - 1 : std::min(left, width_ - 1);
    const int x1 = left + 1 >= width_ ? 0 : left + 1;
    const int y0 = std::clamp(top, 0, height_ - 1), y1 = std::clamp(top + 1, 0, height_ - 1);
    const Vec3 upper = texel(x0, y0) * (1 - fx) + texel(x1, y0) * fx;
    const Vec3 lower = texel(x0, y1) * (1 - fx) + texel(x1, y1) * fx;
    return upper * (1 - fy) + lower * fy;
}

Vec3 Environment::radiance(const Vec3& d) const {
    const Vec2 uv = picture_uv(d);
    return lookup(uv.x * static_cast<float>(width_) - 0.5f,
                  uv.y * static_cast<float>(height_) - 0.5f);
}

Environment::Sample Environment::sample(Vec2 u) const {
    const int rows = height_ + 1;
    if (marginal_.empty() || !(marginal_.back() > 0)) return {Vec3(0, 1, 0), Vec3(0), 0};
    const Step row = invert(marginal_.data(), rows, guides_.data(), u.y);
    const float* columns =
        &conditional_[static_cast<size_t>(row.index) * static_cast<size_t>(width_)];
    const uint32_t* guide = &guides_[static_cast<size_t>(row.index + 1) * guide_size];
    const Step column = invert(columns, width_, guide, u.x);

    const int top = std::max(row.index - 1, 0), bottom = std::min(row.index, height_ - 1);
    const int left = column.index > 0 ? column.index - 1 : width_ - 1, right = column.index;
    const Vec3 &a = texel(left, top), &b = texel(right, top);
    const Vec3 &c = texel(left, bottom), &d = texel(right, bottom);
    const float la = luminance(a), lb = luminance(b), lc = luminance(c), ld = luminance(d);
    const float fy = sample_linear(la + lb, lc + ld, row.fraction);
    const float fx = sample_linear(la + (lc - la) * fy, lb + (ld - lb) * fy, column.fraction);

    // The cells at the poles are half as high and do not vary in height.
    float y = static_cast<float>(row.index) - 1 + fy;
    if (row.index == 0) y = -0.5f + 0.5f * fy;
    if (row.index == height_) y = static_cast<float>(height_ - 1) + 0.5f * fy;
    const float x = static_cast<float>(column.index) - 1 + fx;

    const float theta = pi * (y + 0.5f) / static_cast<float>(height_);
    const float phi = 2 * pi * ((x + 0.5f) / static_cast<float>(width_) - 0.5f);
    const float sine = std::sin(theta);
    const float px = std::cos(phi) * sine, pz = std::sin(phi) * sine;
    Sample sample;
    sample.wi = {cos_rotation_ * px + sin_rotation_ * pz, std::cos(theta),
                 -sin_rotation_ * px + cos_rotation_ * pz};
    sample.radiance = (a * (1 - fx) + b * fx) * (1 - fy) + (c * (1 - fx) + d * fx) * fy;
    sample.pdf = density(luminance(sample.radiance), row.index, sine);
    return sample;
}

float Environment::density(float luminance, int row, float sine) const {
    return luminance * row_density_[static_cast<size_t>(row)] / std::max(sine, 1e-6f);
}

float Environment::pdf(const Vec3& d) const {
    if (marginal_.empty() || !(marginal_.back() > 0)) return 0;
    const Vec2 uv = picture_uv(d);
    const float y = uv.y * static_cast<float>(height_) - 0.5f;
    const Vec3 color = lookup(uv.x * static_cast<float>(width_) - 0.5f, y);
    const int row = std::clamp(floor_to_int(y) + 1, 0, height_);
    return density(luminance(color), row, std::sqrt(d.x * d.x + d.z * d.z));
}

size_t Environment::memory() const {
    return pixels_.size() * sizeof(Vec3) +
           (marginal_.size() + conditional_.size()) * sizeof(float) +
           guides_.size() * sizeof(uint32_t);
}

}  // namespace sightline
