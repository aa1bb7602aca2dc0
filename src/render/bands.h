#pragma once
// The picture on its way out: tiles are gathered into bands of rows, bands leave in order.
#include "render/settings.h"

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>

namespace sightline {

/// Takes the next rows of the picture, from the top, over the whole width of the window.
using BandSink = std::function<void(const Film& band)>;

/// Holds the bands that are not finished; threads that are too far ahead wait. Tiles must be
/// opened in the order of their rows.
class BandQueue {
  public:
    /// `layout`: the channels of the bands; it must outlive the queue.
    BandQueue(const RenderSettings& settings, const Film& layout, BandSink sink);

    /// The band that holds the picture's row `y`; nullptr where all is abandoned.
    Film* open(int y);

    /// One tile of the band is finished. The band's last hands it, and those behind it that have
    /// waited for it, to the sink.
    void close_tile(int y);

    /// Ends every wait: the picture will not be finished.
    void abandon();

  private:
    struct Band {
        Film film;
        size_t open_tiles;
    };
    int band_of(int y) const { return y / rows_; }
    PixelRect rect_of(int band) const;

    const Film& layout_;
    BandSink sink_;
    PixelRect window_;
    int rows_;
    int ahead_;  // bands that may be unfinished at a time
    std::mutex mutex_;
    std::condition_variable room_;
    std::map<int, Band> bands_;
    int next_;  // the first band that the sink has not got
    bool writing_ = false, abandoned_ = false;
};

}  // namespace sightline
