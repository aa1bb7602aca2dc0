#include "lab/atlas/atlas.h"
#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/suggest.h"
#include "exact/arithmetic.h"
#include "lab/instructions.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <filesystem>
#include <set>

namespace sightline {
namespace {

/// Cases per knob value of which `undecidable_truths` is computed.
constexpr size_t decidability_sample = 250;

std::vector<const Family*> chosen_families(const std::vector<std::string>& names) {
    const auto known = names_of(atlas_families());
    for (const std::string& name : names)
        if (name.empty() ||
            std::ranges::none_of(known, [&](const auto& k) { return k.starts_with(name); }))
            throw Error(
                fmt::format("unknown family '{}'; there are {}", name, fmt::join(known, ", ")));
    std::vector<const Family*> result;
    for (const Family& family : atlas_families())
        if (names.empty() || std::ranges::any_of(names, [&](const std::string& name) {
                return family.name.starts_with(name);
            }))
            result.push_back(&family);
    return result;
}

void check_methods(const std::vector<std::string>& names) {
    std::vector<std::string> known;
    for (const Family& family : atlas_families())
        for (const std::string& method : family.methods)
            if (std::ranges::count(known, method) == 0) known.push_back(method);
    for (const std::string& name : names)
        if (std::ranges::count(known, name) == 0)
            throw Error(fmt::format("unknown method '{}'; there are {}{}", name,
                                    fmt::join(known, ", "), did_you_mean(name, known)));
}

std::vector<std::string> chosen_methods(const Family& family,
                                        const std::vector<std::string>& names) {
    if (names.empty()) return family.methods;
    std::vector<std::string> result;
    for (const std::string& method : family.methods)
        if (std::ranges::count(names, method) > 0) result.push_back(method);
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

MethodScore score(const Experiment& experiment, const MethodRun& run) {
    MethodScore result;
    const size_t n = experiment.size;
    std::vector<Verdict> answers(n);
    std::vector<Measures> measures(n);
    parallel_for(n, [&](size_t i) {
        const MethodAnswer answer = run.answer(i);
        answers[i] = experiment.verdict(i, answer);
        if (answers[i] == Verdict::same || answers[i] == Verdict::tie)
            measures[i] = experiment.measure(i, answer);
    });
    for (size_t i = 0; i < n; ++i) {
        ++result.by_verdict[static_cast<size_t>(answers[i])];
        result.hash = hash_of(run.answer(i), result.hash);
    }
    for (size_t m = 0; m < measure_fields.size(); ++m) {
        std::vector<double> values(n);
        for (size_t i = 0; i < n; ++i) values[i] = measures[i].*measure_fields[m].value;
        result.measures[m] = summary_of(std::move(values));
    }
    return result;
}

/// The score without methods.
KnobScore describe_truth(const Experiment& experiment) {
    const size_t n = experiment.size, step = std::max<size_t>(1, n / decidability_sample);
    KnobScore result;
    result.rays = n;
    result.hits = static_cast<size_t>(std::ranges::count(experiment.hits, 1));
    result.condition = summary_of(experiment.conditions);
    std::vector<uint8_t> undecidable((n + step - 1) / step);
    parallel_for(undecidable.size(),
                 [&](size_t i) { undecidable[i] = !experiment.is_decidable(i * step); });
    const auto count = std::ranges::count(undecidable, 1);
    if (n > 0)
        result.undecidable_truths =
            static_cast<double>(count) / static_cast<double>(undecidable.size());
    return result;
}

/// The runs of the methods, and of the other programs that have answered. `stem` names the knob
/// value in file names; the names of programs that take part are appended to `methods`.
std::vector<MethodRun> prepare_runs(const Experiment& experiment, const std::string& stem,
                                    const AtlasOptions& options,
                                    std::vector<std::string>& methods) {
    std::vector<MethodRun> runs;
    for (const std::string& method : methods) runs.push_back(experiment.prepare(method));
    if (!experiment.replay) return runs;
    for (const auto& [name, folder] : options.answers) {
        const std::string path = folder + "/" + stem + ".answers";
        if (!std::filesystem::exists(path)) continue;
        runs.push_back(experiment.replay(name, path));
        methods.push_back(name);
    }
    return runs;
}

KnobScore run_experiment(const Family& family, const Experiment& experiment,
                         const std::string& stem, std::vector<std::string> methods,
                         const AtlasOptions& options) {
    KnobScore result = describe_truth(experiment);
    const std::vector<MethodRun> runs = prepare_runs(experiment, stem, options, methods);
    const auto rays = static_cast<double>(std::max<size_t>(1, experiment.size));
    std::vector<std::vector<double>> times(runs.size());
    std::vector<std::optional<double>> instructions(runs.size());
    for (int round = 0; round < options.rounds; ++round)
        for (size_t i = 0; i < runs.size(); ++i) {
            const auto before = thread_instructions();
            times[i].push_back(1e9 * seconds_of(runs[i].run) / rays);
            if (before)
                instructions[i] = static_cast<double>(*thread_instructions() - *before) / rays;
        }
    for (size_t i = 0; i < runs.size(); ++i) {
        MethodScore& method = result.methods.emplace_back(score(experiment, runs[i]));
        method.method = methods[i];
        method.ns_per_ray = times[i];
        method.instructions_per_ray = instructions[i];
        for (size_t v = 0; v < verdicts; ++v)
            if (is_wrong(static_cast<Verdict>(v))) method.wrong += method.by_verdict[v];
        if (!family.false_hits_are_wrong) method.wrong -= method.count(Verdict::false_hit);
    }
    return result;
}

/// The least knob value at which `predicate` is true for the method's score.
template <class Predicate>
std::optional<double> first_knob(const FamilyScore& family, const std::string& method,
                                 const Predicate& predicate) {
    for (const KnobScore& knob : family.knobs)
        for (const MethodScore& score : knob.methods)
            if (score.method == method && predicate(score)) return knob.knob.value;
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

void check_atlas_names(const AtlasOptions& options) {
    check_methods(options.methods);
    chosen_families(options.families);
}

std::vector<FamilyScore> run_atlas(const AtlasOptions& options) {
    check_arithmetic();
    check_methods(options.methods);
    const auto families = chosen_families(options.families);
    size_t steps = 0;
    for (const Family* family : families)
        steps += chosen_methods(*family, options.methods).empty() ? 0 : family->values.size();
    Progress progress("atlas", {}, steps, options.show_progress);
    std::vector<FamilyScore> scores;
    for (const Family* family : families) {
        const auto methods = chosen_methods(*family, options.methods);
        if (methods.empty()) continue;
        FamilyScore& score = scores.emplace_back(FamilyScore{family, {}});
        // The same random numbers at every knob value, so that only the knob differs.
        const uint64_t seed = hash_text(family->name, options.seed);
        for (const KnobValue& knob : family->values) {
            const Experiment experiment = family->make({knob.value, options.rays, seed});
            const std::string stem = fmt::format("{}-{}", family->name, score.knobs.size());
            if (!options.dump.empty() && experiment.dump)
                experiment.dump(options.dump + "/" + stem);
            score.knobs.push_back(run_experiment(*family, experiment, stem, methods, options));
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
