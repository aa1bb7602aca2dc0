"""Charts 5 and 6: Whitted's picture over the years, and the cost of a ray in larger scenes."""
import json
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time

import numpy
import style

# Times of the picture of Whitted 1980, "An Improved Illumination Model for Shaded Display": his own,
# and later ones quoted in lectures.
PAST = ((1980, 74 * 60, "VAX-11/780: 74 min"), (2006, 6, "PC: 6 s"), (2012, 1 / 30, "GPU: 1/30 s"))

# Rows of triangles in a ball: 64 balls of 4·rows² triangles give a thousand … 20 million.
ROWS = (2, 8, 32, 64, 205, 280)
# A method, the largest number of triangles that it is timed with, its title and its line.
METHODS = (("moller-trumbore:loop", 1e5, "every triangle", ":"),
           ("moller-trumbore:bounds", 2e6, "a box around each ball", "--"),
           ("moller-trumbore", 1e9, "tree, Möller–Trumbore", "-"),
           ("exact", 1e9, "tree, exact", "-"),
           ("embree", 1e9, "Embree ROBUST, sixteen rays a call", "-"),
           ("embree-single", 1e9, "Embree ROBUST, ray by ray", "--"),
           ("embree-default", 1e9, "Embree default, sixteen rays a call", "-"),
           ("embree-default-single", 1e9, "Embree default, ray by ray", "--"),
           ("embree-high", 1e9, "Embree default, best build, sixteen rays a call", "-"))
KINDS = ("camera", "reflection", "shadow")


def run(program, *arguments):
    result = subprocess.run([program, *arguments], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"charts: sightline {' '.join(arguments)} failed: {result.stderr.strip()}")


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def measure_history(program, scene, rounds):
    """Seconds of the render stage at 640×480; the qualities take turns."""
    qualities = (("one ray a pixel", ("--samples", "1")),
                 ("antialiased", ("--error", "0.06", "--max-samples", "8")))
    seconds = {name: [] for name, _ in qualities}
    with tempfile.TemporaryDirectory() as folder:
        stats = os.path.join(folder, "stats.json")
        for _ in range(rounds):
            for name, options in qualities:
                # A PNG: the compression of an EXR would be a part of the render stage.
                run(program, "render", scene, "-o", os.path.join(folder, "picture.png"),
                    "--size", "640x480", "--stats", stats, "--quiet", *options)
                found = read(stats)
                seconds[name].append(found["seconds"]["render"])
                threads = found["threads"]
    return {"kind": "history", "year": time.gmtime().tm_year, "threads": threads,
            "seconds": seconds}


def ball(centre, radius, rows):
    """Positions and indices of a ball with bumps, of 4·rows² triangles."""
    v, u = numpy.meshgrid(numpy.linspace(0, 1, rows + 1), numpy.linspace(0, 1, 2 * rows + 1),
                          indexing="ij")
    a, b = 2 * numpy.pi * u, numpy.pi * v
    bump = radius * (1 + 0.05 * numpy.sin(17 * a) * numpy.sin(13 * b))
    points = numpy.stack([numpy.sin(b) * numpy.cos(a), numpy.cos(b), numpy.sin(b) * numpy.sin(a)], -1)
    points = points * bump[..., None] + numpy.asarray(centre)
    first = (numpy.arange(rows)[:, None] * (2 * rows + 1) + numpy.arange(2 * rows)).ravel()
    below = first + 2 * rows + 1
    order = numpy.stack([first, first + 1, below, first + 1, below + 1, below], -1)
    return points.reshape(-1, 3).astype("<f4"), order.ravel().astype("<u4")


def write_balls(path, rows):
    """Writes a field of 8 × 8 balls, each a mesh, under a lamp; returns the number of triangles."""
    views, accessors, meshes, data, size = [], [], [], [], 0

    def add(array, kind, count, **more):
        nonlocal size
        views.append({"buffer": 0, "byteOffset": size, "byteLength": array.nbytes})
        accessors.append({"bufferView": len(views) - 1, "count": count, "type": kind,
                          "componentType": 5126 if kind == "VEC3" else 5125, **more})
        data.append(array.tobytes())
        size += array.nbytes
        return len(accessors) - 1

    for i in range(64):
        points, order = ball((i % 8 - 3.5, 0.3 * ((i * 37) % 5), i // 8 - 3.5), 0.45, rows)
        position = add(points, "VEC3", len(points), min=points.min(0).tolist(),
                       max=points.max(0).tolist())
        meshes.append({"primitives": [{"attributes": {"POSITION": position},
                                       "indices": add(order, "SCALAR", len(order))}]})
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(65))}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}},
        "nodes": [{"mesh": i} for i in range(64)] +
                 [{"rotation": [-0.5, 0.2, 0.1, 0.8366600265340756],
                   "extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "meshes": meshes, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": size}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + size))
        file.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", size, 0x004E4942))
        for part in data:
            file.write(part)
    return 64 * 4 * rows * rows


def measure_triangles(program, size, largest):
    """Times each scene with `sightline compare`, in which the methods take turns on one thread."""
    scenes = []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "balls.glb")
        for rows in ROWS:
            if 256 * rows * rows > largest:
                break
            triangles = write_balls(path, rows)
            names = [name for name, limit, *_ in METHODS if triangles <= limit]
            run(program, "compare", path, "--env", "none", "--size", size, "--samples", "1",
                "--methods", ",".join(names), "--report", folder, "--quiet")
            results = read(os.path.join(folder, "results.json"))
            scenes.append({"triangles": triangles, "methods": {
                method["name"]: {"wrong": method["total"]["wrong"], "kinds": {
                    kind: method["kinds"][kind]["ns_per_ray_rounds"] for kind in KINDS
                    if method["kinds"].get(kind, {}).get("rays")}}
                for method in results["methods"]}})
    return {"kind": "triangles", "size": size, "scenes": scenes}


def draw_history(data, out):
    figure, ((panel,),) = style.panels(1, 1, 7.2, 4.6)
    panel.set_yscale("log")
    years, seconds, names = zip(*PAST)
    panel.plot(years, seconds, color=style.GUIDE, marker="o")
    for year, value, name in PAST:
        panel.annotate(name, (year, value), xytext=(7, 4), textcoords="offset points", fontsize=9)
    looks = zip(style.COLORS, style.MARKERS, ("top", "bottom"))
    for (name, runs), (color, marker, side) in zip(data["seconds"].items(), looks):
        middle = statistics.median(runs)
        panel.errorbar([data["year"]], [middle],
                       yerr=[[middle - min(runs)], [max(runs) - middle]], color=color, marker=marker)
        panel.annotate(f"Sightline, {data['threads']} threads,\n{name}: {middle:.2g} s",
                       (data["year"], middle), xytext=(7, 0), textcoords="offset points",
                       va=side, fontsize=9, color=color)
    panel.set_xlim(1976, data["year"] + 18)
    panel.set_ylabel("seconds for the picture")
    panel.set_title("Whitted's spheres over the checkerboard, 640×480")
    style.save(figure, out)


def draw_triangles(data, out):
    kinds = [k for k in KINDS if any(k in m["kinds"] for s in data["scenes"]
                                     for m in s["methods"].values())]
    figure, (panels,) = style.panels(1, len(kinds), 4.6 * len(kinds), 4.6)
    times = [t for s in data["scenes"] for m in s["methods"].values() for k in m["kinds"].values()
             for t in k]
    for panel, kind in zip(panels, kinds):
        panel.set_xscale("log")
        panel.set_yscale("log")
        for name, _, title, line in METHODS:
            color, marker, fill = style.look_of(name)
            points = [(s["triangles"], s["methods"][name]["kinds"][kind]) for s in data["scenes"]
                      if kind in s["methods"].get(name, {"kinds": {}})["kinds"]]
            x, runs = [p[0] for p in points], [p[1] for p in points]
            y = [statistics.median(r) for r in runs]
            whiskers = [[m - min(r) for m, r in zip(y, runs)], [max(r) - m for m, r in zip(y, runs)]]
            panel.errorbar(x, y, yerr=whiskers, color=color, marker=marker, mfc=fill, ls=line,
                           label=title, elinewidth=0.8)
        panel.set_title(f"{kind} rays")
        panel.set_xlabel("triangles")
        panel.set_ylim(min(times) / 1.5, max(times) * 1.5)
    panels[0].set_ylabel("ns a ray, one thread")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=3, frameon=False,
                  bbox_to_anchor=(0.5, -0.005))
    style.save(figure, out)
