#pragma once
// Output of a picture while it is rendered: tiles fill bands of rows, which leave in order.
#include "render/settings.h"

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>

namespace sightline {

/// Receives the next rows of the picture, from the top, over the whole width of the window.
using BandSink = std::function<void(const Film& band)>;

/// The bands that are not finished. Threads that are too far ahead wait, so that at most three
/// bands are in memory. Tiles must be opened in the order of their rows. Thread-safe.
class BandQueue {
  public:
    /// `threads`: that trace tiles; 0: all. `layout`: the channels of the bands; it must outlive
    /// the queue.
    BandQueue(const RenderSettings& settings, unsigned threads, const Film& layout, BandSink sink);

    /// The band that holds the picture's row `y`, for one tile; nullptr after abandon().
    Film* open(int y);

    /// Marks one tile of the band as finished. If that finishes the first band, hands it and the
    /// finished ones after it to the sink, one thread at a time.
    void close_tile(int y);

    /// Ends every wait without finishing the picture.
    void abandon();

  private:
    struct Band {
        Film film;
        size_t open_tiles;
    };
    int band_of(int y) const { return y / rows_; }
    PixelRect rect_of(int band) const;
    std::optional<Film> take_finished_band();
    void release_band();

    const Film& layout_;
    BandSink sink_;
    PixelRect window_;
    int rows_;
    std::mutex mutex_;
    std::condition_variable released_;
    std::map<int, Band> bands_;
    int next_;              // the first band that has not been through the sink
    bool writing_ = false;  // a thread is handing bands to the sink
    bool abandoned_ = false;
};

}  // namespace sightline
