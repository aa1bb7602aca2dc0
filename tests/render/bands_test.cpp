#include "render/bands.h"
#include "render/aov.h"
#include "render/tile_renderer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>
#include <vector>

namespace sightline {
namespace {

RenderSettings tall_settings() {
    RenderSettings settings;
    settings.width = 40;
    settings.height = 512;
    settings.crop = {3, 5, 37, 500};  // three tiles wide
    settings.threads = 1;             // a band is one row of tiles
    return settings;
}

Film tall_layout() { return Layers(Scene{}, tall_settings()).layout; }

std::vector<int> tile_rows(const RenderSettings& settings) {
    std::vector<int> rows;
    for (int y = settings.crop.y0 / tile_size * tile_size; y < settings.crop.y1; y += tile_size)
        rows.insert(rows.end(), 3, y);
    return rows;
}

TEST(Bands, CoverTheWindowOnceFromTopToBottom) {
    const RenderSettings settings = tall_settings();
    int next = settings.crop.y0;
    const Film layout = tall_layout();
    BandQueue bands(settings, layout, [&](const Film& band) {
        EXPECT_EQ(band.window.y0, next);
        EXPECT_EQ(band.window.x0, 3);
        EXPECT_EQ(band.window.x1, 37);
        EXPECT_EQ(band.find("R")->values.size(),
                  static_cast<size_t>(band.window.width() * band.window.height()));
        next = band.window.y1;
    });
    for (const int y : tile_rows(settings)) {
        ASSERT_TRUE(bands.open(y));
        bands.close_tile(y);
    }
    EXPECT_EQ(next, settings.crop.y1);
}

TEST(Bands, LeaveFromTopToBottomWhenTheFirstIsFinishedLast) {
    std::vector<int> order;
    const Film layout = tall_layout();
    BandQueue bands(tall_settings(), layout,
                    [&](const Film& band) { order.push_back(band.window.y0); });
    for (const int y : {0, 0, 0, 16, 16, 16}) ASSERT_TRUE(bands.open(y));
    for (const int y : {16, 16, 16, 0, 0}) bands.close_tile(y);
    EXPECT_TRUE(order.empty());
    bands.close_tile(0);
    EXPECT_EQ(order, (std::vector{5, 16}));
}

// A thread opens the tiles of the five first rows in order while this one closes the first row's.
// The thread cannot pass the third row before that, however late it starts.
TEST(Bands, AThreadThreeBandsAheadWaitsForTheFirst) {
    std::atomic<bool> first_left{false};
    const Film layout = tall_layout();
    BandQueue bands(tall_settings(), layout, [&](const Film&) { first_left = true; });
    std::promise<void> three_rows_open;
    auto ahead = std::async(std::launch::async, [&] {
        for (const int y : {0, 0, 0, 16, 32}) EXPECT_TRUE(bands.open(y));
        three_rows_open.set_value();
        EXPECT_TRUE(bands.open(48));
        return first_left.load();
    });
    three_rows_open.get_future().wait();
    for (int i = 0; i < 3; ++i) bands.close_tile(0);
    EXPECT_TRUE(ahead.get()) << "the fourth band was opened while three were unfinished";
}

TEST(Bands, AbandoningEndsEveryWaitAndOpensNothingMore) {
    const Film layout = tall_layout();
    BandQueue bands(tall_settings(), layout, [](const Film&) { FAIL() << "no band is finished"; });
    for (const int y : {0, 0, 0, 16, 32}) ASSERT_TRUE(bands.open(y));
    auto ahead = std::async(std::launch::async, [&] { return bands.open(48); });
    bands.abandon();
    EXPECT_FALSE(ahead.get());
    EXPECT_FALSE(bands.open(0));
}

}  // namespace
}  // namespace sightline
