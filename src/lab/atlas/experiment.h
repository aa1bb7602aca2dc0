#pragma once
// Experiments of the atlas: cases of one problem, their exact answers and the methods that solve
// them.
#include "core/error.h"
#include "core/parallel.h"
#include "core/ray.h"
#include "exact/condition.h"
#include "exact/referee.h"

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace sightline {

/// A method's answer to one case.
struct MethodAnswer {
    Hit hit;        ///< in a problem without a scene: geometry is 0 for a hit, else `none`
    double t = 0;   ///< at the method's own precision
    int count = 0;  ///< number of roots, or a set of bits, in the problems that define it
};

/// An answer in a problem without a scene.
MethodAnswer answer_of(bool hit, double t = 0, int count = 0);

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// The error of a right answer; `not_measured` where a measure does not apply.
struct Measures {
    double t_ulps = not_measured;        ///< error of t, in float ulps of the exact t
    double backward = not_measured;      ///< distance from the surface, in float ulps of the
                                         ///< largest coordinate
    double stability = not_measured;     ///< error of t over what half an ulp of all inputs causes
    double normal_angle = not_measured;  ///< angle to the exact normal, radians
    double gap = not_measured;           ///< between a surface and a bounce's origin, world units
};

/// The measures by the names of results.json.
struct MeasureField {
    std::string_view name;
    double Measures::*value;
};
inline constexpr std::array<MeasureField, 5> measure_fields = {
    {{"t_ulps", &Measures::t_ulps},
     {"backward", &Measures::backward},
     {"stability", &Measures::stability},
     {"normal_angle", &Measures::normal_angle},
     {"gap", &Measures::gap}}};

/// A method prepared for the cases of an experiment, which must outlive it.
struct MethodRun {
    std::function<void()> run;                   ///< solves all cases; only this is timed
    std::function<MethodAnswer(size_t)> answer;  ///< to case i, after run()
};

/// A method that takes part in a problem.
template <class Case>
struct Method {
    std::string name;
    std::function<MethodRun(std::span<const Case>)> prepare;
};

/// A run that calls `solve(input)` for one input after another. `to_answer(input, result)` makes
/// the answer and is not timed.
template <class Inputs, class Solve, class ToAnswer>
MethodRun solve_each(Inputs inputs, Solve solve, ToAnswer to_answer) {
    using Result = decltype(solve(inputs[0]));
    struct State {
        Inputs inputs;
        Solve solve;
        std::unique_ptr<Result[]> results;
    };
    auto results = std::make_unique<Result[]>(inputs.size());
    const auto state =
        std::make_shared<State>(State{std::move(inputs), std::move(solve), std::move(results)});
    return {
        [state] {
            for (size_t i = 0; i < state->inputs.size(); ++i)
                state->results[i] = state->solve(state->inputs[i]);
        },
        [state, to_answer](size_t i) { return to_answer(state->inputs[i], state->results[i]); }};
}

/// A method that solves the cases as they are, one after another.
template <class Case, class Solve, class ToAnswer>
Method<Case> case_method(std::string name, Solve solve, ToAnswer to_answer) {
    return {std::move(name),
            [=](std::span<const Case> cases) { return solve_each(cases, solve, to_answer); }};
}

/// Verdict on an answer that is either hit or miss; a wrong one is undecidable if `excused()`.
template <class Excused>
Verdict hit_or_miss(const MethodAnswer& answer, bool truth, const Excused& excused) {
    if (bool(answer.hit) == truth) return Verdict::same;
    if (excused()) return Verdict::undecidable;
    return truth ? Verdict::missed : Verdict::false_hit;
}

/// A kind of question with an exact answer. The functions must be thread-safe for different cases.
template <class Case, class Truth>
struct Problem {
    std::vector<Method<Case>> methods;
    std::function<Truth(const Case&)> solve;  ///< exactly
    std::function<bool(const Truth&)> is_hit;
    /// False if moving one input by one float ulp changes the exact answer.
    std::function<bool(const Case&, const Truth&)> is_decidable = [](const Case&, const Truth&) {
        return true;
    };
    /// Componentwise relative condition number of the exact t with respect to all inputs.
    std::function<double(const Case&, const Truth&)> condition = [](const Case&, const Truth&) {
        return not_measured;
    };
    /// Of a right answer only.
    std::function<Measures(const Case&, const Truth&, const MethodAnswer&)> measure =
        [](const Case&, const Truth&, const MethodAnswer&) { return Measures(); };
    /// Default: hit_or_miss, excused where the case is not decidable.
    std::function<Verdict(const Case&, const Truth&, const MethodAnswer&)> verdict = nullptr;
};

/// The cases of a problem by index. Functions of an index may run in several threads at once, each
/// with an index of its own.
struct Experiment {
    size_t size = 0;
    std::vector<uint8_t> hits;       ///< 1 for each case whose exact answer is a hit
    std::vector<double> conditions;  ///< of each case
    /// Throws Error if there is no such method. The experiment must outlive the result.
    std::function<MethodRun(const std::string& method)> prepare;
    std::function<bool(size_t)> is_decidable;
    std::function<Measures(size_t, const MethodAnswer&)> measure;
    std::function<Verdict(size_t, const MethodAnswer&)> verdict;
    /// Where the cases are rays against a scene of triangles: writes STEM.triangles and STEM.rays
    /// (docs/engines.md), and replays answers to them. Throw Error.
    std::function<void(const std::string& stem)> dump = nullptr;
    std::function<MethodRun(const std::string& name, const std::string& path)> replay = nullptr;
};

/// Solves the cases exactly, on all threads.
template <class Case, class Truth>
Experiment make_experiment(Problem<Case, Truth> problem, std::vector<Case> cases) {
    struct Solved {
        Problem<Case, Truth> problem;
        std::vector<Case> cases;
        std::unique_ptr<Truth[]> truths;  // no vector: one of bool is not thread-safe
    };
    if (!problem.verdict)
        problem.verdict = [is_hit = problem.is_hit, is_decidable = problem.is_decidable](
                              const Case& c, const Truth& truth, const MethodAnswer& answer) {
            return hit_or_miss(answer, is_hit(truth), [&] { return !is_decidable(c, truth); });
        };
    const size_t size = cases.size();
    const auto s = std::make_shared<Solved>(
        Solved{std::move(problem), std::move(cases), std::make_unique<Truth[]>(size)});
    Experiment result;
    result.size = size;
    result.hits.resize(size);
    result.conditions.resize(size);
    parallel_for(size, [&](size_t i) {
        s->truths[i] = s->problem.solve(s->cases[i]);
        result.hits[i] = s->problem.is_hit(s->truths[i]);
        result.conditions[i] = s->problem.condition(s->cases[i], s->truths[i]);
    });
    result.prepare = [s](const std::string& name) {
        for (const Method<Case>& method : s->problem.methods)
            if (method.name == name) return method.prepare(s->cases);
        throw Error("unknown method '" + name + "'");
    };
    result.is_decidable = [s](size_t i) {
        return s->problem.is_decidable(s->cases[i], s->truths[i]);
    };
    result.measure = [s](size_t i, const MethodAnswer& answer) {
        return s->problem.measure(s->cases[i], s->truths[i], answer);
    };
    result.verdict = [s](size_t i, const MethodAnswer& answer) {
        return s->problem.verdict(s->cases[i], s->truths[i], answer);
    };
    return result;
}

/// The cases that differ from `c` by one float ulp in one number; `numbers(c)` returns pointers to
/// all of them.
template <class Case, class Numbers>
std::vector<Case> ulp_neighbours(Case c, const Numbers& numbers) {
    std::vector<Case> neighbours;
    for (float* number : numbers(c))
        for (const float end : {-INFINITY, INFINITY}) {
            const float original = *number;
            *number = std::nextafter(original, end);
            neighbours.push_back(c);
            *number = original;
        }
    return neighbours;
}

/// The point at which a ray crosses a surface, and its sensitivity to the inputs.
struct SurfaceCrossing {
    double t = not_measured;
    Vec3d normal;             ///< unit
    double normal_speed = 0;  ///< |normal · direction|: change of the height over the surface per t
    double input_sensitivity = 0;  ///< Σ |∂height/∂x| |x| over all inputs x
    double max_coordinate = 0;     ///< of the ray's origin and the point

    SurfaceCrossing() = default;
    /// `input_sensitivity` is that to the ray's origin and direction.
    SurfaceCrossing(const Ray& ray, double t, const Vec3d& unit_normal);

    double condition() const { return input_sensitivity / (normal_speed * std::abs(t)); }
    /// t_ulps, backward and stability.
    Measures measure(double measured_t) const;
    /// These and normal_angle; the other normal can have any length.
    Measures measure(double measured_t, const Vec3d& measured_normal) const;
};

/// In double.
Vec3d point_at(const Ray& ray, double t);

}  // namespace sightline
