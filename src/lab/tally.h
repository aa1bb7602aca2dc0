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

/// A confidence interval of a probability, 95 %.
struct Interval {
    double low, high;
};
/// Wilson's score interval (Wilson 1927) for `events` of `trials`; [0, 3/trials] for no event.
Interval confidence_interval(uint64_t events, uint64_t trials);

/// A share of rays: the estimate, and its confidence interval if it comes from a sample.
struct Rate {
    double estimate = 0;
    Interval bounds{0, 1};
};

/// Verdicts on an engine's answers for a set of rays.
struct Tally {
    std::array<uint64_t, verdicts> by_verdict{};  ///< indexed by Verdict
    uint64_t unchecked = 0;  ///< not judged: engines agreed, and compare judges a sample only
    /// The sample of the rays on which engines agreed, and how many of them are wrong: it stands
    /// for the unchecked ones, too.
    uint64_t sampled = 0, sampled_wrong = 0;
    uint64_t left_out = 0;   ///< wrong answers about a surface that Intersector::leaves_out
    uint64_t self_hits = 0;  ///< hits with is_self_hit, in addition to their verdicts
    Quantiles t_ulps;        ///< |t − exact t| in ulps of a float, for the verdicts same and tie

    uint64_t operator[](Verdict v) const { return by_verdict[static_cast<size_t>(v)]; }
    void count(Verdict v) { ++by_verdict[static_cast<size_t>(v)]; }
    void add(const Tally& other);

    uint64_t rays() const;
    /// All rays except the unjudged and unchecked ones.
    uint64_t judged() const;
    /// Those for which is_wrong is true.
    uint64_t wrong() const;
    /// The share of wrong answers among all rays but the unjudged ones. Exact if every ray was
    /// checked; otherwise the rays on which engines agreed count as their sample does.
    Rate wrong_rate() const;
};

/// The fields of results.json that docs/compare.md lists, except the times.
nlohmann::ordered_json to_json(const Tally& tally);

/// |t − exact| in ulps of a float at `exact`.
double ulps_between(float t, double exact);

/// True if a hit lies within 32 ulps of the origin's largest coordinate, as when a ray hits again
/// the surface that it has left.
bool is_self_hit(const Ray& ray, const Hit& hit);
/// The largest t of such a hit.
float self_hit_reach(const Ray& ray);

/// The number with its digits grouped: "1,234,567".
std::string grouped(uint64_t n);

/// The rate per million, to three digits: "89,300", or with its interval "12 (8.1 to 17)".
std::string per_million(const Rate& rate);

}  // namespace sightline
