#!/usr/bin/env python3
"""`sightline compare` as a program: compare_test.py SIGHTLINE."""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENES = os.path.join(ROOT, "scenes")


class Compare(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def results(self):
        with open(self.path("report/results.json"), encoding="utf-8") as file:
            return json.load(file)

    def test_an_interrupted_comparison_reports_what_was_judged(self):
        command = [PROGRAM, "compare", os.path.join(SCENES, "table.gltf"), "--report",
                   self.path("report"), "--size", "200x150", "--methods", "exact", "--rounds", "1",
                   "--quiet", "--overwrite"]
        delay = 0.5
        while not os.path.exists(self.path("report/results.json")):
            with subprocess.Popen(command, text=True, stderr=subprocess.PIPE) as process:
                time.sleep(delay)
                process.send_signal(signal.SIGINT)
                _, message = process.communicate(timeout=200)
            self.assertEqual(process.returncode, 1, message)
            delay *= 1.5
        self.assertRegex(message, r"interrupted; the report in \S+ is of \d+ of \d+ rays")
        results = self.results()
        judged = results["methods"][0]["total"]["rays"]
        self.assertGreater(results["rays_left"], 0)
        self.assertEqual(judged + results["rays_left"], sum(results["rays"].values()))
        self.assertEqual(results["methods"][0]["total"]["unchecked"], 0)

    def compare(self, *options):
        return subprocess.run([PROGRAM, "compare", os.path.join(SCENES, "area_light_box.gltf"),
                               "--report", self.path("report"), "--overwrite", "--rounds", "1",
                               *options], capture_output=True, text=True, timeout=200)

    @unittest.skipIf(subprocess.run(["/usr/bin/python3", "-c", "import matplotlib"],
                                    capture_output=True).returncode, "matplotlib is not installed")
    def test_charts_are_drawn_whatever_python_comes_first_in_the_path(self):
        os.mkdir(self.path("bin"))
        with open(self.path("bin/python3"), "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nexit 3\n")
        os.chmod(self.path("bin/python3"), 0o755)
        done = subprocess.run([PROGRAM, "compare", os.path.join(SCENES, "table.gltf"), "--report", self.path("report"),
                               "--size", "16x16", "--rounds", "1", "--methods", "exact", "--quiet"],
                              capture_output=True, text=True, timeout=200,
                              env={**os.environ, "PATH": self.path("bin") + ":" + os.environ["PATH"]})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(os.path.exists(self.path("report/chart-price.svg")))

    def test_aimed_rays_find_what_random_rays_do_not(self):
        aim = "--aim", "vertices,edges,silhouettes,surface", "--aim-rays", "4000"
        methods = "--methods", "embree-default,exact"
        done = self.compare(*aim, *methods, "--max-wrong", "1000000", "--record-rays",
                            self.path("rays"), "--verdicts", self.path("verdicts"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"(?m)^3 engines answered the same 4,000 rays of area_light_box.gltf: ")
        first = self.results()
        totals = {method["name"]: method["total"] for method in first["methods"]}
        self.assertEqual(totals["exact"]["wrong"], 0)
        self.assertGreater(totals["embree-default"]["wrong"], 10)
        self.assertEqual(sum(first["rays"].values()), 4000)
        self.check_verdicts(totals)
        # The same rays from their file, and other rays from another seed.
        self.compare("--rays", self.path("rays"), *methods, "--max-wrong", "1000000")
        for one, two in zip(first["methods"], self.results()["methods"]):
            for field in ("wrong", "same", "undecidable"):
                self.assertEqual(one["total"][field], two["total"][field])
        self.compare(*aim, *methods, "--aim-seed", "2", "--max-wrong", "1000000")
        self.assertNotEqual([m["total"]["same"] for m in self.results()["methods"]],
                            [m["total"]["same"] for m in first["methods"]])

    def check_verdicts(self, totals):
        """The file has as many of each verdict as the report."""
        sys.path.insert(0, os.path.join(ROOT, "tools", "engines"))
        try:
            import lab_files
        except ImportError:
            return  # without NumPy
        verdicts = lab_files.read_verdicts(self.path("verdicts"))
        self.assertEqual(set(verdicts), set(totals))
        for name, total in totals.items():
            for code, verdict in enumerate(lab_files.VERDICTS):
                self.assertEqual(int((verdicts[name] == code).sum()), total[verdict], (name, verdict))

    def test_aims_are_checked(self):
        done = self.compare("--aim", "corners")
        self.assertEqual(done.returncode, 2)
        self.assertIn("there is no aim 'corners'; there are vertices, edges", done.stderr)
        done = self.compare("--aim-rays", "5")
        self.assertEqual(done.returncode, 2)
        with open(self.path("empty.gltf"), "w", encoding="utf-8") as file:
            file.write('{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}')
        empty = subprocess.run([PROGRAM, "compare", self.path("empty.gltf"), "--report",
                                self.path("report"), "--overwrite", "--aim", "edges"],
                               capture_output=True, text=True, timeout=100)
        self.assertEqual(empty.returncode, 1)
        self.assertIn("there are no triangles to aim at", empty.stderr)


if __name__ == "__main__":
    unittest.main()
