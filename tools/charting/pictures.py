"""Chart 4: time of a whole picture against its difference from the converged one."""
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

import style
from matplotlib.ticker import LogLocator

SAMPLES = (1, 2, 4, 8, 16, 32, 64, 128)

# Series: name, and points as (label, options).
SERIES = (
    ("samples", [(f"{n}", ["--samples", f"{n}"]) for n in SAMPLES]),
    ("samples, Embree default mode",
     [(f"{n}", ["--samples", f"{n}", "--intersector", "embree-default"]) for n in SAMPLES]),
    ("--error", [(f"{e}", ["--error", f"{e}"]) for e in (0.1, 0.06, 0.04, 0.025)]),
    ("depth, 64 samples",
     [(f"{d}", ["--samples", "64", "--depth", f"{d}"]) for d in (0, 1, 2, 3, 4, 6)]),
    ("Appel: no reflections, 1 sample", [("", ["--integrator", "appel"])]),
)


def render(program, scene, size, options, folder):
    """Renders one picture; returns its path, the processor time of the process, and the statistics."""
    picture, stats = os.path.join(folder, "picture.exr"), os.path.join(folder, "stats.json")
    process = subprocess.Popen([program, "render", scene, "-o", picture, "--aov", "depth", "--size",
                                size, "--stats", stats, "--quiet", *options])
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"charts: the render of {scene} failed")
    with open(stats, encoding="utf-8") as file:
        return picture, usage.ru_utime + usage.ru_stime, json.load(file)


def difference(program, reference, picture):
    text = subprocess.run([program, "diff", "--json", reference, picture], check=True,
                          capture_output=True, text=True).stdout
    return json.loads(text)[0]


def measure_scene(program, scene, size, reference_samples, rounds):
    """Renders every point of every series once per round, with a seed per round and for the reference."""
    points = [(name, label, options) for name, row in SERIES for label, options in row]
    runs = [[] for _ in points]
    with tempfile.TemporaryDirectory() as folder:
        picture, _, stats = render(program, scene, size,
                                   ["--samples", f"{reference_samples}", "--seed", "1000003"], folder)
        reference = os.path.join(folder, "reference.exr")
        os.replace(picture, reference)
        for turn in range(rounds):
            for run, (_, _, options) in zip(runs, points):
                picture, seconds, _ = render(program, scene, size,
                                             [*options, "--seed", f"{turn + 1}"], folder)
                found = difference(program, reference, picture)
                run.append([seconds, found["rmse"], found["flip_mean"]])
    return {"scene": os.path.basename(scene), "intersector": stats["intersector"],
            "threads": stats["threads"],
            "points": [{"series": name, "label": label, "runs": run}
                       for (name, label, _), run in zip(points, runs)]}


def measure(program, scenes, size, reference_samples, rounds):
    return {"kind": "pictures", "size": size, "reference_samples": reference_samples,
            "rounds": rounds,
            "scenes": [measure_scene(program, s, size, reference_samples, rounds) for s in scenes]}


def limits(values):
    return min(values) / 1.5, max(values) * 1.5


def isolines(axes):
    """Guides of equal efficiency: error² × time = constant, a slope of −1/2."""
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    low, high = math.log10(y0 * math.sqrt(x0)), math.log10(y1 * math.sqrt(x1))
    steps = [10 ** (k / 2) for k in range(math.ceil(low * 2), math.floor(high * 2) + 1)]
    for c in steps:
        axes.plot((x0, x1), (c / math.sqrt(x0), c / math.sqrt(x1)), color=style.GUIDE, lw=0.7,
                  ls=(0, (4, 4)), zorder=0)
        # Labelled where the line leaves the panel: at the top, otherwise at the left.
        x = (c / y1) ** 2
        place = (x, y1) if x > x0 else (x0, c / math.sqrt(x0))
        if place[0] < x1:
            axes.annotate(f"{1 / c ** 2:.0e}".replace("e+0", "e").replace("e-0", "e-"), place,
                          xytext=(3, -9) if x > x0 else (3, 2), textcoords="offset points",
                          color=style.GUIDE, fontsize=7)
    axes.set_xlim(x0, x1)
    axes.set_ylim(y0, y1)


def draw_series(axes, scene, name, measure_index, look):
    color, marker = look
    points = [p for p in scene["points"] if p["series"] == name]
    xs = [[run[0] for run in p["runs"]] for p in points]
    ys = [[run[measure_index] for run in p["runs"]] for p in points]
    x, y = [statistics.median(v) for v in xs], [statistics.median(v) for v in ys]
    whiskers = [[m - min(v) for m, v in zip(x, xs)], [max(v) - m for m, v in zip(x, xs)]]
    axes.errorbar(x, y, xerr=whiskers, color=color, marker=marker, label=name, capsize=0,
                  elinewidth=0.8, ls="-" if len(points) > 1 else "none",
                  mfc="white" if "default" in name else color)
    if "default" not in name:
        label_points(axes, [p["label"] for p in points], x, y, color, name)


def label_points(axes, labels, x, y, color, name):
    """Labels the points; in a cluster only the first."""
    offset, align = {"samples": ((6, 4), "left"), "--error": ((-5, -11), "right")}.get(
        name, ((7, -3), "left"))
    last = None
    for label, place in zip(labels, zip(x, y)):
        at = axes.transData.transform(place)
        if last is not None and math.dist(at, last) < 14:
            continue
        last = at
        axes.annotate(label, place, xytext=offset, textcoords="offset points", ha=align,
                      fontsize=7.5, color=color)


def draw(data, out):
    scenes = data["scenes"]
    figure, axes = style.panels(2, len(scenes), 5.6 * len(scenes), 8.4)
    names = [name for name, _ in SERIES]
    for column, scene in enumerate(scenes):
        for row, (index, what) in enumerate(((1, "RMSE, linear"), (2, "mean FLIP"))):
            panel = axes[row][column]
            panel.set_xscale("log")
            panel.set_yscale("log")
            panel.set_xlim(*limits([run[0] for p in scene["points"] for run in p["runs"]]))
            panel.set_ylim(*limits([run[index] for p in scene["points"] for run in p["runs"]]))
            for name, look in zip(names, zip(style.COLORS, style.MARKERS)):
                draw_series(panel, scene, name, index, look)
            panel.set_ylabel(what)
            panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            panel.xaxis.set_major_formatter("{x:g}")
            if row == 0:
                isolines(panel)
                panel.set_title(f"{style.plain_text(scene['scene'])}, {data['size']}")
            else:
                panel.set_xlabel("processor seconds, start to finish")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=3, frameon=False,
                  bbox_to_anchor=(0.5, -0.005))
    figure.suptitle("Whole pictures: time against error (down and left is better)\n"
                    "dashed: equal efficiency 1/(MSE · s)", fontsize=12)
    style.save(figure, out)
