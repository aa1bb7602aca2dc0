#pragma once
// The stability atlas: runs every method on families of deliberately difficult rays and compares
// its answers with exact ones. docs/atlas.md is the manual.
#include "lab/atlas/families.h"

#include <optional>

namespace sightline {

struct AtlasOptions {
    std::vector<std::string> families;  ///< names, or prefixes of names (T: T1e to T7); empty: all
    std::vector<std::string> methods;   ///< empty: all
    size_t rays = 10000;                ///< for each knob value
    uint64_t seed = 1;
    int rounds = 3;  ///< of timing; the methods alternate
    bool show_progress = false;
    std::string dump = {};  ///< a folder for the scenes and rays; empty: none
    /// Names of other programs and the folders with their answers to dumped rays, as
    /// FAMILY-K.answers; knob values without such a file are left out.
    std::vector<std::pair<std::string, std::string>> answers = {};
};

/// Median, 99.9th percentile and maximum of finite values.
struct Summary {
    double median = 0, p999 = 0, max = 0;
};
std::optional<Summary> summary_of(std::vector<double> values);

/// The results of one method at one knob value.
struct MethodScore {
    std::string method;
    std::array<uint64_t, verdicts> by_verdict{};
    std::array<std::optional<Summary>, measure_fields.size()> measures;
    std::vector<double> ns_per_ray;              ///< one per round
    std::optional<double> instructions_per_ray;  ///< if the machine counts them
    uint64_t hash = 0;                           ///< of all hit ids and the bits of t
    uint64_t wrong = 0;  ///< refuted; without false hits if the family does not count them

    uint64_t count(Verdict verdict) const { return by_verdict[static_cast<size_t>(verdict)]; }
    /// Answers that are known to be right or wrong.
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
    /// The least knob value at which it missed a hit, which leaves a hole in a picture.
    std::optional<double> first_loss(const std::string& method) const;
};

/// Throws Error, with a list of all names, if a family or method is unknown.
void check_atlas_names(const AtlasOptions& options);

/// Runs the families. Throws Error as check_atlas_names does.
std::vector<FamilyScore> run_atlas(const AtlasOptions& options);

/// Whether the method is one of the project's own, which must never be wrong.
bool is_best_method(const std::string& method);

/// The intersector that renders use.
inline constexpr const char* production_method = "embree";

/// The production method's largest fraction of wrong answers, among decidable ones, at any knob
/// value.
double worst_of_production(const std::vector<FamilyScore>& scores);

}  // namespace sightline
