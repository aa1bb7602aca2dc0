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


if __name__ == "__main__":
    unittest.main()
