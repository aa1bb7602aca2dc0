#include "render/bands.h"
#include "render/layers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
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

std::vector<int> tile_rows(const RenderSettings& settings) {
    std::vector<int> rows;
    for (int y = settings.crop.y0 / tile_size * tile_size; y < settings.crop.y1; y += tile_size)
        rows.insert(rows.end(), 3, y);
    return rows;
}

TEST(Bands, CoverTheWindowOnceFromTheTop) {
    const RenderSettings settings = tall_settings();
    int next = settings.crop.y0;
    const Film layout = layout_of(settings, {});
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

TEST(Bands, LeaveInOrderWhenTheFirstIsFinishedLast) {
    std::vector<int> order;
    const Film layout = layout_of(tall_settings(), {});
    BandQueue bands(tall_settings(), layout,
                    [&](const Film& band) { order.push_back(band.window.y0); });
    for (const int y : {0, 0, 0, 16, 16, 16}) ASSERT_TRUE(bands.open(y));
    for (const int y : {16, 16, 16, 0, 0}) bands.close_tile(y);
    EXPECT_TRUE(order.empty());
    bands.close_tile(0);
    EXPECT_EQ(order, (std::vector{5, 16}));
}

TEST(Bands, AThreadThatIsTooFarAheadWaitsUntilThereIsRoomOrAllIsAbandoned) {
    const Film layout = layout_of(tall_settings(), {});
    BandQueue bands(tall_settings(), layout, [](const Film&) {});
    for (const int y : {0, 0, 0, 16, 32}) ASSERT_TRUE(bands.open(y));
    auto ahead = std::async(std::launch::async, [&] { return bands.open(48); });
    EXPECT_EQ(ahead.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
    for (int i = 0; i < 3; ++i) bands.close_tile(0);
    EXPECT_TRUE(ahead.get());
    ahead = std::async(std::launch::async, [&] { return bands.open(64); });
    EXPECT_EQ(ahead.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
    bands.abandon();
    EXPECT_FALSE(ahead.get());
}

}  // namespace
}  // namespace sightline
