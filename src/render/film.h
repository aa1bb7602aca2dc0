#pragma once
#include "core/math.h"

#include <algorithm>
#include <string>
#include <vector>

namespace sightline {

/// Half-open pixel rectangle, y down.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

inline PixelRect intersection(const PixelRect& a, const PixelRect& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// One channel of a layer, with its name in an EXR: "R", "depth.Z", "normal.X", "object.id" ….
struct Channel {
    std::string name;
    enum class Type { half, float32, uint32 } type = Type::float32;
    std::vector<float> values;       ///< row by row over the film's window (half, float32)
    std::vector<uint32_t> integers;  ///< (uint32)
};

/// Channels of pixels over `window` within `display`. Beauty is scene-linear Rec. 709 with
/// premultiplied alpha.
struct Film {
    PixelRect display;  ///< the whole picture
    PixelRect window;   ///< the pixels that it holds
    std::vector<Channel> channels;

    /// The channel of that name, or nullptr.
    const Channel* find(const std::string& name) const;
};

/// A film with the channels of `layout`, all 0, over `window`.
Film blank_film(const Film& layout, const PixelRect& window);

/// Adds row `y` of `from`, which has the same channels and width, below the rows of `to`.
void append_row(Film& to, const Film& from, int y);

/// Copies the pixels of `rect` from a film with the same channels.
void copy_pixels(Film& to, const Film& from, const PixelRect& rect);

}  // namespace sightline
