#pragma once
// What methods do in one family of the atlas, for tests of its findings.
#include "core/error.h"
#include "lab/atlas/atlas.h"

#include <map>

namespace sightline {

inline const Family& family_named(const std::string& name) {
    for (const Family& family : atlas_families())
        if (family.name == name) return family;
    throw Error("no family " + name);
}

struct AtlasScore {
    std::map<Verdict, size_t> verdicts;
    size_t answers = 0;
    double median_gap = 0;

    double rate(std::initializer_list<Verdict> which) {
        size_t sum = 0;
        for (const Verdict v : which) sum += verdicts[v];
        return static_cast<double>(sum) / static_cast<double>(answers);
    }
    double lost() { return rate({Verdict::missed}); }
    double wrong() { return rate({Verdict::missed, Verdict::false_hit, Verdict::wrong_primitive}); }
};

/// What the methods do at one knob value of a family.
inline std::map<std::string, AtlasScore> scores_at(const std::string& family, double knob,
                                                   const std::vector<std::string>& methods,
                                                   size_t rays) {
    const auto trial = family_named(family).make({knob, rays, 11});
    std::map<std::string, AtlasScore> result;
    for (const Entrant& entrant : trial->entrants(methods)) {
        AtlasScore& score = result[entrant.method];
        score.answers = trial->size();
        std::vector<double> gaps;
        entrant.run();
        for (size_t i = 0; i < trial->size(); ++i) {
            const MethodAnswer answer = entrant.answer(i);
            const Verdict verdict = trial->judge(i, answer);
            ++score.verdicts[verdict];
            if (verdict != Verdict::same) continue;
            gaps.push_back(trial->measure(i, answer)[static_cast<size_t>(Measure::gap)]);
        }
        if (const auto summary = summary_of(gaps)) score.median_gap = summary->median;
    }
    return result;
}

}  // namespace sightline
