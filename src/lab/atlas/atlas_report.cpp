#include "lab/atlas/atlas_report.h"

#include "core/version.h"
#include "intersect/bvh/traversal_kernel.h"
#include "intersect/embree/embree.h"
#include "lab/charts.h"
#include "lab/machine.h"
#include "lab/tally.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>

namespace sightline {

/// The contents of atlas_report.html, embedded by the build.
extern const char* const atlas_report_html;

namespace {

using Json = nlohmann::ordered_json;

std::array<Verdict, verdicts> all_verdicts() {
    std::array<Verdict, verdicts> all;
    for (size_t i = 0; i < verdicts; ++i) all[i] = static_cast<Verdict>(i);
    return all;
}

/// JSON lacks infinity, which is the knob value of a flat box.
Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(value > 0 ? "inf" : "nan");
}

Json to_json(const Summary& s) {
    return {{"median", number(s.median)}, {"p999", number(s.p999)}, {"max", number(s.max)}};
}

Json time_json(std::vector<double> ns) {
    std::sort(ns.begin(), ns.end());
    return {{"median", ns[ns.size() / 2]}, {"min", ns.front()}, {"max", ns.back()}};
}

Json to_json(const MethodScore& score) {
    Json json = {{"name", score.method}};
    for (const Verdict v : all_verdicts()) json[std::string(name_of(v))] = score.count(v);
    json["wrong"] = score.wrong;
    json["decidable"] = score.decidable();
    json["wrong_at_most"] = confidence_interval(score.wrong, score.decidable()).high;
    if (!score.ns_per_ray.empty()) json["ns_per_ray"] = time_json(score.ns_per_ray);
    if (score.instructions_per_ray) json["instructions_per_ray"] = *score.instructions_per_ray;
    for (size_t m = 0; m < measure_fields.size(); ++m)
        if (score.measures[m])
            json[std::string(measure_fields[m].name)] = to_json(*score.measures[m]);
    json["hash"] = fmt::format("{:016x}", score.hash);
    return json;
}

std::string label(const KnobValue& knob) {
    return knob.label.empty() ? fmt::format("{:g}", knob.value) : knob.label;
}

Json to_json(const KnobScore& score) {
    Json json = {{"value", number(score.knob.value)},
                 {"label", label(score.knob)},
                 {"rays", score.rays},
                 {"hits", score.hits},
                 {"undecidable_truths", score.undecidable_truths}};
    if (score.condition) json["condition"] = to_json(*score.condition);
    json["methods"] = Json::array();
    for (const MethodScore& method : score.methods) json["methods"].push_back(to_json(method));
    return json;
}

std::vector<std::string> methods_of(const FamilyScore& family) {
    std::vector<std::string> names;
    if (!family.knobs.empty())
        for (const MethodScore& method : family.knobs.front().methods)
            names.push_back(method.method);
    return names;
}

/// Adds "breakdown" and "first_loss" of every method to the family's object.
void add_limits(Json& json, const FamilyScore& family) {
    const auto limit = [](std::optional<double> knob) {
        return knob ? number(*knob) : Json(nullptr);
    };
    for (const std::string& method : methods_of(family)) {
        json["breakdown"][method] = limit(family.breakdown(method));
        json["first_loss"][method] = limit(family.first_loss(method));
    }
}

std::vector<std::string> all_methods(const std::vector<FamilyScore>& scores) {
    std::vector<std::string> names;
    for (const FamilyScore& family : scores)
        for (const std::string& name : methods_of(family))
            if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    return names;
}

/// Groups of families with the same methods, identified by the first one: one table each.
std::vector<std::vector<FamilyScore>> group_by_methods(const std::vector<FamilyScore>& scores) {
    std::vector<std::vector<FamilyScore>> groups;
    const auto first = [](const FamilyScore& family) {
        const auto methods = methods_of(family);
        return methods.empty() ? std::string() : methods.front();
    };
    for (const FamilyScore& family : scores) {
        const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& g) {
            return first(g.front()) == first(family);
        });
        (group == groups.end() ? groups.emplace_back() : *group).push_back(family);
    }
    return groups;
}

/// A cell of the terminal's table: the breakdown, or "-" if there is none; empty if the method
/// does not apply.
std::string cell(const FamilyScore& family, const std::string& method) {
    const auto methods = methods_of(family);
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) return "";
    const auto limit = family.breakdown(method);
    if (!limit) return "-";
    for (const KnobScore& knob : family.knobs)
        if (knob.knob.value == *limit) return label(knob.knob);
    return fmt::format("{:g}", *limit);
}

std::string make_table(const std::vector<FamilyScore>& families) {
    const auto names = all_methods(families);
    std::vector<std::vector<std::string>> columns = {{""}};
    columns[0].insert(columns[0].end(), names.begin(), names.end());
    for (const FamilyScore& family : families) {
        columns.push_back({std::string(family.family->name)});
        for (const std::string& name : names) columns.back().push_back(cell(family, name));
    }
    std::string table;
    for (size_t row = 0; row <= names.size(); ++row) {
        for (const auto& column : columns) {
            size_t width = 4;
            for (const std::string& text : column) width = std::max(width, text.size());
            table += fmt::format("{:<{}}  ", column[row], width);
        }
        table.erase(table.find_last_not_of(' ') + 1);
        table += '\n';
    }
    return table;
}

/// One line for each family, knob value and method, with a line of names before.
std::string make_csv(const std::vector<FamilyScore>& scores) {
    std::string csv = "family,knob,label,method,rays,hits";
    for (const Verdict v : all_verdicts()) csv += fmt::format(",{}", name_of(v));
    csv += ",wrong,decidable,ns_per_ray";
    for (const MeasureField& field : measure_fields)
        csv += fmt::format(",{0}_median,{0}_p999,{0}_max", field.name);
    csv += '\n';
    for (const FamilyScore& family : scores)
        for (const KnobScore& knob : family.knobs)
            for (const MethodScore& m : knob.methods) {
                csv += fmt::format("{},{:g},{},{},{},{}", family.family->name, knob.knob.value,
                                   label(knob.knob), m.method, knob.rays, knob.hits);
                for (const Verdict v : all_verdicts()) csv += fmt::format(",{}", m.count(v));
                csv += fmt::format(",{},{},", m.wrong, m.decidable());
                if (!m.ns_per_ray.empty())
                    csv += fmt::format("{:.4g}", time_json(m.ns_per_ray)["median"].get<double>());
                for (const auto& s : m.measures)
                    csv += s ? fmt::format(",{:.6g},{:.6g},{:.6g}", s->median, s->p999, s->max)
                             : ",,,";
                csv += '\n';
            }
    return csv;
}

/// Answers of one method, summed over knob values.
struct MethodSum {
    uint64_t wrong = 0, decidable = 0, missed = 0;
    double log_ns = 0;
    uint64_t timed = 0;

    void add(const MethodScore& score) {
        wrong += score.wrong;
        decidable += score.decidable();
        missed += score.count(Verdict::missed);
        if (score.ns_per_ray.empty()) return;
        log_ns += std::log(time_json(score.ns_per_ray)["median"].get<double>());
        ++timed;
    }
    double mean_ns() const { return std::exp(log_ns / static_cast<double>(timed)); }
};

std::string what_was_asked(const std::vector<FamilyScore>& scores, const AtlasOptions& options) {
    size_t knobs = 0;
    for (const FamilyScore& family : scores) knobs += family.knobs.size();
    return fmt::format(
        "{} methods answered {} kinds of deliberately difficult questions at {} degrees of "
        "difficulty, with {} rays each, and every answer was judged by exact arithmetic.",
        all_methods(scores).size(), scores.size(), knobs, grouped(options.rays));
}

std::string who_is_right(const std::vector<FamilyScore>& scores) {
    MethodSum best, production;
    size_t wrong_families = 0, lossy_families = 0, asked = 0;
    double worst = -1;
    std::string worst_family;
    for (const FamilyScore& family : scores) {
        MethodSum in_family;
        for (const KnobScore& knob : family.knobs)
            for (const MethodScore& method : knob.methods) {
                if (is_best_method(method.method)) best.add(method);
                if (method.method != production_method) continue;
                in_family.add(method);
                const double rate = static_cast<double>(method.wrong) /
                                    std::max(1.0, static_cast<double>(method.decidable()));
                if (rate <= worst) continue;
                worst = rate;
                const double value = knob.knob.value;
                const bool whole = knob.knob.label.empty() && value >= 1 && value < 1e12;
                worst_family =
                    fmt::format("{}, {} {}", family.family->title, family.family->knob,
                                whole ? grouped(static_cast<uint64_t>(value)) : label(knob.knob));
            }
        asked += in_family.decidable > 0;
        wrong_families += in_family.wrong > 0;
        lossy_families += in_family.missed > 0;
        production.wrong += in_family.wrong;
    }
    std::string text = fmt::format(
        "Sightline's own methods are wrong on {} of {} answers that "
        "floats can decide",
        best.wrong == 0 ? "none" : grouped(best.wrong), grouped(best.decidable));
    if (asked == 0) return text + ".";
    if (production.wrong == 0)
        return text + fmt::format("; so is Embree as renders use it ({}).", production_method);
    return text + fmt::format(
                      "; Embree as renders use it ({}) is wrong in {} of {} kinds and "
                      "misses hits in {}, at worst wrong on {} per million ({}).",
                      production_method, wrong_families, asked, lossy_families,
                      per_million({worst, {worst, worst}}), worst_family);
}

/// Among the methods for whole scenes of triangles, by the mean of the logarithms.
std::string who_is_fastest(const std::vector<FamilyScore>& scores) {
    std::map<std::string, MethodSum> sums;
    for (const FamilyScore& family : scores)
        if (family.family->name.starts_with("T") || family.family->name == "X1")
            for (const KnobScore& knob : family.knobs)
                for (const MethodScore& method : knob.methods) sums[method.method].add(method);
    const std::pair<const std::string, MethodSum>*fastest = nullptr, *right = nullptr;
    for (const auto& entry : sums) {
        if (entry.second.timed == 0) continue;
        const double ns = entry.second.mean_ns();
        if (!fastest || ns < fastest->second.mean_ns()) fastest = &entry;
        if (entry.second.wrong == 0 && (!right || ns < right->second.mean_ns())) right = &entry;
    }
    if (!fastest) return "No method for triangles was timed.";
    std::string text = fmt::format("On triangles, {} is the fastest with {:.0f} ns a ray",
                                   fastest->first, fastest->second.mean_ns());
    if (!right) return text + "; each method is wrong somewhere.";
    if (right == fastest) return text + " and never wrong.";
    return text + fmt::format(", and {} the fastest that is never wrong with {:.0f} ns.",
                              right->first, right->second.mean_ns());
}

std::string compiler() {
#if defined(__clang__)
    return "clang " __clang_version__;
#else
    return "gcc " __VERSION__;
#endif
}

Json provenance(const AtlasOptions& options) {
    return {{"program", program_version},
            {"seed", options.seed},
            {"rays", options.rays},
            {"isa", vector_target()},
            {"embree", make_embree(Scene())->description()},
            {"compiler", compiler()},
            {"flags", "-ffp-contract=off -fno-math-errno -fno-trapping-math"}};
}

}  // namespace

Json atlas_json(const std::vector<FamilyScore>& scores, const AtlasOptions& options,
                double max_wrong) {
    Json json = {{"format", "sightline-atlas"}, {"version", 1}};
    json.update(provenance(options));
    json["rounds"] = options.rounds;
    json["machine"] = machine_json();
    json["summary"] = {what_was_asked(scores, options), who_is_right(scores),
                       who_is_fastest(scores)};
    json["production"] = {{"method", production_method},
                          {"worst_fraction", worst_of_production(scores)},
                          {"max_wrong", max_wrong}};
    json["methods"] = Json::array();
    for (const std::string& name : all_methods(scores))
        json["methods"].push_back(
            {{"name", name},
             {"precision", name.ends_with("-double") || name == "analytic" ? "double" : "float"},
             {"best", is_best_method(name)}});
    json["families"] = Json::array();
    for (const FamilyScore& score : scores) {
        Json family = {{"name", score.family->name},
                       {"title", score.family->title},
                       {"knob", score.family->knob}};
        add_limits(family, score);
        family["knobs"] = Json::array();
        for (const KnobScore& knob : score.knobs) family["knobs"].push_back(to_json(knob));
        json["families"].push_back(std::move(family));
    }
    return json;
}

Json atlas_breakdown(const std::vector<FamilyScore>& scores, const AtlasOptions& options) {
    Json json = {{"format", "sightline-breakdown"}, {"version", 1}};
    json.update(provenance(options));
    for (const FamilyScore& score : scores) {
        Json& family = json["families"][score.family->name];
        family = {{"knob", score.family->knob}, {"largest", number(score.knobs.back().knob.value)}};
        add_limits(family, score);
    }
    return json;
}

void write_atlas(const std::string& folder, const std::vector<FamilyScore>& scores,
                 const AtlasOptions& options, double max_wrong) {
    const Json results = atlas_json(scores, options, max_wrong);
    write_report(folder, {.results = results.dump(1),
                          .csv = make_csv(scores),
                          .page = atlas_report_html,
                          .data = results});
}

std::string atlas_table(const std::vector<FamilyScore>& scores) {
    std::string text = "Smallest knob value at which each method gives a wrong answer; -: none\n";
    for (const std::vector<FamilyScore>& group : group_by_methods(scores))
        text += '\n' + make_table(group);
    return text;
}

}  // namespace sightline
