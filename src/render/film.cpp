#include "render/film.h"

#include <algorithm>

namespace sightline {
namespace {

size_t pixel_at(const Film& film, int x, int y) {
    const PixelRect& w = film.window;
    return static_cast<size_t>(y - w.y0) * static_cast<size_t>(w.width()) +
           static_cast<size_t>(x - w.x0);
}

}  // namespace

const Channel* Film::find(const std::string& name) const {
    for (const Channel& channel : channels) {
        if (channel.name == name) return &channel;
    }
    return nullptr;
}

Film blank_film(const Film& layout, const PixelRect& window) {
    Film film{.display = layout.display, .window = window, .channels = {}};
    const auto pixels = static_cast<size_t>(window.width()) * static_cast<size_t>(window.height());
    for (const Channel& c : layout.channels) {
        Channel& channel = film.channels.emplace_back();
        channel.name = c.name;
        channel.type = c.type;
        if (c.type == Channel::Type::uint32) {
            channel.integers.resize(pixels);
        } else {
            channel.values.resize(pixels);
        }
    }
    return film;
}

void append_row(Film& to, const Film& from, int y) {
    const auto begin = static_cast<std::ptrdiff_t>(pixel_at(from, from.window.x0, y));
    const std::ptrdiff_t end = begin + from.window.width();
    for (size_t c = 0; c < to.channels.size(); ++c) {
        const auto append = [&](auto& values, const auto& source) {
            if (!source.empty())
                values.insert(values.end(), source.begin() + begin, source.begin() + end);
        };
        append(to.channels[c].values, from.channels[c].values);
        append(to.channels[c].integers, from.channels[c].integers);
    }
    to.window.y1 = y + 1;
}

void copy_pixels(Film& to, const Film& from, const PixelRect& rect) {
    const auto width = static_cast<size_t>(rect.width());
    for (size_t c = 0; c < to.channels.size(); ++c) {
        const auto copy = [&](auto& values, const auto& source) {
            if (source.empty()) return;
            for (int y = rect.y0; y < rect.y1; ++y)
                std::copy_n(source.data() + pixel_at(from, rect.x0, y), width,
                            values.data() + pixel_at(to, rect.x0, y));
        };
        copy(to.channels[c].values, from.channels[c].values);
        copy(to.channels[c].integers, from.channels[c].integers);
    }
}

}  // namespace sightline
