#pragma once
// Rays as a structure of arrays, as vector code reads them.
#include "core/ray.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

namespace sightline {

/// The number of rays.
inline constexpr size_t soa_width = 16;

/// Arrays for each member of sixteen rays, in the order of Ray. Not owned.
struct RaySoA {
    float *ox, *oy, *oz, *tnear, *dx, *dy, *dz, *tfar;

    Ray operator[](size_t i) const {
        return {{ox[i], oy[i], oz[i]}, tnear[i], {dx[i], dy[i], dz[i]}, tfar[i]};
    }
};

namespace soa {

using Float4 = float __attribute__((vector_size(16)));

inline Float4 load(const float* from) {
    Float4 v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

/// Transposes four floats of each of four rays, which lie eight floats apart.
inline void transpose(const float* from, float* x, float* y, float* z, float* w) {
    const Float4 a = load(from), b = load(from + 8), c = load(from + 16), d = load(from + 24);
    const Float4 xy_ab = __builtin_shufflevector(a, b, 0, 4, 1, 5),
                 xy_cd = __builtin_shufflevector(c, d, 0, 4, 1, 5),
                 zw_ab = __builtin_shufflevector(a, b, 2, 6, 3, 7),
                 zw_cd = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const std::array<Float4, 4> out = {__builtin_shufflevector(xy_ab, xy_cd, 0, 1, 4, 5),
                                       __builtin_shufflevector(xy_ab, xy_cd, 2, 3, 6, 7),
                                       __builtin_shufflevector(zw_ab, zw_cd, 0, 1, 4, 5),
                                       __builtin_shufflevector(zw_ab, zw_cd, 2, 3, 6, 7)};
    float* const to[] = {x, y, z, w};
    for (size_t i = 0; i < 4; ++i) std::memcpy(to[i], &out[i], sizeof out[i]);
}

}  // namespace soa

/// Stores one to sixteen rays; the last one is repeated in the remaining lanes.
inline void to_soa(std::span<const Ray> rays, const RaySoA& to) {
    static_assert(sizeof(Ray) == 8 * sizeof(float));
    std::array<Ray, soa_width> padded;
    const Ray* from = rays.data();
    if (rays.size() < soa_width) {
        std::copy(rays.begin(), rays.end(), padded.begin());
        std::fill(padded.begin() + static_cast<ptrdiff_t>(rays.size()), padded.end(), rays.back());
        from = padded.data();
    }
    for (size_t i = 0; i < soa_width; i += 4) {
        const float* floats = &from[i].origin.x;
        soa::transpose(floats, to.ox + i, to.oy + i, to.oz + i, to.tnear + i);
        soa::transpose(floats + 4, to.dx + i, to.dy + i, to.dz + i, to.tfar + i);
    }
}

}  // namespace sightline
