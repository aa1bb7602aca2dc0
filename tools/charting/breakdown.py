"""Charts 2 and 3: error against difficulty, and the knob value at which each method first fails."""
import math

import numpy
import style
from matplotlib.colors import to_rgb
from pareto import questions_of

# The measures that are drawn; the reports' tables have the others.
MEASURES = (("wrong", "share of wrong answers"), ("t_ulps", "error of t, ulps (99.9 %)"))


def number(value):
    return {"inf": math.inf, "nan": math.nan}.get(value, value)


def numeric(family):
    """Whether the knob is a quantity, not the number of a case."""
    return all(k["label"] == f"{number(k['value']):g}" for k in family["knobs"]) and \
        len(family["knobs"]) > 2


def curve(family, method, measure):
    """Points (knob, value) of one method."""
    points = []
    for knob in family["knobs"]:
        x = number(knob["value"])
        score = next((m for m in knob["methods"] if m["name"] == method), None)
        if score is None or not math.isfinite(x) or x <= 0:
            continue
        if measure == "wrong":
            value = score["wrong"] / score["decidable"] if score["decidable"] else math.nan
        else:
            value = number(score.get(measure, {}).get("p999", math.nan))
        if math.isfinite(value):
            points.append((x, value))
    return points


def condition_guide(family):
    """The change of t, in ulps, that half an ulp of the inputs causes: the condition, 99.9 %."""
    return [(number(k["value"]), number(k["condition"]["p999"]) / 2)
            for k in family["knobs"] if "condition" in k and number(k["value"]) > 0]


def equal_curves(family, measure):
    """Methods with curves, grouped by equal ones: (names, points)."""
    groups = {}
    for method in [m["name"] for m in family["knobs"][0]["methods"]]:
        points = curve(family, method, measure)
        if points:
            key = tuple((x, round(math.log10(max(y, 1e-9)) * 3)) for x, y in points)
            groups.setdefault(key, ([], points))[0].append(method)
    return list(groups.values())


def draw_curves(axes, family, measure):
    """Every method in its look; those with the same curve share it, as dashes of their colours in turn."""
    dash = 5
    for names, points in equal_curves(family, measure):
        x, y = zip(*points)
        y = [v if measure == "wrong" else max(v, 1e-7) for v in y]
        for turn, name in enumerate(names):
            color, marker, fill = style.look_of(name)
            line = "-" if len(names) == 1 else (turn * dash, (dash, dash * (len(names) - 1)))
            marked = [i for i in range(len(x)) if i % len(names) == turn % max(1, min(len(names), len(x)))]
            axes.plot(x, y, color=color, ls=line)
            axes.plot([x[i] for i in marked], [y[i] for i in marked], color=color, marker=marker, mfc=fill,
                      ms=4.5, ls="none")


def draw_measure(family, measure, what, out):
    names = [n for names, _ in equal_curves(family, measure) for n in names]
    if not names:
        return
    order = [m["name"] for m in family["knobs"][0]["methods"]]
    guide = condition_guide(family) if measure == "t_ulps" else []
    figure, axes = style.method_panel(sorted(names, key=order.index),
                                      "condition × ½ ulp of the inputs" if guide else None)
    axes.set_xscale("log")
    if measure == "wrong":
        axes.set_yscale("symlog", linthresh=1e-4)
        axes.set_ylim(-2e-5, 1.6)
        axes.set_yticks([0, 1e-4, 1e-3, 1e-2, 1e-1, 1], ["0", "0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
        axes.minorticks_off()
    else:
        axes.set_yscale("log")
    draw_curves(axes, family, measure)
    if guide:
        axes.plot(*zip(*guide), color=style.GUIDE, ls=(0, (4, 3)))
    axes.set_title(family["title"][0].upper() + family["title"][1:], loc="left")
    axes.set_xlabel(family["knob"])
    axes.set_ylabel(what)
    style.save(figure, out, (".svg",))  # there are dozens of these


def draw(data, out):
    """Two figures for each family whose knob is a quantity: OUT-T1e-wrong, OUT-T1e-t_ulps, …"""
    for family in data["families"]:
        if numeric(family):
            for measure, what in MEASURES:
                draw_measure(family, measure, what, f"{out}-{family['name']}-{measure}")


def shade(position):
    """The colour of a heat map's cell; `position` of the first failure in the family's range, 1: never."""
    heat = style.LOOKS["heat"]
    return style.LOOKS["never"] if position >= 1 else heat[min(len(heat) - 1, int(position * len(heat)))]


def heat_cell(family, method):
    """The part of the family's range in which the method is right (0: none, 1: all), and its text."""
    if method not in family["breakdown"]:
        return math.nan, ""
    values = [number(k["value"]) for k in family["knobs"]]
    broke = family["breakdown"][method]
    if broke is None:
        return 1.0, "never"
    index = values.index(number(broke))
    label = f"case {index + 1}" if family["knob"] == "case" else family["knobs"][index]["label"]
    if numeric(family) and number(broke) >= 1000 and math.isfinite(number(broke)):
        exponent = math.log10(number(broke))
        label = f"1e{exponent:.0f}" if exponent == round(exponent) else label.replace("e+0", "e")
    return index / len(values), label


def short_names():
    """The families' names in words."""
    return {name: words for q in style.LOOKS["questions"] for name, words in q["families"].items()}


def heat_panel(axes, families, methods, columns):
    """Cells of one size in a panel with room for so many columns."""
    cells = [[heat_cell(f, m) for f in families] for m in methods]
    absent = (1.0, 1.0, 1.0)
    axes.imshow(numpy.array([[absent if math.isnan(c[0]) else to_rgb(shade(c[0])) for c in row] for row in cells]),
                aspect="auto")
    for y, row in enumerate(cells):
        for x, (position, text) in enumerate(row):
            axes.text(x, y, text, ha="center", va="center", fontsize=6.5,
                      color="black" if position >= 0.6 else "white")
    names = short_names()
    axes.set_xticks(range(len(families)), [names[f["name"]].replace(" ", "\n") for f in families], fontsize=6.5)
    axes.set_yticks(range(len(methods)), methods, fontsize=7)
    axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    axes.set_xlim(-0.5, columns - 0.5)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(False)


def reached(families, method):
    """The mean of a method's cells, for ranking: methods that never fail come first."""
    positions = [p for p in (heat_cell(f, method)[0] for f in families) if not math.isnan(p)]
    return sum(positions) / len(positions)


def merged_questions(families):
    """(methods, families) of the questions, those with mostly the same methods together."""
    groups = []
    for _, _, methods, asked in questions_of(families):
        group = next((g for g in groups if 2 * len(set(methods) & set(g[0])) > len(methods)), None)
        if group is None:
            groups.append((methods, asked))
        else:
            group[0].extend(n for n in methods if n not in group[0])
            group[1].extend(asked)
    return groups


def draw_heat_map(data, out):
    """All questions in two columns of about equal height; their cells have one size."""
    heading = 3  # rows
    columns = ([], [])
    for group in sorted(merged_questions(data["families"]), key=lambda g: -len(g[0]) * len(g[1])):
        min(columns, key=lambda c: sum(len(methods) + heading for methods, _ in c)).append(group)
    columns = [c for c in columns if c]
    rows = [sum(len(methods) + heading for methods, _ in c) for c in columns]
    widest = [max(len(families) for _, families in c) for c in columns]
    widths = [1.9 + 0.5 * w for w in widest]
    figure = style.plt.figure(figsize=(sum(widths), 0.3 + 0.17 * max(rows)), constrained_layout=True)
    parts = figure.subfigures(1, len(columns), width_ratios=widths, squeeze=False)[0]
    for part, column, used, width in zip(parts, columns, rows, widest):
        heights = [len(methods) + heading for methods, _ in column] + [max(rows) - used + 0.01]
        panels = part.subplots(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        panels[-1].axis("off")
        for panel, (methods, families) in zip(panels, column):
            heat_panel(panel, families, sorted(methods, key=lambda m: (-reached(families, m), m)), width)
    figure.suptitle("Difficulty at which each method is first wrong (light: late or never)", fontsize=10)
    style.save(figure, out)
