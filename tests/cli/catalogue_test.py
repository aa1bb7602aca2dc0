#!/usr/bin/env python3
"""The commands of docs/catalogue.md make what the page says, in small.

catalogue_test.py PROGRAM [unittest's arguments]
"""
import os
import re
import shlex
import subprocess
import sys
import unittest

import batch_test
import example_test

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def commands():
    """Those of the page's first block, one a line."""
    with open(os.path.join(ROOT, "docs", "catalogue.md"), encoding="utf-8") as file:
        block = re.search(r"^```\n(.*?)^```", file.read(), re.M | re.S).group(1)
    return [shlex.split(line) for line in block.splitlines()]


def corner(picture):
    """The first pixel, which no filter of PNG changes, of a picture that has four channels if the batch's
    background is transparent."""
    size, rows = example_test.png_bytes(picture)
    channels = (len(rows) // size[1] - 1) // size[0]
    return tuple(rows[1:1 + channels])


class Catalogue(batch_test.BatchTest):
    def setUp(self):
        super().setUp()
        for name in ("chair.gltf", "lamps/lamp.gltf"):
            self.add(name)

    def run_in_small(self, command):
        """Runs a command of the page with small pictures; returns their paths by name."""
        self.assertEqual(command[0], "sightline")
        small = [re.sub(r"^\d+$", "24", w) if before == "--size" else w
                 for before, w in zip(command, command[1:])]
        done = subprocess.run([batch_test.PROGRAM, *small, "--samples", "1"], capture_output=True, text=True,
                              cwd=self.folder, timeout=250)
        self.assertEqual(done.returncode, 0, done.stderr)
        out = self.path(command[command.index("--out") + 1])
        return {name: os.path.join(out, name) for name in batch_test.pictures(out)}

    def test_views_on_white(self):
        found = self.run_in_small(commands()[0])
        self.assertEqual(sorted(found), sorted(f"{asset}_{view}.png" for asset in ("chair", "lamps/lamp")
                                               for view in ("three-quarter", "front")))
        for picture in found.values():
            self.assertEqual(corner(picture), (255, 255, 255))

    def test_cut_outs(self):
        found = self.run_in_small(commands()[1])
        self.assertEqual(sorted(found), ["chair.png", "lamps/lamp.png"])
        for picture in found.values():
            self.assertEqual(corner(picture)[3], 0)

    def test_turntables(self):
        found = self.run_in_small(commands()[2])
        self.assertEqual(len(found), 2 * 36)
        self.assertEqual(len({name.rpartition("/")[0] for name in found}), 2)


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
