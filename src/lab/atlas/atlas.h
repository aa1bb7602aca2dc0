#pragma once
// The stability atlas: families of rays that are hard on purpose, each with a knob of difficulty
// and an exact answer to every ray; what each method makes of them. docs/atlas.md is the manual.
#include "lab/atlas/trial.h"

#include <optional>
#include <span>

namespace sightline {

struct KnobValue {
    double value;
    std::string label = {};  ///< empty: the number
};

/// What a trial is made of.
struct TrialRequest {
    double knob;
    size_t rays;
    uint64_t seed;
};

/// One way to be difficult. Its knob grows with the difficulty.
struct Family {
    std::string name, title;
    std::string knob;  ///< what the knob is
    std::vector<KnobValue> values;
    std::vector<std::string> methods;  ///< that can be asked
    std::function<std::unique_ptr<Trial>(const TrialRequest&)> make;
    bool false_hits_are_wrong = true;  ///< a box that is entered in vain costs time only
};

/// All families, in the order of the documentation.
const std::vector<Family>& atlas_families();

struct AtlasOptions {
    std::vector<std::string>
        families;  ///< names, or beginnings of names (T: all of T1e …); none: all
    std::vector<std::string> methods;  ///< none: all
    size_t rays = 10000;               ///< for each knob value
    uint64_t seed = 1;
    int rounds = 3;  ///< of timing; the methods take turns
    bool show_progress = false;
};

/// Median, 99.9th percentile and maximum of finite values.
struct Summary {
    double median = 0, p999 = 0, max = 0;
};
std::optional<Summary> summary_of(std::vector<double> values);

/// What one method did at one knob value.
struct MethodScore {
    std::string method;
    std::array<uint64_t, verdicts> by_verdict{};
    std::array<std::optional<Summary>, measure_names.size()> measures;
    std::vector<double> ns_per_ray;              ///< one each round
    std::optional<double> instructions_per_ray;  ///< where they can be counted
    uint64_t hash = 0;                           ///< of all decisions and the bits of t

    uint64_t wrong = 0;  ///< missed, wrong primitives and, where they matter, false hits

    uint64_t count(Verdict verdict) const { return by_verdict[static_cast<size_t>(verdict)]; }
    /// Answers that could be told right from wrong.
    uint64_t decidable() const;
};

struct KnobScore {
    KnobValue knob;
    size_t rays = 0, hits = 0;
    double undecidable_truths = 0;  ///< fraction, from a sample
    std::optional<Summary> condition;
    std::vector<MethodScore> methods;
};

struct FamilyScore {
    const Family* family;
    std::vector<KnobScore> knobs;

    /// The least knob value at which the method was wrong.
    std::optional<double> breakdown(const std::string& method) const;
    /// The least knob value at which it lost a hit: what makes holes.
    std::optional<double> first_loss(const std::string& method) const;
};

/// Runs the families. Throws Error: a name that does not exist (all names are listed).
std::vector<FamilyScore> run_atlas(const AtlasOptions& options);

/// Whether the method is one of ours that must never be wrong.
bool is_best_method(const std::string& method);

/// The intersector that renders use.
inline constexpr const char* production_method = "embree";

/// The largest fraction of wrong answers among decidable ones that the production intersector gave
/// at any knob value.
double worst_of_production(const std::vector<FamilyScore>& scores);

}  // namespace sightline
