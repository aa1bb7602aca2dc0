#include "image/flip.h"
#include "render/sampling_rounds.h"
#include "support/pictures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace sightline {
namespace {

QuarterSums quarter_sums(std::initializer_list<double> luminances) {
    QuarterSums sums;
    for (const double y : luminances) sums.add(y);
    return sums;
}

TEST(SamplingByError, EqualSamplesHaveNoVariance) {
    EXPECT_EQ(quarter_sums({2, 2, 2, 2}).relative_variance(), 0);
    EXPECT_EQ(quarter_sums({2, 2, 2, 2, 2, 2, 2, 2}).relative_variance(), 0);
}

// Luminance 0 and 1 are 0 and 1/2 on the display: the mean is 1/4, s² = 4 (1/4)² / 3 = 1/12, and
// the mean of four has 1/48, relative to (1/4 + 1/4)².
TEST(SamplingByError, TheVarianceOfFourSamplesIsThatOfTheirMean) {
    EXPECT_DOUBLE_EQ(quarter_sums({0, 1, 0, 1}).relative_variance(), 1.0 / 12);
}

TEST(SamplingByError, OnlyDifferencesBetweenQuartersCount) {
    EXPECT_EQ(quarter_sums({0, 2, 2, 0, 1, 1, 0, 2}).relative_variance(), 0);
    EXPECT_DOUBLE_EQ(quarter_sums({0, 0, 1, 1, 0, 0, 1, 1}).relative_variance(), 1.0 / 12);
    EXPECT_DOUBLE_EQ(
        quarter_sums({0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1}).relative_variance(),
        1.0 / 12);
}

TEST(SamplingByError, LuminanceThatIsNotFiniteIsVeryBright) {
    for (const float y : {std::numeric_limits<float>::infinity(), std::nanf("")})
        EXPECT_EQ(display_luminance({y, y, y}), 1e6 / (1e6 + 1));
    EXPECT_EQ(display_luminance({-1, -1, -1}), 0);
}

// 0.1 / error² rays: the tolerance is the error. Four times as many: eight times the tolerance.
TEST(SamplingByError, TheToleranceGrowsWithTheRaysThatThePixelHasCost) {
    const float error = 0.01f;
    EXPECT_TRUE(needs_samples(1.01e-4, 1000, error));
    EXPECT_FALSE(needs_samples(0.99e-4, 1000, error));
    EXPECT_TRUE(needs_samples(64 * 1.01e-4, 4000, error));
    EXPECT_FALSE(needs_samples(64 * 0.99e-4, 4000, error));
}

RenderSettings settings_with(float error) {
    RenderSettings settings = rich_settings(1);
    settings.aovs = {"samples"};
    settings.error = error;
    return settings;
}

TEST(SamplingByError, TheFirstRoundGrowsWithTheSamplesToExpect) {
    Needs needs;
    needs.noise = false;
    EXPECT_EQ(samples_of_first_round(settings_with(0.1f), needs), 1);
    needs.noise = true;
    EXPECT_EQ(samples_of_first_round(settings_with(0.1f), needs), 4);
    EXPECT_EQ(samples_of_first_round(settings_with(0.035f), needs), 8);
    EXPECT_EQ(samples_of_first_round(settings_with(0.01f), needs), 16);
    EXPECT_EQ(samples_of_first_round(rich_settings(5), needs), 5) << "without an error, all";
}

// Rounds end after 1, 4, 8, 16 … samples without noise, after 8, 16 … with the error given here.
TEST(SamplingByError, EachSampleCoversItsShareAfterItsRound) {
    const RenderSettings settings = settings_with(0.035f);
    Needs needs;
    needs.noise = true;
    EXPECT_EQ(samples_after_round(settings, needs, 0), 8);
    EXPECT_EQ(samples_after_round(settings, needs, 7), 8);
    EXPECT_EQ(samples_after_round(settings, needs, 8), 16);
    EXPECT_EQ(samples_after_round(settings, needs, 15), 16);
    EXPECT_EQ(samples_after_round(settings, needs, 16), 32);
    needs.noise = false;
    EXPECT_EQ(samples_after_round(settings, needs, 0), 1);
    EXPECT_EQ(samples_after_round(settings, needs, 1), 4);
    EXPECT_EQ(samples_after_round(settings, needs, 4), 8);
    EXPECT_EQ(samples_after_round(rich_settings(5), needs, 4), 5) << "without an error, all";
}

const Environment& sky() {
    static const Environment environment = uniform_environment({0.3f, 0.4f, 0.6f});
    return environment;
}

TEST(SamplingByError, NoisyPixelsGetMoreSamplesAndAllCountsArePowersOfTwo) {
    const auto result = render_scene(rich_scene(), settings_with(0.03f), &sky());
    const auto& counts = result.film.find("samples.count")->integers;
    const auto [low, high] = std::minmax_element(counts.begin(), counts.end());
    EXPECT_EQ(*low, 8u);
    EXPECT_GE(*high, 64u);
    for (const uint32_t count : counts) ASSERT_TRUE(std::has_single_bit(count)) << count;
}

TEST(SamplingByError, NoPixelGetsMoreThanTheMaximum) {
    for (const int maximum : {1, 3, 4, 11}) {
        RenderSettings settings = settings_with(1e-4f);
        settings.max_samples = maximum;
        const auto result = render_scene(rich_scene(), settings, &sky());
        const auto& counts = result.film.find("samples.count")->integers;
        EXPECT_EQ(*std::ranges::max_element(counts), static_cast<uint32_t>(maximum));
    }
}

TEST(SamplingByError, WithoutNoiseOnlyEdgesGetMoreSamples) {
    Material card = matte({1, 1, 1});
    card.unlit = true;
    const Scene scene = scene_of(quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), card);
    // The card's left edge falls on the border of two tiles.
    RenderSettings settings =
        small_settings(look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, pi / 2), 1, 64, 64);
    settings.error = 0.05f;
    settings.max_samples = 32;
    settings.aovs = {"samples"};
    const auto result = render_scene(scene, settings);
    const auto& counts = result.film.find("samples.count")->integers;
    EXPECT_EQ(counts[32 * 64 + 32], 1u) << "inside";
    EXPECT_EQ(counts[5 * 64 + 5], 1u) << "outside";
    EXPECT_GT(counts[32 * 64 + 24], 1u) << "on the edge";
    EXPECT_GT(counts[32 * 64 + 23], 1u) << "beside the edge, in the next tile";
    const auto total = std::accumulate(counts.begin(), counts.end(), uint64_t{0});
    EXPECT_LT(total, 2u * 64 * 64);
}

uint64_t rays_of(const RenderedScene& picture) {
    const auto& rays = picture.counters.rays;
    return std::accumulate(rays.begin(), rays.end(), uint64_t{0});
}

Image linear_picture(const Film& film) {
    Image image;
    image.width = film.window.width();
    image.height = film.window.height();
    image.channels = 3;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const Vec3 c = beauty_at(film, x, y);
            image.floats.insert(image.floats.end(), {c.x, c.y, c.z});
        }
    }
    return image;
}

double mean_flip(const Film& reference, const Film& film) {
    const auto values = flip(linear_picture(reference), linear_picture(film));
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

const RenderedScene& converged() {
    static const RenderedScene picture = [] {
        RenderSettings settings = settings_with(0);
        settings.samples = 512;
        settings.seed = 1;  // independent of the pictures that are measured
        return render_scene(rich_scene(), settings, &sky());
    }();
    return picture;
}

// The root mean square over the picture of the errors as the criterion sees them.
double relative_error(const Film& film) {
    double squares = 0;
    const auto pixels = static_cast<size_t>(film.window.width() * film.window.height());
    for (int y = 0; y < film.window.height(); ++y) {
        for (int x = 0; x < film.window.width(); ++x) {
            const double right = display_luminance(beauty_at(converged().film, x, y));
            const double got = display_luminance(beauty_at(film, x, y));
            squares += std::pow((got - right) / (right + dark_floor), 2);
        }
    }
    return std::sqrt(squares / static_cast<double>(pixels));
}

// Not far below either, or rays were wasted.
TEST(SamplingByError, TheErrorOfAPictureIsBelowTheOneGiven) {
    if (SIGHTLINE_SANITIZED) GTEST_SKIP() << "measured values; release builds check them";
    for (const float error : {0.1f, 0.05f, 0.025f}) {
        const auto picture = render_scene(rich_scene(), settings_with(error), &sky());
        const double measured = relative_error(picture.film) / static_cast<double>(error);
        EXPECT_LT(measured, 1) << error;
        EXPECT_GT(measured, 0.1) << error;
    }
}

// The rays of even sampling for this FLIP, between those of `samples` and of twice as many.
double even_rays(double flip, int samples) {
    RenderSettings settings = settings_with(0);
    std::array<double, 2> log_rays, log_flip;
    for (size_t i = 0; i < 2; ++i) {
        settings.samples = samples << i;
        const auto picture = render_scene(rich_scene(), settings, &sky());
        log_rays[i] = std::log(static_cast<double>(rays_of(picture)));
        log_flip[i] = std::log(mean_flip(converged().film, picture.film));
    }
    const double t = (std::log(flip) - log_flip[0]) / (log_flip[1] - log_flip[0]);
    return std::exp(log_rays[0] + t * (log_rays[1] - log_rays[0]));
}

TEST(SamplingByError, TracesFewerRaysThanEvenSamplingForTheSameFlip) {
    if (SIGHTLINE_SANITIZED) GTEST_SKIP() << "measured values; release builds check them";
    const auto picture = render_scene(rich_scene(), settings_with(0.03f), &sky());
    const double flip = mean_flip(converged().film, picture.film);
    EXPECT_LT(static_cast<double>(rays_of(picture)), even_rays(flip, 16)) << flip;
}

}  // namespace
}  // namespace sightline
