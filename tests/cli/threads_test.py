#!/usr/bin/env python3
"""Pictures and verdicts of tiny models are the same for any number of threads.

Products of their coordinates are denormal numbers, so this holds only if all threads treat those
alike. Each run is a process of its own whose first parallel work is Embree's build, which flushes
denormal numbers to zero.
"""
import base64
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
SANITIZED = "asan" in PROGRAM or "fuzz" in PROGRAM  # ten times slower: fewer runs
THREADS = ((), ("--threads", "1"), ("--threads", "2"), ("--threads", "3"))[:2 if SANITIZED else 4]
RADII = (1e-9, 1e-12) if SANITIZED else (1e-9, 1e-10, 1e-11, 1e-12, 1e-13)


def ball(radius, columns=24, rows=12):
    """A glTF document with a closed ball."""
    points, triangles = [], []
    for row in range(rows + 1):
        for column in range(columns):
            polar, turn = math.pi * row / rows, 2 * math.pi * column / columns
            ring = 0.0 if row in (0, rows) else math.sin(polar)
            points += [radius * ring * math.cos(turn), radius * math.cos(polar),
                       radius * ring * math.sin(turn)]
    for row in range(rows):
        for column in range(columns):
            a, b = row * columns + column, row * columns + (column + 1) % columns
            c, d = a + columns, b + columns
            triangles += [a, b, c] * (row > 0) + [b, d, c] * (row < rows - 1)
    data = struct.pack(f"<{len(points)}f{len(triangles)}H", *points, *triangles)
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points) // 3, "type": "VEC3",
             "min": [min(points[i::3]) for i in range(3)],
             "max": [max(points[i::3]) for i in range(3)]},
            {"bufferView": 1, "componentType": 5123, "count": len(triangles), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 4 * len(points)},
                        {"buffer": 0, "byteOffset": 4 * len(points),
                         "byteLength": 2 * len(triangles)}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(data).decode("ascii")}]}


class ThreadsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-threads-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, radius):
        with open(self.path("ball.gltf"), "w", encoding="utf-8") as file:
            json.dump(ball(radius), file)

    def run_program(self, *words, statuses=(0,)):
        done = subprocess.run([PROGRAM, *words, "--quiet"], cwd=self.folder, text=True,
                              capture_output=True, timeout=100, check=False)
        self.assertIn(done.returncode, statuses, done.stderr)

    def picture(self, *threads):
        """The picture and every traced ray; an EXR would name the command, too."""
        self.run_program("render", "ball.gltf", "-o", "a.hdr", "--record-rays", "a.rays", "--size",
                         "64x64", "--samples", "1", "--camera", "fit", *threads)
        with open(self.path("a.hdr"), "rb") as picture, open(self.path("a.rays"), "rb") as rays:
            return picture.read(), rays.read()

    def verdicts(self, *threads):
        """The counts of every engine; the times in the report differ from run to run."""
        # 4: an engine is wrong more often than is allowed, which does not matter here.
        self.run_program("compare", "ball.gltf", "--report", "report", "--size", "24x24",
                         "--camera", "fit", "--methods", "exact,plucker,woop",
                         "--rounds", "1", *threads, statuses=(0, 4))
        with open(self.path("report/results.json"), encoding="utf-8") as file:
            methods = json.load(file)["methods"]
        return [{kind: {key: value for key, value in counts.items()
                        if not key.startswith("ns_") and key != "wrapper"}
                 for kind, counts in method["kinds"].items()} for method in methods]

    def test_pictures_of_tiny_models_do_not_depend_on_threads(self):
        for radius in RADII:
            self.write(radius)
            expected = self.picture(*THREADS[0])
            for threads in THREADS[1:]:
                self.assertTrue(self.picture(*threads) == expected, (radius, threads))

    def test_verdicts_on_tiny_models_do_not_depend_on_threads(self):
        for radius in RADII:
            self.write(radius)
            expected = self.verdicts(*THREADS[0])
            for threads in THREADS[1:]:
                self.assertEqual(self.verdicts(*threads), expected, (radius, threads))


if __name__ == "__main__":
    unittest.main()
