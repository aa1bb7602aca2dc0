#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

/// Picks indices with given probabilities, by inversion of the cumulative sum.
class DiscreteDistribution {
  public:
    DiscreteDistribution() = default;

    /// Probabilities in proportion to the weights, which are finite, not negative and not all 0.
    explicit DiscreteDistribution(std::span<const double> weights);

    bool empty() const { return cumulative_.empty(); }
    double probability(size_t index) const;

    /// The index at `u` in [0,1), never one of probability 0. Where `u` lies within the index's
    /// share of [0,1), scaled to [0,1), replaces it: it is uniform again.
    size_t sample(double& u) const;

  private:
    std::vector<double> cumulative_;
    // For i: the first index whose cumulative sum exceeds i / size (Chen & Asau 1974, "On
    // Generating Random Variates from an Empirical Distribution").
    std::vector<uint32_t> guide_;
};

}  // namespace sightline
