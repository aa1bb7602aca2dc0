// Enlarges an image for benchmarks, bilinearly: enlarge_image FROM TO SIDE. The ending of TO
// chooses the format; the picture becomes SIDE × SIDE pixels.
#include "core/error.h"
#include "image/image.h"
#include "image/write_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace {

using namespace sightline;

Image enlarged(const Image& from, int side) {
    Image to;
    to.width = to.height = side;
    to.channels = from.channels;
    const auto channels = static_cast<size_t>(from.channels);
    to.bytes.resize(static_cast<size_t>(side) * static_cast<size_t>(side) * channels);
    const auto texel = [&](int x, int y) {
        return &from.bytes[(static_cast<size_t>(y) * static_cast<size_t>(from.width) +
                            static_cast<size_t>(x)) *
                           channels];
    };
    uint8_t* out = to.bytes.data();
    for (int y = 0; y < side; ++y) {
        const float v = (static_cast<float>(y) + 0.5f) * static_cast<float>(from.height) /
                        static_cast<float>(side);
        const int y0 = std::clamp(static_cast<int>(v - 0.5f), 0, from.height - 1);
        const int y1 = std::min(y0 + 1, from.height - 1);
        const float fy = std::clamp(v - 0.5f - static_cast<float>(y0), 0.0f, 1.0f);
        for (int x = 0; x < side; ++x) {
            const float u = (static_cast<float>(x) + 0.5f) * static_cast<float>(from.width) /
                            static_cast<float>(side);
            const int x0 = std::clamp(static_cast<int>(u - 0.5f), 0, from.width - 1);
            const int x1 = std::min(x0 + 1, from.width - 1);
            const float fx = std::clamp(u - 0.5f - static_cast<float>(x0), 0.0f, 1.0f);
            for (size_t c = 0; c < channels; ++c) {
                const auto mix = [&](int row) {
                    return static_cast<float>(texel(x0, row)[c]) * (1 - fx) +
                           static_cast<float>(texel(x1, row)[c]) * fx;
                };
                *out++ = static_cast<uint8_t>(mix(y0) * (1 - fy) + mix(y1) * fy + 0.5f);
            }
        }
    }
    return to;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        fmt::print(stderr, "enlarge_image FROM TO SIDE\n");
        return 2;
    }
    try {
        write_image(argv[2], enlarged(read_image(argv[1]), std::atoi(argv[3])));
    } catch (const Error& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
}
