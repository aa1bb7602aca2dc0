"""Charts 2 and 3: error against difficulty, and the knob value at which each method first fails."""
import math

import numpy
import style

# The measures that are drawn; the reports' tables have the others.
MEASURES = (("wrong", "wrong of decidable rays"), ("t_ulps", "error of t, ulps (99.9 %)"))


def number(value):
    return {"inf": math.inf, "nan": math.nan}.get(value, value)


def numeric(family):
    """Whether the knob is a quantity, not the number of a case."""
    return all(k["label"] == f"{number(k['value']):g}" for k in family["knobs"]) and \
        len(family["knobs"]) > 2


def positions(family):
    """The knob values as positions on the axis."""
    return [number(k["value"]) for k in family["knobs"]]


def curve(family, method, measure):
    """Points (knob, value) of one method."""
    points = []
    for x, knob in zip(positions(family), family["knobs"]):
        score = next((m for m in knob["methods"] if m["name"] == method), None)
        if score is None or not math.isfinite(x) or x <= 0:
            continue
        if measure == "wrong":
            value = score["wrong"] / score["decidable"] if score["decidable"] else math.nan
        else:
            value = number(score.get(measure, {}).get("p999", math.nan))
        points.append((x, value))
    return points


def condition_guide(family):
    """The change of t, in ulps, that half an ulp of the inputs causes: the condition, 99.9 %."""
    return [(number(k["value"]), number(k["condition"]["p999"]) / 2)
            for k in family["knobs"] if "condition" in k and number(k["value"]) > 0]


def distinct_curves(family, measure):
    """Methods grouped by equal curves, as (names, points), the worst first."""
    groups = {}
    for method in [m["name"] for m in family["knobs"][0]["methods"]]:
        points = [(x, y) for x, y in curve(family, method, measure) if math.isfinite(y)]
        if points:
            key = tuple(round(math.log10(max(y, 1e-9)) * 3) for _, y in points)
            groups.setdefault(key, ([], points))[0].append(method)
    return sorted(groups.values(), key=lambda g: -sum(math.log10(max(y, 1e-9)) for _, y in g[1]))


FIXED = {"embree": 1, "embree-default": 4, "exact": 2, "analytic": 2}


def chosen_curves(family, measure):
    """At most eight curves with colour index: those of the engines that render, then the worst."""
    curves = distinct_curves(family, measure)
    known = [c for c in curves if set(c[0]) & set(FIXED)]
    others = [c for c in curves if c not in known]
    shown = known + others[:8 - len(known)]
    fixed = [next((FIXED[n] for n in names if n in FIXED), None) for names, _ in shown]
    left = [i for i in range(8) if i not in fixed]
    return [(names, points, look if look is not None else left.pop(0))
            for (names, points), look in zip(shown, fixed)]


def short(names):
    names = sorted(names, key=lambda n: (n not in FIXED, n))
    text = ", ".join(names[:2])
    return text if len(names) <= 2 else f"{text} + {len(names) - 2}"


def draw_curves(axes, family, measure, what):
    axes.set_xscale("log")
    if measure == "wrong":
        axes.set_yscale("symlog", linthresh=1e-4)
        axes.set_ylim(-2e-5, 1.6)
    else:
        axes.set_yscale("log")
    for names, points, look in chosen_curves(family, measure):
        x, y = zip(*points)
        axes.plot(x, [v if measure == "wrong" else max(v, 1e-7) for v in y],
                  color=style.COLORS[look], marker=style.MARKERS[look], ms=4.5, label=short(names))
    guide = condition_guide(family) if measure == "t_ulps" else []
    if guide and axes.lines:
        axes.plot(*zip(*guide), color=style.GUIDE, ls=(0, (4, 3)),
                  label="condition × ½ ulp of the inputs")
    axes.set_xlabel(family["knob"])
    axes.set_ylabel(what)


def draw(data, out):
    """One figure for each first letter of the families' names: OUT-T, OUT-S, …"""
    groups = {}
    for family in data["families"]:
        if numeric(family):
            groups.setdefault(family["name"][0], []).append(family)
    for letter, families in groups.items():
        figure, axes = style.panels(len(families), 2, 14, 2.9 * len(families))
        for row, family in zip(axes, families):
            for panel, (measure, what) in zip(row, MEASURES):
                draw_curves(panel, family, measure, what)
                if not panel.lines:
                    panel.axis("off")
                    continue
                panel.set_title(f"{family['name']}: {family['title']}", loc="left")
                panel.legend(frameon=False, fontsize=7.5, loc="center left",
                             bbox_to_anchor=(1.0, 0.5))
        style.save(figure, f"{out}-{letter}")


def heat_cell(family, method):
    """The part of the family's range in which the method is right (0: none, 1: all), and its text."""
    if method not in family["breakdown"]:
        return math.nan, ""
    values = [number(k["value"]) for k in family["knobs"]]
    broke = family["breakdown"][method]
    if broke is None:
        return 1.0, "never"
    index = values.index(number(broke))
    label = family["knobs"][index]["label"]
    if numeric(family) and number(broke) >= 10 and math.isfinite(number(broke)):
        exponent = math.log10(number(broke))
        label = f"1e{exponent:.0f}" if exponent == round(exponent) else label.replace("e+0", "e")
    return 0.9 * index / len(values), label


def groups_of(families):
    """Families grouped into panels by the methods that they share: (methods, families)."""
    groups = []
    for family in families:
        names = [m["name"] for m in family["knobs"][0]["methods"]]
        group = next((g for g in groups if 2 * len(set(names) & set(g[0])) >= len(names)), None)
        if group is None:
            groups.append((names, [family]))
        else:
            group[0].extend(n for n in names if n not in group[0])
            group[1].append(family)
    return groups


def heat_panel(axes, families, methods):
    cells = [[heat_cell(f, m) for f in families] for m in methods]
    shades = numpy.array([[c[0] for c in row] for row in cells])
    axes.imshow(numpy.ma.masked_invalid(shades), cmap="cividis", vmin=0, vmax=1, aspect="auto")
    for y, row in enumerate(cells):
        for x, (shade, text) in enumerate(row):
            axes.text(x, y, text, ha="center", va="center", fontsize=7.5,
                      color="black" if shade > 0.5 else "white")
    axes.set_xticks(range(len(families)), [f["name"] for f in families])
    axes.set_yticks(range(len(methods)), methods, fontsize=8)
    axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)


def reached(families, method):
    """The mean of a method's cells, for ranking: methods that never fail come first."""
    shades = [s for s in (heat_cell(f, method)[0] for f in families) if not math.isnan(s)]
    return sum(shades) / len(shades)


def draw_heat_map(data, out):
    groups = groups_of(data["families"])
    heights = [len(methods) for methods, _ in groups]
    widest = max(len(families) for _, families in groups)
    size = (3.2 + 0.75 * widest, 1.2 + 0.27 * (sum(heights) + 2 * len(groups)))
    figure, axes = style.panels(len(groups), 1, *size, heights)
    for panel, (methods, families) in zip(axes[:, 0], groups):
        ranked = sorted(methods, key=lambda m: (-reached(families, m), m))
        heat_panel(panel, families, ranked)
        panel.set_xlim(-0.5, widest - 0.5)
    figure.suptitle("Smallest knob value with a wrong answer, by method (light: large or none)", fontsize=11)
    style.save(figure, out)
