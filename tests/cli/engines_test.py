#!/usr/bin/env python3
"""An engine in NumPy is judged by way of files, as docs/engines.md shows: engines_test.py SIGHTLINE."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(sys.argv.pop(1))
# The interpreter that Debian's python3-numpy belongs to.
PYTHON = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable


def has_numpy():
    return subprocess.run([PYTHON, "-c", "import numpy"], capture_output=True).returncode == 0


def run(*command):
    return subprocess.run(command, capture_output=True, text=True)


@unittest.skipUnless(has_numpy(), "python3-numpy is not installed")
class Engines(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.scene = os.path.join(ROOT, "scenes", "area_light_box.gltf")

    def path(self, name):
        return os.path.join(self.folder, name)

    def compare(self, *options):
        return run(PROGRAM, "compare", self.scene, "--rounds", "1", "--methods", "exact", *options)

    def exchange(self, *options):
        """Records, lets the NumPy engine answer and returns its row of the report."""
        recorded = self.compare("--report", self.path("recorded"), "--size", "24x18",
                                "--record-rays", self.path("rays"))
        self.assertEqual(recorded.returncode, 0, recorded.stderr)
        exported = self.compare("--export-triangles", self.path("triangles"), *options)
        self.assertEqual(exported.returncode, 0, exported.stderr)
        answered = run(PYTHON, os.path.join(ROOT, "tools", "engines", "brute_force"),
                       self.path("triangles"), self.path("rays"), self.path("answers"))
        self.assertEqual(answered.returncode, 0, answered.stderr)
        judged = self.compare("--rays", self.path("rays"), "--report", self.path("report"),
                              "--answers", "numpy=" + self.path("answers"), *options)
        self.assertEqual(judged.returncode, 0, judged.stderr)
        with open(self.path("report/results.json")) as file:
            methods = {m["name"]: m for m in json.load(file)["methods"]}
        return methods["numpy"]["total"]

    def test_doubles_in_numpy_are_right_but_at_edges(self):
        total = self.exchange()
        self.assertGreater(total["rays"], 432)
        self.assertGreater(total["same"], 0.98 * total["rays"])
        self.assertEqual(total["wrong_t"] + total["wrong_uv"], 0)
        self.assertGreater(total["ns_per_ray"], 0)

    def test_flattened_triangles_are_judged_as_such(self):
        total = self.exchange("--flatten")
        self.assertGreater(total["same"], 0.98 * total["rays"])

    def test_answers_to_the_flattened_scene_are_refused_without_the_option(self):
        self.scene = os.path.join(ROOT, "scenes", "alpha_instances.gltf")
        self.exchange("--flatten")
        judged = self.compare("--rays", self.path("rays"), "--report", self.path("other"),
                              "--answers", "numpy=" + self.path("answers"))
        self.assertEqual(judged.returncode, 1)
        self.assertIn("belong to another scene", judged.stderr)
        self.assertEqual(judged.stderr.count("\n"), 1)

    def test_the_atlas_judges_answers_to_its_rays(self):
        atlas = [PROGRAM, "atlas", "--families", "T2", "--methods", "exact", "--rays", "60",
                 "--rounds", "1"]
        dumped = run(*atlas, "--dump", self.path("hard"))
        self.assertEqual(dumped.returncode, 0, dumped.stderr)
        stem = self.path("hard/T2-0")
        answered = run(PYTHON, os.path.join(ROOT, "tools", "engines", "brute_force"),
                       stem + ".triangles", stem + ".rays", stem + ".answers")
        self.assertEqual(answered.returncode, 0, answered.stderr)
        judged = run(*atlas, "--answers", "numpy=" + self.path("hard"), "--report",
                     self.path("report"))
        self.assertEqual(judged.returncode, 0, judged.stderr)
        with open(self.path("report/results.json")) as file:
            knobs = json.load(file)["families"][0]["knobs"]
        scores = [{m["name"]: m for m in knob["methods"]} for knob in knobs]
        self.assertEqual(scores[0]["numpy"]["wrong"], 0)
        self.assertTrue(all("numpy" not in score for score in scores[1:]))
        # With another seed they are answers to other rays.
        other = run(*atlas, "--answers", "numpy=" + self.path("hard"), "--seed", "2")
        self.assertEqual(other.returncode, 1)
        self.assertEqual(other.stderr.count("\n"), 1, other.stderr)

    def test_a_value_without_a_name_and_answers_without_rays_are_usage_errors(self):
        for options in (["--answers", "x"], ["--answers", "a=b"]):
            result = self.compare("--report", self.path("report"), *options)
            self.assertEqual(result.returncode, 2, result.stderr)


if __name__ == "__main__":
    unittest.main()
