#pragma once
// Counts of the referee's verdicts, quantiles and confidence intervals.
#include "exact/referee.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <optional>

namespace sightline {

/// A histogram of numbers ≥ 0 for quantiles with a relative error of at most 1/16. The result does
/// not depend on the order of the numbers.
class Quantiles {
  public:
    void add(double value);
    void add(const Quantiles& other);

    uint64_t count() const { return count_; }
    double max() const { return max_; }
    /// An upper bound of the quantile `p`, p in (0,1]; 0 if there are no numbers.
    double at(double p) const;

  private:
    std::vector<uint64_t> bins_;
    uint64_t count_ = 0;
    double max_ = 0;
};

/// Verdicts on an engine's answers for a set of rays.
struct Tally {
    std::array<uint64_t, verdicts> by_verdict{};  ///< indexed by Verdict
    uint64_t unchecked = 0;  ///< not judged: engines agreed, and compare judges a sample only
    uint64_t self_hits = 0;  ///< hits with is_self_hit, in addition to their verdicts
    Quantiles t_ulps;        ///< |t − exact t| in ulps of a float, for the verdicts same and tie

    uint64_t operator[](Verdict v) const { return by_verdict[static_cast<size_t>(v)]; }
    void count(Verdict v) { ++by_verdict[static_cast<size_t>(v)]; }
    void add(const Tally& other);

    uint64_t rays() const;
    /// All rays except the unjudged and unchecked ones.
    uint64_t judged() const;
    /// missed + false_hit + wrong_primitive.
    uint64_t wrong() const;
};

/// The fields of results.json that docs/compare.md lists, except the times.
nlohmann::ordered_json to_json(const Tally& tally);

/// |t − exact| in ulps of a float at `exact`.
double ulps_between(float t, double exact);

/// True if a hit lies within 32 ulps of the origin's largest coordinate, as when a ray hits again
/// the surface that it has left.
bool is_self_hit(const Ray& ray, const Hit& hit);

/// A confidence interval of a probability, 95 %.
struct Interval {
    double low, high;
};
/// Wilson's score interval (Wilson 1927) for `events` of `trials`; [0, 3/trials] for no event.
Interval confidence_interval(uint64_t events, uint64_t trials);

/// Events per million with their interval: "12 (8.12 to 17.3)"; "< 3/N" for none of N; "–" for
/// no trials.
std::string per_million(uint64_t events, uint64_t trials);

}  // namespace sightline
