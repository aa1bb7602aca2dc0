#include "lab/atlas_report.h"

namespace sightline {
namespace {

// Self-contained: the results take the place of the comment DATA, drawings that of CHARTS.
constexpr const char* page = R"html(<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Sightline atlas</title>
<style>
:root { color-scheme: light dark; font: 14px/1.4 system-ui, sans-serif;
        --page: light-dark(#fbfbfa, #161616); --line: light-dark(#d6d6d2, #444);
        --soft: light-dark(#666, #aaa); }
body { margin: 0 auto; padding: 16px 24px 48px; max-width: 1500px; background: var(--page); }
h1 { font-size: 22px; margin: 0 0 4px; } h2 { font-size: 17px; margin: 28px 0 6px; }
.note { color: var(--soft); max-width: 78em; margin: 4px 0; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 2px 7px; text-align: right; border-bottom: 1px solid var(--line);
         white-space: nowrap; }
th { font-weight: 600; } th:first-child, td:first-child { text-align: left; }
tr.ours th, tr.ours td:first-child, b.ours { font-weight: 700; }
.map td { text-align: center; min-width: 3.2em; color: #111; border: 2px solid var(--page);
          cursor: pointer; }
.map td.absent { background: none; cursor: default; }
.map th { border: 0; } .map tr:not(.ours) th:first-child { font-weight: 400; }
.map { display: inline-table; vertical-align: top; margin: 0 18px 18px 0; }
.legend span { display: inline-block; padding: 1px 9px; color: #111; }
.bad { color: light-dark(#b3261e, #ff8a80); font-weight: 600; }
details > summary { cursor: pointer; font-size: 15px; padding: 5px 0; }
svg { max-width: 100%; height: auto; }
</style>
<h1>Stability atlas</h1>
<p class="note" id="made"></p>
<p class="note" id="production"></p>
<h2>Where each method first errs</h2>
<p class="note">Rows are methods (those of ours that must never err in bold), columns families of rays
that are hard on purpose. A cell shows the knob of difficulty at which the method gave its first wrong
answer by exact arithmetic, among answers that floats can decide; its colour the place of that knob in
the family's range, from the start (red) to the end, and never (green). Click a cell for its figures.</p>
<p class="legend" id="legend"></p>
<div class="scroll" id="maps"></div>
<!--CHARTS-->
<h2>Families</h2>
<p class="note">Wrong: missed + false hit + wrong primitive, as counts of the rays. Errors of right answers
as median / maximum. Stability is the error over what moving the inputs by half an ulp can do: about 10 and
less is the problem's fault, more is the method's.</p>
<div id="families"></div>
<script>
"use strict";
const data = /*DATA*/null;
const byId = id => document.getElementById(id);
function element(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}
const brief = x => typeof x !== "number" ? String(x) : x === 0 ? "0" :
  Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(0).replace("+", "") :
  String(+x.toPrecision(3));
const ours = new Set(data.methods.filter(m => m.best).map(m => m.name));

// Red for the first knob value, over yellow to light green for the last, green for never.
function colour(family, method) {
  const knob = family.breakdown[method];
  if (knob === null) return "hsl(135 45% 58%)";
  const place = family.knobs.findIndex(k => k.value === knob);
  return `hsl(${4 + 76 * place / Math.max(1, family.knobs.length - 1)} 78% 66%)`;
}
const labelOf = (family, knob) => family.knobs.find(k => k.value === knob).label;

byId("made").textContent = `Sightline ${data.program}, ${data.rays} rays for each knob value, seed ` +
  `${data.seed}, ${data.rounds} rounds of timing; ${data.embree}; vectors of ${data.isa}; ` +
  `${data.compiler}, ${data.flags}.`;
byId("production").textContent = `Embree as renders use it (${data.production.method}) is wrong on at ` +
  `most ${brief(100 * data.production.worst_fraction)} % of the decidable rays of any knob value.`;
for (const [text, place] of [["at the first knob value", 0], ["half-way", .5], ["at the last", 1]])
  byId("legend").append(element("span", {textContent: text,
                                         style: `background: hsl(${4 + 76 * place} 78% 66%)`}));
byId("legend").append(element("span", {textContent: "never", style: "background: hsl(135 45% 58%)"}));

// Families that the same methods took part in, told by the first of these: one table each.
const groups = new Map();
for (const family of data.families) {
  const first = Object.keys(family.breakdown)[0];
  groups.set(first, [...(groups.get(first) ?? []), family]);
}
function cell(family, name) {
  if (!(name in family.breakdown)) return element("td", {className: "absent"});
  const knob = family.breakdown[name];
  return element("td", {
    textContent: knob === null ? "–" : labelOf(family, knob),
    title: `${name} on ${family.title}`,
    style: "background: " + colour(family, name),
    onclick: () => {
      const section = byId("family-" + family.name);
      section.open = true;
      section.scrollIntoView();
    }});
}
for (const families of groups.values()) {
  const map = element("table", {className: "map"}, element("tr", {}, element("th"),
    ...families.map(f => element("th", {textContent: f.name, title: `${f.title}; knob: ${f.knob}`}))));
  for (const {name} of data.methods.filter(m => families.some(f => m.name in f.breakdown)))
    map.append(element("tr", {className: ours.has(name) ? "ours" : ""},
                       element("th", {textContent: name}), ...families.map(f => cell(f, name))));
  byId("maps").append(map);
}

const measures = {t_ulps: "t, ulps", backward: "off surface, ulps", stability: "stability",
                  normal_angle: "normal, rad", gap: "gap"};
function table(family) {
  const used = Object.keys(measures).filter(m =>
    family.knobs.some(k => k.methods.some(s => m in s)));
  const node = element("table", {}, element("tr", {}, ...[family.knob, "method", "right", "missed",
    "false hit", "wrong primitive", "undecidable", "wrong", "ns/ray", ...used.map(m => measures[m])]
    .map(textContent => element("th", {textContent}))));
  for (const knob of family.knobs)
    knob.methods.forEach((s, i) => {
      const range = m => m in s ? `${brief(s[m].median)} / ${brief(s[m].max)}` : "";
      const texts = [i ? "" : knob.label, s.name, s.same + s.tie + s.near_tie, s.missed, s.false_hit,
        s.wrong_primitive, s.undecidable, s.wrong, s.ns_per_ray ? brief(s.ns_per_ray.median) : "",
        ...used.map(range)];
      node.append(element("tr", {}, ...texts.map((text, column) =>
        element("td", {textContent: text, className: column === 7 && s.wrong ? "bad" : ""}))));
    });
  return node;
}
for (const family of data.families) {
  const section = element("details", {id: "family-" + family.name},
    element("summary", {}, element("b", {textContent: family.name}), " " + family.title +
      ` (knob: ${family.knob})`));
  section.addEventListener("toggle", () => {
    if (section.open && !section.querySelector("table"))
      section.append(element("div", {className: "scroll"}, table(family)));
  });
  byId("families").append(section);
}
</script>
</html>
)html";

void replace(std::string& text, std::string_view place, const std::string& by) {
    text.replace(text.find(place), place.size(), by);
}

}  // namespace

std::string atlas_page(const nlohmann::ordered_json& results, const std::string& charts) {
    std::string data = results.dump();
    // Within <script>, "</script>" or "<!--" would end or swallow the data.
    for (size_t at = 0; (at = data.find('<', at)) != std::string::npos;)
        data.replace(at, 1, "\\u003c");
    std::string text = page;
    replace(text, "<!--CHARTS-->", charts);
    replace(text, "/*DATA*/null", data);
    return text;
}

}  // namespace sightline
