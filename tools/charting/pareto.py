"""Chart 1: time per ray against wrong decisions per million, and the times alone."""
import math

import style
from matplotlib.ticker import LogLocator, MaxNLocator


def questions_of(families):
    """(key, title, methods, families) of the atlas' questions, in order."""
    found = []
    for question in style.LOOKS["questions"]:
        asked = [f for f in families if f["name"] in question["families"]]
        if asked:
            methods = list(dict.fromkeys(m["name"] for f in asked for m in f["knobs"][0]["methods"]))
            found.append((question["key"], question["title"], methods, asked))
    return found


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


def points_of_families(methods, families):
    """One point per method of the atlas, over all knob values of the families it applies to."""
    points = []
    for name in methods:
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


def plain(value):
    """A number of about three digits without an exponent."""
    digits = max(0, 2 - math.floor(math.log10(value))) if value > 0 else 0
    return f"{value:,.{digits}f}"


def place_clean(points):
    """Moves the points that were never wrong below all others; returns the band's edge or None."""
    clean = [p for p in points if not p["wrong"]]
    if not clean:
        return None
    bound = 3e6 / min(p["answers"] for p in clean)  # 95 % confidence: the rule of three
    top = min([bound] + [p["errors"] / 2 for p in points if p["wrong"]])
    for p in clean:
        p["errors"] = top / 3
    return top


def draw_marks(axes, points):
    for p in points:
        color, marker, fill = style.look_of(p["name"])
        axes.errorbar(p["ns"], p["errors"], xerr=[[p["ns"] - p["low"]], [p["high"] - p["ns"]]],
                      color=color, marker=marker, mfc=fill, elinewidth=0.7, ls="none", zorder=3)


def draw_points(points, title, out, what="wrong decisions per million"):
    """Time against errors; every method is in the legend."""
    figure, axes = style.method_panel([p["name"] for p in points])
    axes.set_xscale("log")
    axes.set_yscale("log")
    top = place_clean(points)
    lowest = min(p["errors"] for p in points)
    limits = lowest / 3, max(p["errors"] for p in points) * 3
    if top:
        axes.axhspan(limits[0], top, color="#E8F3EE", zorder=0, lw=0)
        least = min(p["answers"] for p in points if not p["wrong"])
        axes.text(0.99, 0.02, f"none wrong of {least:,}: fewer than {plain(3e6 / least)} per million",
                  transform=axes.transAxes, ha="right", fontsize=7.5, color=style.RIGHT)
    front = pareto_front(points)
    axes.step([p["ns"] for p in front], [p["errors"] for p in front], where="post",
              color=style.GUIDE, lw=1.2, zorder=1)
    draw_marks(axes, points)
    axes.minorticks_off()
    shown = top or limits[0], min(1e6, limits[1])
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if shown[1] < 30 * shown[0] else (1,), numticks=8))
    axes.set_ylim(*limits)
    axes.set_yticks([t for t in axes.get_yticks() if shown[0] < t <= shown[1]])
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,.7g}")
    axes.set_ylim(*limits)
    axes.set_xlim(min(p["low"] for p in points) / 1.4, max(p["high"] for p in points) * 1.4)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter("{x:,.7g}")
    axes.set_title(title, loc="left")
    axes.set_xlabel("ns a ray, one thread")
    axes.set_ylabel(what)
    style.save(figure, out)


def draw_price(data, out):
    """ns per ray by method and kind of ray, the fastest method first."""
    kinds = [k for k, rays in data["rays"].items() if rays]
    timed = [m for m in data["methods"] if any(m["kinds"][k]["ns_per_ray"] for k in kinds)]
    timed.sort(key=lambda m: -(m["total"].get("ns_per_ray") or 0))
    times = [m["kinds"][k]["ns_per_ray"] for m in timed for k in kinds if m["kinds"][k]["ns_per_ray"]]
    log = max(times) > 12 * min(times)
    figure, axes = style.panels(1, len(kinds), 1.7 + 1.5 * max(2, len(kinds)), 0.9 + 0.2 * len(timed))
    for column, (panel, kind) in enumerate(zip(axes[0], kinds)):
        for y, method in enumerate(timed):
            if method["kinds"][kind]["ns_per_ray"]:
                draw_time(panel, y, method["name"], method["kinds"][kind], log)
        panel.set_yticks(range(len(timed)), [style.plain_text(m["name"]) for m in timed] if column == 0 else [""] * len(timed))
        panel.set_ylim(-0.7, len(timed) - 0.3)
        if log:
            panel.set_xscale("log")
            panel.set_xlim(min(times) / 1.5, max(times) * 8)
            panel.xaxis.set_major_formatter("{x:,.6g}")
            panel.minorticks_off()
        else:
            panel.set_xlim(0, 1.35 * max(times))
            panel.xaxis.set_major_locator(MaxNLocator(3))
        panel.grid(False, axis="y")
        panel.tick_params(length=0, axis="y")
        panel.set_title(f"{kind} rays", loc="left")
        panel.set_xlabel("ns a ray, one thread")
    style.save(figure, out)


def draw_time(axes, y, name, score, log):
    """A bar; on a logarithmic axis, where a bar's length means nothing, a mark."""
    color, marker, fill = style.look_of(name)
    time, rounds = score["ns_per_ray"], score["ns_per_ray_rounds"]
    if log:
        axes.plot(time, y, color=color, marker=marker, mfc=fill, ls="none")
    else:
        axes.barh(y, time, height=0.66, color=fill, edgecolor=color, lw=1.2)
    axes.plot([rounds[0], rounds[-1]], [y, y], color="#333333", lw=0.7)
    axes.annotate(f"{time:,.0f}", (max(rounds[-1], time), y), xytext=(5, 0), textcoords="offset points",
                  va="center", fontsize=7.5)


def draw_comparison(data, out):
    """Errors against time where something erred, and the times in any case."""
    points = points_of_comparison(data)
    name = style.plain_text(data["scene"].rsplit("/", 1)[-1])
    if any(p["wrong"] for p in points):
        draw_points(points, f"{name}: all rays, by the referee", out + "-pareto", "wrong answers per million rays")
    if points:
        draw_price(data, out + "-price")


def draw_atlas(data, out):
    """One chart for each question: OUT-triangles, OUT-boxes, …"""
    for key, title, methods, families in questions_of(data["families"]):
        points = points_of_families(methods, families)
        if len(points) > 1 and key != "builds":  # that asks for equal answers, not for fast ones
            draw_points(points, f"{title}: all degrees of difficulty", f"{out}-{key}")
