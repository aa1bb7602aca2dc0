"""Chart 1: time per ray against wrong decisions per million."""
import math

import style
from matplotlib.ticker import LogLocator

def pareto_front(points):
    """The points that no other beats in both time and errors, by time."""
    front = []
    for point in sorted(points, key=lambda p: (p["ns"], p["errors"])):
        if not front or point["errors"] < front[-1]["errors"]:
            front.append(point)
    return front


def points_of_comparison(data):
    """One point per method of a results.json of `sightline compare`, over all kinds of rays."""
    points = []
    for method in data["methods"]:
        kinds = [k for k in method["kinds"].values() if k["rays"] and k["ns_per_ray"]]
        if not kinds:
            continue
        rays = sum(k["rays"] for k in kinds)
        rounds = zip(*(k["ns_per_ray_rounds"] for k in kinds))
        times = [sum(t * k["rays"] for t, k in zip(turn, kinds)) / rays for turn in rounds]
        total = method["total"]
        judged = total["rays"] - total.get("unjudged", 0)
        points.append(point(method["name"], sorted(times), total["wrong"], judged,
                            total["wrong_per_million"]["estimate"]))
    return points


def points_of_families(families):
    """One point per method of the atlas, over all knob values of the families it applies to."""
    points = []
    for name in [m["name"] for m in families[0]["knobs"][0]["methods"]]:
        scores = [m for f in families for k in f["knobs"] for m in k["methods"]
                  if m["name"] == name and "ns_per_ray" in m]
        decidable = sum(m["decidable"] for m in scores)
        if not decidable:
            continue
        times = [math.exp(sum(math.log(m["ns_per_ray"][which]) for m in scores) / len(scores))
                 for which in ("min", "median", "max")]
        wrong = sum(m["wrong"] for m in scores)
        points.append(point(name, times, wrong, decidable, 1e6 * wrong / decidable))
    return points


def point(name, times, wrong, answers, per_million):
    return {"name": name, "ns": times[len(times) // 2], "low": times[0], "high": times[-1],
            "wrong": wrong, "answers": answers, "errors": per_million}


def place_clean(points):
    """Moves the points that were never wrong below all others; returns the band's edges or None."""
    clean = [p for p in points if not p["wrong"]]
    if not clean:
        return None
    bound = 3e6 / min(p["answers"] for p in clean)  # 95 % confidence: the rule of three
    top = min([bound] + [p["errors"] / 2 for p in points if p["wrong"]])
    for p in clean:
        p["errors"] = top / 2
    return top, bound


def label_beside(axes, points, size):
    """Labels the points, above or (if never wrong) below them, where there is no label yet."""
    axes.figure.canvas.draw()
    scale = axes.figure.dpi / 72
    height = 1.25 * size * scale
    taken = []
    for p in points:
        x, y = axes.transData.transform((p["ns"], p["errors"]))
        taken.append((x - 4 * scale, y - 4 * scale, x + 4 * scale, y + 4 * scale))
    for p in sorted(points, key=lambda p: (-p["errors"], p["ns"])):
        x, y = axes.transData.transform((p["ns"], p["errors"]))
        width = 0.6 * size * len(p["name"]) * scale
        sign = 1 if p["wrong"] else -1
        places = [(x + shift * width, y + sign * (0.9 + step) * height - height / 2)
                  for step in range(16) for shift in (-0.5, 0.05, -1.05)]
        box = next(((left, low, left + width, low + height) for left, low in places
                    if not any(left < t[2] and t[0] < left + width and low < t[3]
                               and t[1] < low + height for t in taken)), None)
        if box is None:
            continue
        taken.append(box)
        place = axes.transData.inverted().transform((box[0] + width / 2, box[1] + height / 2))
        axes.annotate(p["name"], (p["ns"], p["errors"]), xytext=place, textcoords="data",
                      fontsize=size, ha="center", va="center", color=look_of(p["name"])[0],
                      arrowprops={"arrowstyle": "-", "lw": 0.5, "color": style.GUIDE,
                                  "shrinkA": 1, "shrinkB": 2}, zorder=4)


def look_of(name):
    """Colour, marker and fill of an engine; hollow if it computes in double."""
    if name.startswith("embree"):
        color, marker = style.COLORS[1], "s"
    elif name.startswith("exact"):
        color, marker = style.COLORS[2], "D"
    else:
        color, marker = style.COLORS[0], "o"
    return color, marker, "white" if name.endswith("-double") else color


def draw_panel(axes, points, title):
    axes.set_xscale("log")
    axes.set_yscale("log")
    band = place_clean(points)
    lowest = min(p["errors"] for p in points)
    clean = sum(not p["wrong"] for p in points)
    room = 1.7 ** (len(points) - clean)  # for the names
    limits = lowest / (4 * 1.6 ** clean), max(p["errors"] for p in points) * 3 * room
    axes.set_ylim(*limits)
    axes.set_xlim(min(p["low"] for p in points) / 1.6, max(p["high"] for p in points) * 1.6)
    if band:
        axes.axhspan(limits[0], band[0], color="#E8F3EE", zorder=0, lw=0)
        least = min(p["answers"] for p in points if not p["wrong"])
        axes.text(0.995, 0.015, f"none wrong of {least:,}: fewer than {band[1]:,.3g} per million",
                  transform=axes.transAxes, ha="right", fontsize=8, color=style.COLORS[2])
        axes.set_yticks([t for t in axes.get_yticks() if band[0] < t <= 1e6])
        axes.set_ylim(*limits)
    front = pareto_front(points)
    axes.step([p["ns"] for p in front], [p["errors"] for p in front], where="post",
              color=style.GUIDE, lw=1.2, zorder=1)
    for p in points:
        color, marker, fill = look_of(p["name"])
        axes.errorbar(p["ns"], p["errors"], xerr=[[p["ns"] - p["low"]], [p["high"] - p["ns"]]],
                      color=color, marker=marker, mfc=fill, elinewidth=0.7, ls="none", zorder=3)
    label_beside(axes, points, 8)
    axes.minorticks_off()
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_title(title)
    axes.set_xlabel("ns a ray, one thread")
    axes.set_ylabel("wrong decisions per million")


def legend(figure, axes):
    from matplotlib.lines import Line2D
    marks = [("Embree", style.COLORS[1], "s", style.COLORS[1]),
             ("exact tree", style.COLORS[2], "D", style.COLORS[2]),
             ("method in float", style.COLORS[0], "o", style.COLORS[0]),
             ("in double", style.COLORS[0], "o", "white")]
    handles = [Line2D([], [], color=c, marker=m, mfc=f, ls="none", label=label)
               for label, c, m, f in marks]
    handles.append(Line2D([], [], color=style.GUIDE, label="Pareto front"))
    figure.legend(handles=handles, loc="upper center", ncol=5, frameon=False,
                  bbox_to_anchor=(0.5, -0.005))


def draw_comparison(data, out):
    figure, axes = style.panels(1, 1, 9.5, 6.2)
    draw_panel(axes[0][0], points_of_comparison(data),
               f"{data['scene'].rsplit('/', 1)[-1]}: all rays of a render, by the referee")
    legend(figure, axes)
    style.save(figure, out)


def draw_atlas(data, out):
    groups = {}
    for family in data["families"]:
        groups.setdefault(tuple(m["name"] for m in family["knobs"][0]["methods"]), []).append(family)
    groups = [g for g in groups.values() if len(points_of_families(g)) > 1]
    figure, axes = style.panels(len(groups), 1, 10.5, 6.2 * len(groups))
    for panel, families in zip(axes[:, 0], groups):
        draw_panel(panel, points_of_families(families),
                   "Atlas, all knob values of " + ", ".join(f["name"] for f in families))
    legend(figure, axes)
    style.save(figure, out)
