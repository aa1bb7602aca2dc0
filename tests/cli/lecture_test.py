#!/usr/bin/env python3
"""The charts that are measured and drawn by one command, small."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else ""


def charts(*arguments):
    return subprocess.run([os.path.join(ROOT, "tools/charts"), *arguments], capture_output=True,
                          text=True, env={**os.environ, "SIGHTLINE": PROGRAM})


@unittest.skipIf(subprocess.run(["/usr/bin/python3", "-c", "import matplotlib"],
                                capture_output=True).returncode, "matplotlib is not installed")
class Lecture(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def drawn(self, *arguments):
        """What was measured, and the drawing."""
        out = os.path.join(self.folder.name, "chart")
        data = out + ".json"
        run = charts(*arguments, "--data", data, out)
        self.assertEqual((0, ""), (run.returncode, run.stderr))
        with open(out + ".svg", encoding="utf-8") as file:
            drawing = file.read()
        with open(data, encoding="utf-8") as file:
            return json.load(file), drawing

    def test_times_whitteds_picture_beside_the_years_before(self):
        data, drawing = self.drawn("history", "--rounds", "1", os.path.join(ROOT, "scenes/whitted.gltf"))
        self.assertEqual({"one ray a pixel", "antialiased"}, set(data["seconds"]))
        for label in ("74 min", "1/30 s", "Sightline"):
            self.assertIn(label, drawing)

    def test_times_methods_among_more_and_more_triangles(self):
        data, drawing = self.drawn("triangles", "--size", "24x18", "--largest", "20000")
        self.assertEqual([1024, 16384], [scene["triangles"] for scene in data["scenes"]])
        for scene in data["scenes"]:
            self.assertEqual(0, scene["methods"]["exact"]["wrong"])
            self.assertLess({"embree", "embree-default", "embree-high"}, set(scene["methods"]))
        loop = [scene["methods"]["moller-trumbore:loop"]["kinds"]["camera"] for scene in data["scenes"]]
        self.assertGreater(min(loop[1]), 3 * max(loop[0]))  # sixteen times as many triangles
        self.assertIn("every triangle", drawing)

    def test_says_what_it_cannot_draw(self):
        run = charts("draw", os.path.join(ROOT, "scenes/whitted.gltf"), "out")
        self.assertEqual(1, run.returncode)
        self.assertIn("not a file of measurements by Sightline", run.stderr)


if __name__ == "__main__":
    unittest.main()
