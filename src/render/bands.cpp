#include "render/bands.h"

#include "render/tile_renderer.h"

#include <algorithm>
#include <thread>

namespace sightline {
namespace {

constexpr int bands_in_memory = 3;

size_t tiles_in(const PixelRect& rect) {
    const auto along = [](int from, int to) {
        return static_cast<size_t>((to - 1) / tile_size - from / tile_size + 1);
    };
    return along(rect.x0, rect.x1) * along(rect.y0, rect.y1);
}

unsigned count_threads(unsigned threads) {
    return std::max(1u, threads ? threads : std::thread::hardware_concurrency());
}

}  // namespace

BandQueue::BandQueue(const RenderSettings& settings, unsigned threads, const Film& layout,
                     BandSink sink)
    : layout_(layout),
      sink_(std::move(sink)),
      window_(window_of(settings)),
      // An EXR is compressed in blocks of 16 rows: as many at a time as there are threads for it.
      rows_(tile_size * static_cast<int>(std::min(count_threads(threads), 8u))),
      next_(band_of(window_.y0)) {}

PixelRect BandQueue::rect_of(int band) const {
    return {window_.x0, std::max(window_.y0, band * rows_), window_.x1,
            std::min(window_.y1, (band + 1) * rows_)};
}

Film* BandQueue::open(int y) {
    const int index = band_of(std::max(y, window_.y0));
    std::unique_lock lock(mutex_);
    // No deadlock: tiles are opened in order, so those of the next band are in progress already.
    released_.wait(lock, [&] { return abandoned_ || index < next_ + bands_in_memory; });
    if (abandoned_) return nullptr;
    const auto found = bands_.find(index);
    if (found != bands_.end()) return &found->second.film;
    const PixelRect rect = rect_of(index);
    Band& band = bands_[index];
    band = {blank_film(layout_, rect), tiles_in(rect)};
    return &band.film;
}

void BandQueue::close_tile(int y) {
    {
        const std::lock_guard lock(mutex_);
        --bands_.at(band_of(std::max(y, window_.y0))).open_tiles;
        if (writing_) return;  // that thread will find the band, too
        writing_ = true;
    }
    while (const std::optional<Film> film = take_finished_band()) {
        sink_(*film);
        release_band();
    }
}

// The next band if it is finished; otherwise nothing, and the thread is not writing any more.
std::optional<Film> BandQueue::take_finished_band() {
    const std::lock_guard lock(mutex_);
    const auto next = bands_.find(next_);
    if (abandoned_ || next == bands_.end() || next->second.open_tiles > 0) {
        writing_ = false;
        return std::nullopt;
    }
    return std::move(bands_.extract(next).mapped().film);
}

void BandQueue::release_band() {
    const std::lock_guard lock(mutex_);
    ++next_;
    released_.notify_all();
}

void BandQueue::abandon() {
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
    released_.notify_all();
}

}  // namespace sightline
