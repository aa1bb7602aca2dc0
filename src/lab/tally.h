#pragma once
// Counting what the referee says, and how sure the counts make one.
#include "exact/referee.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <optional>

namespace sightline {

/// Numbers ≥ 0 of which quantiles are asked: counts by size, to within 1/16; the same whatever the
/// order in which they come.
class Quantiles {
  public:
    void add(double value);
    void add(const Quantiles& other);

    uint64_t count() const { return count_; }
    double max() const { return max_; }
    /// The value below or at which a fraction `p` of them lies, never less; 0 where there are none.
    double at(double p) const;

  private:
    std::vector<uint64_t> bins_;
    uint64_t count_ = 0;
    double max_ = 0;
};

/// What an engine made of a set of rays, by the referee.
struct Tally {
    std::array<uint64_t, verdicts> by_verdict{};  ///< indexed by Verdict
    uint64_t unchecked = 0;  ///< engines agreed and the referee was not asked (compare's bound)
    uint64_t self_hits = 0;  ///< hits that is_self_hit; counted beside the verdict
    Quantiles t_ulps;        ///< |t − exact t| in ulps of a float, of the answers same and tie

    uint64_t operator[](Verdict v) const { return by_verdict[static_cast<size_t>(v)]; }
    void count(Verdict v) { ++by_verdict[static_cast<size_t>(v)]; }
    void add(const Tally& other);

    uint64_t rays() const;
    /// Those with a verdict on the engine: all but the unjudged and unchecked ones.
    uint64_t judged() const;
    /// missed + false_hit + wrong_primitive.
    uint64_t wrong() const;
};

/// The fields of results.json that docs/compare.md lists, but for the time.
nlohmann::ordered_json to_json(const Tally& tally);

/// Distance of `t` from the exact one, in ulps of a float at the exact one.
double ulps_between(float t, double exact);

/// True where a hit lies within 32 ulps of the origin's largest coordinate: that is what a ray
/// looks like which meets the surface again that it left.
bool is_self_hit(const Ray& ray, const Hit& hit);

/// The probabilities that 95 % confidence leaves open.
struct Interval {
    double low, high;
};
/// Wilson's score interval behind `events` of `trials`; [0, 3/trials] where there are none.
Interval confidence(uint64_t events, uint64_t trials);

/// Events per million with that interval: "12 (8.12 to 17.3)"; "< 3/N" for none; "–" of nothing.
std::string per_million(uint64_t events, uint64_t trials);

}  // namespace sightline
