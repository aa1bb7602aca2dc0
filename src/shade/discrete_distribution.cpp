#include "shade/discrete_distribution.h"

#include <algorithm>

namespace sightline {

DiscreteDistribution::DiscreteDistribution(std::span<const double> weights) {
    double sum = 0;
    cumulative_.reserve(weights.size());
    for (const double weight : weights) cumulative_.push_back(sum += weight);
    for (double& c : cumulative_) c /= sum;
    uint32_t index = 0;
    guide_.reserve(weights.size());
    for (size_t part = 0; part < weights.size(); ++part) {
        const double begin = static_cast<double>(part) / static_cast<double>(weights.size());
        while (index + 1 < weights.size() && cumulative_[index] <= begin) ++index;
        guide_.push_back(index);
    }
}

double DiscreteDistribution::probability(size_t index) const {
    return cumulative_[index] - (index > 0 ? cumulative_[index - 1] : 0);
}

size_t DiscreteDistribution::sample(double& u) const {
    const auto part = static_cast<size_t>(u * static_cast<double>(guide_.size()));
    size_t index = guide_[std::min(part, guide_.size() - 1)];
    while (index + 1 < cumulative_.size() && cumulative_[index] <= u) ++index;
    // The product may have been rounded up to the next part.
    while (index > 0 && cumulative_[index - 1] > u) --index;
    const double begin = index > 0 ? cumulative_[index - 1] : 0;
    u = std::min((u - begin) / (cumulative_[index] - begin), 1 - 0x1p-53);
    return index;
}

}  // namespace sightline
