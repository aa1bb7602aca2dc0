#pragma once
// Verdicts on methods in one family of the atlas, for tests of its findings.
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
    double wrong() {
        return rate({Verdict::missed, Verdict::false_hit, Verdict::wrong_primitive,
                     Verdict::wrong_t, Verdict::wrong_uv});
    }
};

/// The methods' scores at one knob value of a family, by name.
inline std::map<std::string, AtlasScore> scores_at(const std::string& family, double knob,
                                                   const std::vector<std::string>& methods,
                                                   size_t rays) {
    const Experiment experiment = family_named(family).make({knob, rays, 11});
    std::map<std::string, AtlasScore> result;
    for (const std::string& method : methods) {
        AtlasScore& score = result[method];
        score.answers = experiment.size;
        std::vector<double> gaps;
        const MethodRun run = experiment.prepare(method);
        run.run();
        for (size_t i = 0; i < experiment.size; ++i) {
            const MethodAnswer answer = run.answer(i);
            const Verdict verdict = experiment.verdict(i, answer);
            ++score.verdicts[verdict];
            if (verdict == Verdict::same) gaps.push_back(experiment.measure(i, answer).gap);
        }
        if (const auto summary = summary_of(gaps)) score.median_gap = summary->median;
    }
    return result;
}

}  // namespace sightline
