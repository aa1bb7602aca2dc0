#include "render/bands.h"
#include "render/aov.h"
#include "render/tile_renderer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <semaphore>
#include <stdexcept>
#include <vector>

namespace sightline {
namespace {

constexpr unsigned one_thread = 1;  // a band is one row of tiles

RenderSettings tall_settings() {
    RenderSettings settings;
    settings.width = 40;
    settings.height = 512;
    settings.crop = {3, 5, 37, 500};  // three tiles wide
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
    BandQueue bands(settings, one_thread, layout, [&](const Film& band) {
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
    BandQueue bands(tall_settings(), one_thread, layout,
                    [&](const Film& band) { order.push_back(band.window.y0); });
    for (const int y : {0, 0, 0, 16, 16, 16}) ASSERT_TRUE(bands.open(y));
    for (const int y : {16, 16, 16, 0, 0}) bands.close_tile(y);
    EXPECT_TRUE(order.empty());
    bands.close_tile(0);
    EXPECT_EQ(order, (std::vector{5, 16}));
}

// One thread opens all tiles, as fast as the queue lets it; this one closes them.
TEST(Bands, NoTileIsOpenedThreeBandsAheadOfTheFirstUnfinished) {
    std::atomic<int> finished{0};
    std::counting_semaphore<> open_tiles(0);
    const Film layout = tall_layout();
    BandQueue bands(tall_settings(), one_thread, layout, [&](const Film&) { ++finished; });
    const std::vector<int> rows = tile_rows(tall_settings());
    auto opening = std::async(std::launch::async, [&] {
        for (const int y : rows) {
            EXPECT_TRUE(bands.open(y));
            EXPECT_LT(y / tile_size, finished + 3);
            open_tiles.release();
        }
    });
    for (const int y : rows) {
        open_tiles.acquire();
        bands.close_tile(y);
    }
    opening.get();
    EXPECT_EQ(finished, std::ssize(rows) / 3);
}

TEST(Bands, AbandoningEndsEveryWaitAndOpensNothingMore) {
    const Film layout = tall_layout();
    BandQueue bands(tall_settings(), one_thread, layout,
                    [](const Film&) { FAIL() << "no band is finished"; });
    for (const int y : {0, 0, 0, 16, 32}) ASSERT_TRUE(bands.open(y));
    auto ahead = std::async(std::launch::async, [&] { return bands.open(48); });
    bands.abandon();
    EXPECT_FALSE(ahead.get());
    EXPECT_FALSE(bands.open(0));
}

}  // namespace
}  // namespace sightline
