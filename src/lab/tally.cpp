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

/// A number ≥ 0 rounded to three digits, without an exponent: "0.0123", "12.3", "89,300".
std::string three_digits(double value) {
    if (value == 0) return "0";
    const int digits = static_cast<int>(std::floor(std::log10(value))) + 1;
    if (digits <= 3) return fmt::format("{:.{}f}", value, 3 - digits);
    const double unit = std::pow(10.0, digits - 3);
    return grouped(static_cast<uint64_t>(std::round(value / unit) * unit));
}

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
    sampled += other.sampled;
    sampled_wrong += other.sampled_wrong;
    left_out += other.left_out;
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
    uint64_t sum = 0;
    for (size_t i = 0; i < verdicts; ++i)
        if (is_wrong(static_cast<Verdict>(i))) sum += by_verdict[i];
    return sum;
}

Rate Tally::wrong_rate() const {
    const auto population = static_cast<double>(judged() + unchecked);
    if (population == 0) return {};
    const auto known = static_cast<double>(wrong());
    if (unchecked == 0) return {known / population, {known / population, known / population}};
    // Two strata: rays on which engines differ, all checked, and the others.
    const auto certain = static_cast<double>(wrong() - sampled_wrong);
    const auto stratum = static_cast<double>(sampled + unchecked);
    const auto rate = [&](double share) { return (certain + share * stratum) / population; };
    const Interval share = confidence_interval(sampled_wrong, sampled);
    const double estimate =
        sampled == 0 ? 0 : static_cast<double>(sampled_wrong) / static_cast<double>(sampled);
    return {rate(estimate), {rate(share.low), rate(share.high)}};
}

nlohmann::ordered_json to_json(const Tally& tally) {
    nlohmann::ordered_json json = {{"rays", tally.rays()}};
    for (size_t i = 0; i < verdicts; ++i)
        json[std::string(name_of(static_cast<Verdict>(i)))] = tally.by_verdict[i];
    json["unchecked"] = tally.unchecked;
    json["wrong"] = tally.wrong();
    const Rate rate = tally.wrong_rate();
    json["wrong_per_million"] = {{"estimate", rate.estimate * 1e6},
                                 {"low", rate.bounds.low * 1e6},
                                 {"high", rate.bounds.high * 1e6}};
    json["left_out"] = tally.left_out;
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

bool is_self_hit(const Ray& ray, const Hit& hit) { return hit && hit.t <= self_hit_reach(ray); }

float self_hit_reach(const Ray& ray) {
    const float max_coordinate = max_abs_component(ray.origin);
    return 32 * (std::nextafter(max_coordinate, INFINITY) - max_coordinate) /
           max_abs_component(ray.direction);
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

std::string grouped(uint64_t n) {
    if (n < 1000) return fmt::format("{}", n);
    return fmt::format("{},{:03}", grouped(n / 1000), n % 1000);
}

std::string per_million(const Rate& rate) {
    const auto text = [](double share) { return three_digits(share * 1e6); };
    const auto& [low, high] = rate.bounds;
    if (low == high) return text(rate.estimate);
    return fmt::format("{} ({} to {})", text(rate.estimate), text(low), text(high));
}

}  // namespace sightline
