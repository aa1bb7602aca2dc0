#include "lab/atlas/atlas.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "exact/arithmetic.h"
#include "lab/instructions.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <set>

namespace sightline {
namespace {

/// Truths whose neighbourhood is looked at, for each knob value.
constexpr size_t decidability_sample = 250;

std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

std::vector<const Family*> chosen_families(const std::vector<std::string>& names) {
    std::vector<std::string> known;
    for (const Family& family : atlas_families()) known.push_back(family.name);
    for (const std::string& name : names)
        if (name.empty() || std::none_of(known.begin(), known.end(),
                                         [&](const std::string& k) { return k.starts_with(name); }))
            throw Error("unknown family '" + name + "'; there are " + joined(known));
    std::vector<const Family*> result;
    for (const Family& family : atlas_families())
        if (names.empty() || std::any_of(names.begin(), names.end(), [&](const std::string& name) {
                return family.name.starts_with(name);
            }))
            result.push_back(&family);
    return result;
}

void check_methods(const std::vector<std::string>& names) {
    std::vector<std::string> known;
    for (const Family& family : atlas_families())
        for (const std::string& method : family.methods)
            if (std::find(known.begin(), known.end(), method) == known.end())
                known.push_back(method);
    for (const std::string& name : names)
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw Error("unknown method '" + name + "'; there are " + joined(known));
}

std::vector<std::string> chosen_methods(const Family& family,
                                        const std::vector<std::string>& names) {
    if (names.empty()) return family.methods;
    std::vector<std::string> result;
    for (const std::string& method : family.methods)
        if (std::find(names.begin(), names.end(), method) != names.end()) result.push_back(method);
    return result;
}

double seconds_of(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

uint64_t hash_of(const MethodAnswer& answer, uint64_t seed) {
    const std::array<uint64_t, 3> words = {
        uint64_t{answer.hit.instance} << 32 | answer.hit.geometry,
        uint64_t{answer.hit.primitive} << 32 | static_cast<uint32_t>(answer.count),
        std::bit_cast<uint64_t>(answer.t)};
    return hash_bytes(std::as_bytes(std::span(words)), seed);
}

MethodScore score(const Trial& trial, const Entrant& entrant) {
    MethodScore result;
    result.method = entrant.method;
    const size_t n = trial.size();
    std::vector<Verdict> answers(n);
    std::vector<Measures> measures(n);
    parallel_for(n, [&](size_t i) {
        const MethodAnswer answer = entrant.answer(i);
        answers[i] = trial.judge(i, answer);
        const bool right = answers[i] == Verdict::same || answers[i] == Verdict::tie;
        measures[i] = right ? trial.measure(i, answer) : no_measures;
    });
    for (size_t i = 0; i < n; ++i) {
        ++result.by_verdict[static_cast<size_t>(answers[i])];
        result.hash = hash_of(entrant.answer(i), result.hash);
    }
    for (size_t m = 0; m < measure_names.size(); ++m) {
        std::vector<double> values(n);
        for (size_t i = 0; i < n; ++i) values[i] = measures[i][m];
        result.measures[m] = summary_of(std::move(values));
    }
    return result;
}

void describe_truth(const Trial& trial, KnobScore& result) {
    const size_t n = trial.size(), step = std::max<size_t>(1, n / decidability_sample);
    result.rays = n;
    std::vector<double> conditions(n);
    for (size_t i = 0; i < n; ++i) {
        result.hits += trial.hits(i);
        conditions[i] = trial.condition(i);
    }
    result.condition = summary_of(std::move(conditions));
    std::vector<uint8_t> doubtful((n + step - 1) / step);
    parallel_for(doubtful.size(), [&](size_t i) { doubtful[i] = !trial.decidable(i * step); });
    const auto count = std::count(doubtful.begin(), doubtful.end(), 1);
    if (n > 0)
        result.undecidable_truths =
            static_cast<double>(count) / static_cast<double>(doubtful.size());
}

KnobScore run_trial(const Family& family, Trial& trial, const std::vector<std::string>& methods,
                    int rounds) {
    KnobScore result;
    describe_truth(trial, result);
    const std::vector<Entrant> entrants = trial.entrants(methods);
    const auto rays = static_cast<double>(std::max<size_t>(1, trial.size()));
    std::vector<std::vector<double>> times(entrants.size());
    std::vector<std::optional<double>> instructions(entrants.size());
    for (int round = 0; round < rounds; ++round)
        for (size_t i = 0; i < entrants.size(); ++i) {
            const auto before = thread_instructions();
            times[i].push_back(1e9 * seconds_of(entrants[i].run) / rays);
            if (before)
                instructions[i] = static_cast<double>(*thread_instructions() - *before) / rays;
        }
    for (size_t i = 0; i < entrants.size(); ++i) {
        MethodScore& method = result.methods.emplace_back(score(trial, entrants[i]));
        method.ns_per_ray = times[i];
        method.instructions_per_ray = instructions[i];
        method.wrong = method.count(Verdict::missed) + method.count(Verdict::wrong_primitive);
        if (family.false_hits_are_wrong) method.wrong += method.count(Verdict::false_hit);
    }
    return result;
}

/// The least knob value at which the method's score is as asked for.
template <class Predicate>
std::optional<double> first_knob(const FamilyScore& family, const std::string& method,
                                 const Predicate& wanted) {
    for (const KnobScore& knob : family.knobs)
        for (const MethodScore& score : knob.methods)
            if (score.method == method && wanted(score)) return knob.knob.value;
    return std::nullopt;
}

}  // namespace

std::optional<Summary> summary_of(std::vector<double> values) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    if (values.empty()) return std::nullopt;
    std::sort(values.begin(), values.end());
    const auto at = [&](double q) {
        return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1))];
    };
    return Summary{at(0.5), at(0.999), values.back()};
}

uint64_t MethodScore::decidable() const {
    uint64_t sum = 0;
    for (const uint64_t n : by_verdict) sum += n;
    return sum - count(Verdict::undecidable) - count(Verdict::unjudged);
}

std::optional<double> FamilyScore::breakdown(const std::string& method) const {
    return first_knob(*this, method, [](const MethodScore& s) { return s.wrong > 0; });
}

std::optional<double> FamilyScore::first_loss(const std::string& method) const {
    return first_knob(*this, method,
                      [](const MethodScore& s) { return s.count(Verdict::missed) > 0; });
}

std::vector<FamilyScore> run_atlas(const AtlasOptions& options) {
    check_arithmetic();
    check_methods(options.methods);
    const auto families = chosen_families(options.families);
    size_t steps = 0;
    for (const Family* family : families)
        steps += chosen_methods(*family, options.methods).empty() ? 0 : family->values.size();
    Progress progress("atlas", steps, options.show_progress);
    std::vector<FamilyScore> scores;
    for (const Family* family : families) {
        const auto methods = chosen_methods(*family, options.methods);
        if (methods.empty()) continue;
        FamilyScore& score = scores.emplace_back(FamilyScore{family, {}});
        // The same numbers at every knob value: what differs is the knob.
        const uint64_t seed = hash_text(family->name, options.seed);
        for (const KnobValue& knob : family->values) {
            const auto trial = family->make({knob.value, options.rays, seed});
            score.knobs.push_back(run_trial(*family, *trial, methods, options.rounds));
            score.knobs.back().knob = knob;
            progress.advance();
        }
    }
    return scores;
}

bool is_best_method(const std::string& method) {
    static const std::set<std::string> best = {"exact",
                                               "analytic",
                                               "parity",
                                               "box-conservative",
                                               "box-conservative-double",
                                               "offset-bound",
                                               "nodes-baked",
                                               "nodes-instanced"};
    return best.contains(method);
}

double worst_of_production(const std::vector<FamilyScore>& scores) {
    double worst = 0;
    for (const FamilyScore& family : scores)
        for (const KnobScore& knob : family.knobs)
            for (const MethodScore& score : knob.methods)
                if (score.method == production_method && score.decidable() > 0)
                    worst = std::max(worst, static_cast<double>(score.wrong) /
                                                static_cast<double>(score.decidable()));
    return worst;
}

}  // namespace sightline
