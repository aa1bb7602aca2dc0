#!/usr/bin/env python3
"""A stderr that is closed, full or a broken pipe costs messages, never pictures.

streams_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENES = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scenes")
BROKEN = {"closed": "2>&-", "full": "2>/dev/full", "a broken pipe": "2> >(exec true; sleep 0)"}


class Streams(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-streams-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        os.makedirs(os.path.join(self.folder, "in"))
        with open(os.path.join(SCENES, "whitted.gltf"), encoding="utf-8") as file:
            asset = json.load(file)
        asset["extensionsUsed"] = asset.get("extensionsUsed", []) + ["UNKNOWN_extension"]
        for name, content in (("a", json.dumps(asset)), ("b", "not a glTF file"), ("c", json.dumps(asset))):
            with open(os.path.join(self.folder, "in", name + ".gltf"), "w", encoding="utf-8") as file:
                file.write(content)

    def run_with(self, redirection, *arguments):
        """Exit code of the program with that stderr."""
        command = f'"$0" "$@" {redirection}'
        return subprocess.run(["bash", "-c", command, PROGRAM, *arguments], cwd=self.folder,
                              stdout=subprocess.DEVNULL, timeout=120, check=False).returncode

    def test_a_render_with_warnings_writes_its_picture(self):
        for name, redirection in BROKEN.items():
            with self.subTest(name):
                picture = name.replace(" ", "-") + ".png"
                self.assertEqual(self.run_with(redirection, "render", "in/a.gltf", "-o", picture, "--size",
                                               "16x16", "--samples", "1", "--aov", "depth"), 0)
                with open(os.path.join(self.folder, picture), "rb") as file:
                    content = file.read()
                # Nothing but the picture is in the file, although its descriptor may be free.
                self.assertTrue(content.startswith(b"\x89PNG"))
                self.assertNotIn(b"warning", content)

    def test_an_error_keeps_its_exit_code(self):
        for name, redirection in BROKEN.items():
            with self.subTest(name):
                self.assertEqual(self.run_with(redirection, "render", "in/b.gltf", "-o", "b.png"), 1)
                self.assertEqual(self.run_with(redirection, "render", "--nonsense"), 2)

    def test_a_batch_with_faults_renders_the_rest(self):
        for name, redirection in BROKEN.items():
            with self.subTest(name):
                out = name.replace(" ", "-")
                self.assertEqual(self.run_with(redirection, "batch", "in", "--out", out, "--size", "16x16",
                                               "--samples", "1"), 3)
                found = [n for n in os.listdir(os.path.join(self.folder, out)) if n.endswith(".png")]
                self.assertEqual(sorted(found), ["a.png", "c.png"])


if __name__ == "__main__":
    unittest.main()
