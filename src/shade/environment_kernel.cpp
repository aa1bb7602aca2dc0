#include "shade/environment_kernel.h"

#include <algorithm>
#include <cassert>

// Highway compiles the rest once for each instruction set and picks one at run time. Without fused
// operations all give the same bits.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shade/environment_kernel.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: the targets first.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr size_t most_lanes = 16;
using Lanes = hn::CappedTag<float, most_lanes>;
using IntLanes = hn::RebindToSigned<Lanes>;
using Floats = hn::Vec<Lanes>;
using Ints = hn::Vec<IntLanes>;

HWY_INLINE Floats constant(float x) { return hn::Set(Lanes(), x); }
HWY_INLINE Ints constant(int x) { return hn::Set(IntLanes(), x); }
HWY_INLINE Floats to_floats(Ints x) { return hn::ConvertTo(Lanes(), x); }
HWY_INLINE Ints to_ints(Floats x) { return hn::ConvertTo(IntLanes(), x); }
HWY_INLINE Floats gather(const float* table, Ints i) { return hn::GatherIndex(Lanes(), table, i); }
HWY_INLINE Ints gather(const int32_t* table, Ints i) {
    return hn::GatherIndex(IntLanes(), table, i);
}
HWY_INLINE Ints clamp(Ints x, int low, int high) {
    return hn::Min(hn::Max(x, constant(low)), constant(high));
}

/// Three components side by side.
struct Vectors {
    Floats x, y, z;
};
HWY_INLINE Vectors mix(const Vectors& a, const Vectors& b, Floats t) {
    const Floats s = hn::Sub(constant(1.0f), t);
    return {hn::Add(hn::Mul(a.x, s), hn::Mul(b.x, t)), hn::Add(hn::Mul(a.y, s), hn::Mul(b.y, t)),
            hn::Add(hn::Mul(a.z, s), hn::Mul(b.z, t))};
}
HWY_INLINE Floats luminance(const Vectors& c) {
    return hn::Add(hn::Add(hn::Mul(c.x, constant(0.2126f)), hn::Mul(c.y, constant(0.7152f))),
                   hn::Mul(c.z, constant(0.0722f)));
}

/// arctan of x in [0,1], to 2e-7.
HWY_INLINE Floats arctan_of_unit(Floats x) {
    // Chebyshev series of atan(√s)/√s, cut after s⁸.
    constexpr float c[] = {0.999999984f,  -0.333330668f, 0.199924836f,  -0.142025705f, 0.106367541f,
                           -0.074954454f, 0.042587607f,  -0.016005030f, 0.002834064f};
    const Floats s = hn::Mul(x, x);
    Floats sum = constant(c[8]);
    for (int i = 7; i >= 0; --i) sum = hn::Add(hn::Mul(sum, s), constant(c[i]));
    return hn::Mul(x, sum);
}

/// atan2(y, x) in (−π, π]; 0 where both are 0.
HWY_INLINE Floats arctan2(Floats y, Floats x) {
    const Floats zero = hn::Zero(Lanes()), ax = hn::Abs(x), ay = hn::Abs(y);
    const Floats high = hn::Max(ax, ay), low = hn::Min(ax, ay);
    Floats angle = hn::IfThenElseZero(hn::Gt(high, zero), arctan_of_unit(hn::Div(low, high)));
    angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(constant(pi / 2), angle), angle);
    angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(constant(pi), angle), angle);
    return hn::IfThenElse(hn::Lt(y, zero), hn::Neg(angle), angle);
}

/// sin(πx) of x in [−½, ½], to 2e-7, near 0 also relative.
HWY_INLINE Floats sine_of_half_turn(Floats x) {
    // Chebyshev series of sin(π√s)/√s, cut after s⁴.
    constexpr float c[] = {3.1415927f, -5.1677103f, 2.5500774f, -0.59829128f, 0.077657662f};
    const Floats s = hn::Mul(x, x);
    Floats sum = constant(c[4]);
    for (int i = 3; i >= 0; --i) sum = hn::Add(hn::Mul(sum, s), constant(c[i]));
    return hn::Mul(x, sum);
}

/// The colours of texels by their indices.
HWY_INLINE Vectors texels(const EnvironmentTables& t, Ints row, Ints column) {
    const float* pixels = &t.pixels[0].x;
    const Ints texel = hn::Add(hn::Mul(row, constant(t.width)), column);
    const Ints first = hn::Add(texel, hn::Add(texel, texel));
    return {gather(pixels, first), gather(pixels + 1, first), gather(pixels + 2, first)};
}

/// The four texels at the corners of a cell.
struct Patch {
    Vectors a, b, c, d;  // upper left and right, lower left and right

    /// Bilinear; the fractions are those towards the right and lower texels.
    HWY_INLINE Vectors at(Floats fx, Floats fy) const {
        return mix(mix(a, b, fx), mix(c, d, fx), fy);
    }
};

/// Pdf per solid angle of a direction with this luminance in that row of cells.
HWY_INLINE Floats density(const EnvironmentTables& t, Floats luminance, Ints row, Floats sine) {
    return hn::Div(hn::Mul(luminance, gather(t.row_density.data(), row)),
                   hn::Max(sine, constant(1e-6f)));
}

/// Radiance from unit directions, and their pdf unless `pdf` is null.
HWY_INLINE Vectors look_up(const EnvironmentTables& t, const Vectors& d, Floats* pdf) {
    const Floats cosine = constant(t.cos_rotation), sine = constant(t.sin_rotation);
    const Floats x = hn::Sub(hn::Mul(cosine, d.x), hn::Mul(sine, d.z));
    const Floats z = hn::Add(hn::Mul(sine, d.x), hn::Mul(cosine, d.z));
    const Floats level = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(z, z)));
    const Floats half = constant(0.5f);
    const Floats u = hn::Add(hn::Mul(arctan2(z, x), constant(0.5f / pi)), half);
    const Floats v = hn::Mul(arctan2(level, d.y), constant(1 / pi));

    const Floats column = hn::Sub(hn::Mul(u, constant(static_cast<float>(t.width))), half);
    const Floats row = hn::Sub(hn::Mul(v, constant(static_cast<float>(t.height))), half);
    const Ints left = to_ints(hn::Floor(column)), top = to_ints(hn::Floor(row));
    const Ints last = constant(t.width - 1), one = constant(1);
    const Ints x0 = hn::IfThenElse(hn::Lt(left, constant(0)), last, hn::Min(left, last));
    // Clamped because of directions that are not numbers.
    const Ints x1 =
        hn::IfThenElse(hn::Eq(left, last), constant(0), clamp(hn::Add(left, one), 0, t.width - 1));
    const Ints y0 = clamp(top, 0, t.height - 1);
    const Ints y1 = clamp(hn::Add(top, one), 0, t.height - 1);
    const Patch patch = {texels(t, y0, x0), texels(t, y0, x1), texels(t, y1, x0),
                         texels(t, y1, x1)};
    const Vectors color = patch.at(hn::Sub(column, to_floats(left)), hn::Sub(row, to_floats(top)));
    if (pdf) *pdf = density(t, luminance(color), clamp(hn::Add(top, one), 0, t.height), level);
    return color;
}

/// The step of a cumulative table that u·(last value) falls into, and the fraction of it in [0,1).
struct CdfStep {
    Ints index;  // into the whole table
    Floats fraction;
};

/// `first` is the index of the first value of the table, `guide` that of its guide.
HWY_INLINE CdfStep invert_cdf(const float* table, Ints first, int count, const int32_t* guides,
                              Ints guide, Floats u) {
    constexpr int buckets = EnvironmentTables::buckets;
    const Floats target = hn::Mul(u, gather(table, hn::Add(first, constant(count - 1))));
    const Ints bucket = hn::Add(
        guide, clamp(to_ints(hn::Mul(u, constant(static_cast<float>(buckets)))), 0, buckets - 1));
    const Ints one = constant(1);
    Ints low = hn::Add(first, gather(guides, bucket));
    Ints high = hn::Add(first, gather(guides, hn::Add(bucket, one)));
    for (;;) {  // the first value beyond the target
        const auto open = hn::Lt(low, high);
        if (hn::AllFalse(IntLanes(), open)) break;
        const Ints middle = hn::ShiftRight<1>(hn::Add(low, high));
        const auto below =
            hn::And(open, hn::RebindMask(IntLanes(), hn::Le(gather(table, middle), target)));
        high = hn::IfThenElse(below, high, middle);
        low = hn::IfThenElse(below, hn::Add(middle, one), low);
    }
    const auto later = hn::RebindMask(Lanes(), hn::Gt(low, first));
    const Floats start =
        hn::IfThenElseZero(later, gather(table, hn::Max(hn::Sub(low, one), first)));
    const Floats size = hn::Sub(gather(table, low), start);
    const Floats fraction =
        hn::IfThenElseZero(hn::Gt(size, hn::Zero(Lanes())), hn::Div(hn::Sub(target, start), size));
    return {low, hn::Min(hn::Max(fraction, hn::Zero(Lanes())), constant(0.99999994f))};
}

/// Inverts the cumulative distribution of a density that is linear from a to b on [0,1].
HWY_INLINE Floats invert_linear(Floats a, Floats b, Floats u) {
    const Floats zero = hn::Zero(Lanes()), one = constant(1.0f), sum = hn::Add(a, b);
    // The root written so that it stays exact for a = b.
    const Floats squares =
        hn::Add(hn::Mul(hn::Mul(a, a), hn::Sub(one, u)), hn::Mul(hn::Mul(b, b), u));
    const Floats denominator = hn::Add(a, hn::Sqrt(squares));
    const Floats root = hn::IfThenElseZero(hn::Gt(denominator, zero),
                                           hn::Min(one, hn::Div(hn::Mul(u, sum), denominator)));
    return hn::IfThenElse(hn::Gt(sum, zero), root, u);
}

struct Samples {
    Vectors wi, radiance;
    Floats pdf;
};

/// The unit direction of a point of the image and the sine of its angle from +y. Integers are the
/// centres of texels.
HWY_INLINE Vectors direction(const EnvironmentTables& t, Floats x, Floats y, Floats& sine) {
    const Floats half = constant(0.5f), one = constant(1.0f);
    const Floats down =  // half turns from +y
        hn::Mul(hn::Add(y, half), constant(1 / static_cast<float>(t.height)));
    sine = sine_of_half_turn(hn::Min(down, hn::Sub(one, down)));
    Floats round =  // half turns about +y, in [−1, 1]
        hn::Sub(hn::Mul(hn::Add(x, half), constant(2 / static_cast<float>(t.width))), one);
    const auto before_seam = hn::Lt(round, hn::Neg(one));
    round = hn::IfThenElse(before_seam, hn::Add(round, constant(2.0f)), round);
    const Floats size = hn::Abs(round);
    const Floats folded = hn::CopySign(hn::Min(size, hn::Sub(one, size)), round);
    const Floats px = hn::Mul(sine_of_half_turn(hn::Sub(half, size)), sine);
    const Floats pz = hn::Mul(sine_of_half_turn(folded), sine);
    const Floats c = constant(t.cos_rotation), s = constant(t.sin_rotation);
    return {hn::Add(hn::Mul(c, px), hn::Mul(s, pz)), sine_of_half_turn(hn::Sub(half, down)),
            hn::Sub(hn::Mul(c, pz), hn::Mul(s, px))};
}

HWY_INLINE Samples sample(const EnvironmentTables& t, Floats u, Floats v) {
    const Ints zero = constant(0), one = constant(1);
    const CdfStep row = invert_cdf(t.marginal.data(), zero, t.height + 1, t.guides.data(), zero, v);
    const Ints first = hn::Mul(row.index, constant(t.width));
    const Ints guide = hn::Mul(hn::Add(row.index, one), constant(EnvironmentTables::guide_size));
    CdfStep column = invert_cdf(t.conditional.data(), first, t.width, t.guides.data(), guide, u);
    column.index = hn::Sub(column.index, first);

    const Ints top = hn::Max(hn::Sub(row.index, one), zero);
    const Ints bottom = hn::Min(row.index, constant(t.height - 1));
    const Ints left = hn::IfThenElse(hn::Gt(column.index, zero), hn::Sub(column.index, one),
                                     constant(t.width - 1));
    const Patch patch = {texels(t, top, left), texels(t, top, column.index),
                         texels(t, bottom, left), texels(t, bottom, column.index)};
    const Floats la = luminance(patch.a), lb = luminance(patch.b);
    const Floats lc = luminance(patch.c), ld = luminance(patch.d);
    const Floats fy = invert_linear(hn::Add(la, lb), hn::Add(lc, ld), row.fraction);
    const Floats upper = hn::Add(la, hn::Mul(hn::Sub(lc, la), fy));
    const Floats lower = hn::Add(lb, hn::Mul(hn::Sub(ld, lb), fy));
    const Floats fx = invert_linear(upper, lower, column.fraction);

    // The cells at the poles are half as high and constant in height.
    const Floats half = constant(0.5f), last = constant(static_cast<float>(t.height - 1));
    const auto at_north = hn::RebindMask(Lanes(), hn::Eq(row.index, zero));
    const auto at_south = hn::RebindMask(Lanes(), hn::Eq(row.index, constant(t.height)));
    Floats y = hn::Add(to_floats(hn::Sub(row.index, one)), fy);
    y = hn::IfThenElse(at_north, hn::Mul(half, hn::Sub(fy, constant(1.0f))), y);
    y = hn::IfThenElse(at_south, hn::Add(last, hn::Mul(half, fy)), y);
    const Floats x = hn::Add(to_floats(hn::Sub(column.index, one)), fx);

    Samples result;
    Floats sine;
    result.wi = direction(t, x, y, sine);
    result.radiance = patch.at(fx, fy);
    result.pdf = density(t, luminance(result.radiance), row.index, sine);
    return result;
}

/// Vectors as structure of arrays. Lanes past the end repeat the last vector.
struct alignas(64) Columns {
    float x[most_lanes], y[most_lanes], z[most_lanes];

    void load(std::span<const Vec3> from, size_t begin) {
        for (size_t i = 0; i < hn::Lanes(Lanes()); ++i) {
            const Vec3& v = from[std::min(begin + i, from.size() - 1)];
            x[i] = v.x;
            y[i] = v.y;
            z[i] = v.z;
        }
    }
    HWY_INLINE void store(const Vectors& v) {
        hn::Store(v.x, Lanes(), x);
        hn::Store(v.y, Lanes(), y);
        hn::Store(v.z, Lanes(), z);
    }
    Vec3 at(size_t i) const { return {x[i], y[i], z[i]}; }
};

void LookUp(const EnvironmentTables& tables, std::span<const Vec3> directions,
            std::span<Vec3> radiance, std::span<float> pdfs) {
    const Lanes lanes;
    const size_t width = hn::Lanes(lanes);
    for (size_t begin = 0; begin < directions.size(); begin += width) {
        Columns in, out;
        alignas(64) float pdf[most_lanes];
        in.load(directions, begin);
        Floats density;
        out.store(look_up(tables,
                          {hn::Load(lanes, in.x), hn::Load(lanes, in.y), hn::Load(lanes, in.z)},
                          pdfs.empty() ? nullptr : &density));
        if (!pdfs.empty()) hn::Store(density, lanes, pdf);
        const size_t count = std::min(width, directions.size() - begin);
        for (size_t i = 0; i < count; ++i) radiance[begin + i] = out.at(i);
        if (!pdfs.empty()) std::copy_n(pdf, count, &pdfs[begin]);
    }
}

void Sample(const EnvironmentTables& tables, std::span<const float> u, std::span<const float> v,
            std::span<EnvironmentSample> samples) {
    const Lanes lanes;
    const size_t width = hn::Lanes(lanes);
    for (size_t begin = 0; begin < u.size(); begin += width) {
        Columns wi, radiance;
        alignas(64) float in_u[most_lanes] = {}, in_v[most_lanes] = {}, pdf[most_lanes];
        const size_t count = std::min(width, u.size() - begin);
        std::copy_n(&u[begin], count, in_u);
        std::copy_n(&v[begin], count, in_v);
        const Samples drawn = sample(tables, hn::Load(lanes, in_u), hn::Load(lanes, in_v));
        wi.store(drawn.wi);
        radiance.store(drawn.radiance);
        hn::Store(drawn.pdf, lanes, pdf);
        for (size_t i = 0; i < count; ++i) samples[begin + i] = {wi.at(i), radiance.at(i), pdf[i]};
    }
}

}  // namespace sightline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline {

HWY_EXPORT(LookUp);
HWY_EXPORT(Sample);

void look_up_environment(const EnvironmentTables& tables, std::span<const Vec3> directions,
                         std::span<Vec3> radiance, std::span<float> pdfs) {
    assert(radiance.size() == directions.size());
    assert(pdfs.empty() || pdfs.size() == directions.size());
    HWY_DYNAMIC_DISPATCH(LookUp)(tables, directions, radiance, pdfs);
}

void sample_environment(const EnvironmentTables& tables, std::span<const float> u,
                        std::span<const float> v, std::span<EnvironmentSample> samples) {
    assert(v.size() == u.size() && samples.size() == u.size());
    HWY_DYNAMIC_DISPATCH(Sample)(tables, u, v, samples);
}

}  // namespace sightline
#endif
