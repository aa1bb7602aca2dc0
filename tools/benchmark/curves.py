"""Cost curves: time and memory against pixels, samples, triangles, lamps, textures, views and threads, log-log.

Each curve multiplies one of these and leaves the rest as it is; the number behind its name is its slope. Of several runs the least counts: other
work on the machine only adds to it.
"""
import math
import os

import inputs
import loading

SMALL = ("--size", "128x128", "--samples", "4")


def measure(bench, scene, *options, views=0, **how):
    """Seconds of the stages and of the whole run, and peak megabytes, each the least of the runs."""
    found = []
    for _ in range(bench.count):
        if views:
            run, pictures = loading.sequence(bench, scene, "--turntable", str(views), *options)
        else:
            run, picture = bench.sightline(scene, *options, **how)
            pictures = [picture]
        point = {stage: sum(p["seconds"][stage] for p in pictures)
                 for stage in ("load", "build", "prepare", "render", "write")}
        found.append({**point, "whole run": run.seconds, "memory": max(p["peak_memory_bytes"] for p in pictures) * 1e-6})
    return {key: min(point[key] for point in found) for key in found[0]}


def curves(bench):
    """By turns: a title, the unit of x, the stages to draw, and pairs of x and what was measured."""
    helmet = bench.asset(loading.TEXTURED)

    def curve(title, unit, stages, values, run):
        print(f"{title} …", flush=True)
        return title, unit, stages, [(x, run(x)) for x in values]

    yield curve("pixels", "pixels", ("render", "write"), [4 ** k for k in range(6, 11)],
                lambda n: measure(bench, helmet, "--size", str(math.isqrt(n)), "--samples", "4"))
    yield curve("samples", "samples per pixel", ("render",), [1, 4, 16, 64],
                lambda n: measure(bench, helmet, "--size", "128x128", "--samples", str(n)))
    yield curve("triangles", "triangles", ("load", "build", "render"),
                [2 * n * n for n in (32, 64, 128, 256, 512, 1024)],
                lambda n: measure(bench, inputs.waves(bench.path(f"waves_{n}.glb"), math.isqrt(n // 2)),
                                  *SMALL))
    yield curve("lamps", "lamps", ("render",), [1, 2, 4, 8, 16, 32],
                lambda n: measure(bench, inputs.under_lamps(helmet, bench.path("lamps.glb"), n), *SMALL))
    yield curve("texture size", "pixels of each of four textures", ("load", "prepare", "render"),
                [side ** 2 for side in (512, 1024, 2048, 4096)],
                lambda n: measure(bench, loading.large_textures(bench, math.isqrt(n)), *SMALL))
    yield curve("views", "views", ("load", "render", "write"), [1, 2, 4, 8, 16, 32],
                lambda n: measure(bench, loading.large_textures(bench), *SMALL, views=n))
    yield curve("threads", "threads", ("render",), sorted({1, 2, os.cpu_count() or 2}),
                lambda n: measure(bench, helmet, "--size", "256x256", "--samples", "16", threads=n))


def slope(line):
    """Of the straight line that fits best in logarithms."""
    logs = [(math.log(x), math.log(y)) for x, y in line]
    mean_x, mean_y = (sum(values) / len(logs) for values in zip(*logs))
    return (sum((x - mean_x) * (y - mean_y) for x, y in logs)
            / sum((x - mean_x) ** 2 for x, _ in logs))


def short(x):
    """A number of few letters, in powers of 1024 where it is whole in them: 64 k."""
    for letter, size in (("M", 1 << 20), ("k", 1 << 10)):
        if x >= size and x % size == 0:
            return f"{x // size} {letter}"
    return str(x)


def spread(heights, gap):
    """The heights moved up as far as needed to lie `gap` apart."""
    moved, last = {}, -math.inf
    for height, key in sorted(heights):
        last = max(height, last + gap)
        moved[key] = last
    return moved


def draw_panel(style, panel, points, keys):
    """The lines, and behind each its name and slope."""
    lines = {key: [(x, point[key]) for x, point in points if point[key] > 0] for key in keys}
    lines = {key: line for key, line in lines.items() if len(line) > 1}
    first, last = points[0][0], points[-1][0]
    logs = [math.log(y) for line in lines.values() for _, y in line]
    height = max(max(logs) - min(logs), math.log(4))
    ends = spread([(math.log(line[-1][1]), key) for key, line in lines.items()], 0.11 * height)
    for k, (key, line) in enumerate(lines.items()):
        panel.plot(*zip(*line), color=style.COLORS[k], marker=style.MARKERS[k], ms=4)
        panel.text(last * (last / first) ** 0.05, math.exp(ends[key]), f"{key} {slope(line):+.2f}",
                   color=style.COLORS[k], fontsize=8, va="center")
    marked = [x for x, _ in points][::-2 if len(points) > 4 else -1]
    panel.set(xscale="log", yscale="log", xlim=(first * (first / last) ** 0.07, last * (last / first) ** 0.75),
              ylim=(math.exp(min(logs) - 0.1 * height), math.exp(min(logs) + 1.15 * height)))
    panel.set_xticks(marked, map(short, marked))
    panel.set_xticks([], minor=True)
    panel.yaxis.set_major_formatter(lambda y, _: f"{y:g}")
    panel.yaxis.set_minor_formatter(lambda y, _: f"{y:g}" if height < math.log(10) else "")


def draw(style, found, out):
    """OUT-time and OUT-memory, as SVG and PNG, a panel for each curve."""
    for what, label in (("time", "seconds"), ("memory", "MB of peak memory")):
        figure, axes = style.panels(2, 4, 12, 6)
        figure.set_constrained_layout_pads(h_pad=0.12, w_pad=0.06)
        for panel, (title, unit, stages, points) in zip(axes.flat, found):
            draw_panel(style, panel, points, ("whole run", *stages) if what == "time" else ("memory",))
            panel.set(title=title, xlabel=unit, ylabel=label)
        for panel in axes.flat[len(found):]:
            panel.set_axis_off()
        style.save(figure, f"{out}-{what}")
