#include "lab/tally.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

namespace sightline {
namespace {

// A bin is a float's exponent and the first four bits of its fraction.
constexpr uint32_t bin_shift = 19;

}  // namespace

void Quantiles::add(double value) {
    const auto rounded = static_cast<float>(value);
    const size_t bin =
        std::bit_cast<uint32_t>(std::isnan(rounded) ? INFINITY : rounded) >> bin_shift;
    if (bin >= bins_.size()) bins_.resize(bin + 1);
    ++bins_[bin];
    ++count_;
    max_ = std::max(max_, value);
}

void Quantiles::add(const Quantiles& other) {
    bins_.resize(std::max(bins_.size(), other.bins_.size()));
    for (size_t i = 0; i < other.bins_.size(); ++i) bins_[i] += other.bins_[i];
    count_ += other.count_;
    max_ = std::max(max_, other.max_);
}

double Quantiles::at(double p) const {
    uint64_t left = static_cast<uint64_t>(std::ceil(p * static_cast<double>(count_)));
    for (size_t i = 0; i < bins_.size(); ++i) {
        if (bins_[i] == 0) continue;
        if (left > bins_[i]) {
            left -= bins_[i];
            continue;
        }
        if (i == 0) return 0;
        const auto next = std::bit_cast<float>(static_cast<uint32_t>(i + 1) << bin_shift);
        return std::min(max_, static_cast<double>(next));
    }
    return max_;
}

void Tally::add(const Tally& other) {
    for (size_t i = 0; i < verdicts; ++i) by_verdict[i] += other.by_verdict[i];
    unchecked += other.unchecked;
    self_hits += other.self_hits;
    t_ulps.add(other.t_ulps);
}

uint64_t Tally::rays() const {
    uint64_t sum = unchecked;
    for (const uint64_t count : by_verdict) sum += count;
    return sum;
}

uint64_t Tally::judged() const { return rays() - unchecked - (*this)[Verdict::unjudged]; }

uint64_t Tally::wrong() const {
    return (*this)[Verdict::missed] + (*this)[Verdict::false_hit] +
           (*this)[Verdict::wrong_primitive];
}

nlohmann::ordered_json to_json(const Tally& tally) {
    nlohmann::ordered_json json = {{"rays", tally.rays()}};
    for (size_t i = 0; i < verdicts; ++i)
        json[std::string(name_of(static_cast<Verdict>(i)))] = tally.by_verdict[i];
    json["unchecked"] = tally.unchecked;
    json["wrong"] = tally.wrong();
    const Interval bounds = confidence_interval(tally.wrong(), tally.judged());
    json["wrong_per_million"] = {{"low", bounds.low * 1e6}, {"high", bounds.high * 1e6}};
    json["self_hit"] = tally.self_hits;
    if (tally.t_ulps.count() > 0)
        json["t_ulps"] = {{"median", tally.t_ulps.at(0.5)},
                          {"p999", tally.t_ulps.at(0.999)},
                          {"max", tally.t_ulps.max()}};
    else
        json["t_ulps"] = nullptr;
    return json;
}

double ulps_between(float t, double exact) {
    const auto rounded = static_cast<float>(exact);
    const double ulp =
        static_cast<double>(std::nextafter(rounded, INFINITY)) - static_cast<double>(rounded);
    return std::abs(static_cast<double>(t) - exact) / ulp;
}

bool is_self_hit(const Ray& ray, const Hit& hit) {
    if (!hit) return false;
    const float max_coordinate = max_abs_component(ray.origin);
    return hit.t * max_abs_component(ray.direction) <=
           32 * (std::nextafter(max_coordinate, INFINITY) - max_coordinate);
}

Interval confidence_interval(uint64_t events, uint64_t trials) {
    const auto n = static_cast<double>(trials), k = static_cast<double>(events);
    if (trials == 0) return {0, 1};
    if (events == 0) return {0, std::min(1.0, 3 / n)};
    constexpr double z = 1.96, z2 = z * z;
    const double centre = (k + z2 / 2) / (n + z2);
    const double half_width = z / (n + z2) * std::sqrt(k * (n - k) / n + z2 / 4);
    return {std::max(0.0, centre - half_width), std::min(1.0, centre + half_width)};
}

std::string per_million(uint64_t events, uint64_t trials) {
    if (trials == 0) return "–";
    if (events == 0) return fmt::format("< 3/{}", trials);
    const Interval bounds = confidence_interval(events, trials);
    return fmt::format("{:.3g} ({:.3g} to {:.3g})",
                       1e6 * static_cast<double>(events) / static_cast<double>(trials),
                       bounds.low * 1e6, bounds.high * 1e6);
}

}  // namespace sightline
