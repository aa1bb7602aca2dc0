#!/usr/bin/env python3
"""The commands of docs/catalogue.md make what the page says, in small.

catalogue_test.py PROGRAM [unittest's arguments]
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

import batch_test
import data_sets_test
import example_test
import films_test
import products_test

FFMPEG = shutil.which("ffmpeg")
ASSETS = ("chair", "desk_lamp")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def commands():
    """All lines of the page's blocks."""
    with open(os.path.join(ROOT, "docs", "catalogue.md"), encoding="utf-8") as file:
        blocks = re.findall(r"^```\n(.*?)^```", file.read(), re.M | re.S)
    return [shlex.split(line) for block in blocks for line in block.splitlines()]


def command_with(*words):
    """The only command that has these words."""
    found = [c for c in commands() if set(words) <= set(c)]
    assert len(found) == 1, found
    return found[0]


def corner(picture):
    """The first pixel, which no filter of PNG changes, of a picture that has four channels if the batch's
    background is transparent."""
    size, rows = example_test.png_bytes(picture)
    channels = (len(rows) // size[1] - 1) // size[0]
    return tuple(rows[1:1 + channels])


class Catalogue(batch_test.BatchTest):
    @classmethod
    def setUpClass(cls):
        cls.products = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.products.cleanup)
        products_test.make_products(cls.products.name)

    def setUp(self):
        super().setUp()
        os.mkdir(self.path("assets"))
        for name in ASSETS:
            shutil.copy(os.path.join(self.products.name, name + ".glb"), self.path("assets"))

    def run_in_small(self, command, steps=None):
        """Runs a command of the page with small pictures; returns the paths of what it wrote by name."""
        self.assertEqual(command[0], "sightline")
        small = [re.sub(r"^\d+$", "24", w) if before == "--size" else w
                 for before, w in zip(command, command[1:])]
        redirections = [w for w in small if w in "<>"]
        if redirections:
            self.assertEqual(small[-4::2], ["<", ">"])
            source, target = (self.path("assets", small[-3]), self.path(small[-1]))
            small = small[:-4]
        with open(source if redirections else os.devnull, "rb") as given, \
                open(target if redirections else os.path.join(self.folder, "log"), "wb") as taken:
            done = subprocess.run([batch_test.PROGRAM, *small, "--samples", "1"], stdin=given, stdout=taken,
                                  stderr=subprocess.PIPE, text=True, cwd=self.folder, timeout=250)
        self.assertEqual(done.returncode, 0, done.stderr)
        if "--out" not in command:
            return {name: self.path(name) for name in os.listdir(self.folder)}
        out = self.path(command[command.index("--out") + 1])
        return {name: os.path.join(out, name) for name in batch_test.pictures(out)}

    def test_views_on_white(self):
        found = self.run_in_small(command_with("pictures"))
        self.assertEqual(sorted(found), sorted(f"{asset}_{view}.png" for asset in ASSETS
                                               for view in ("three-quarter", "front")))
        for picture in found.values():
            self.assertEqual(corner(picture), (255, 255, 255))

    @unittest.skipUnless(FFMPEG, "ffmpeg is not installed")
    def test_films(self):
        found = self.run_in_small(command_with("films"))
        self.assertEqual(sorted(found), ["chair.mp4", "desk_lamp.mp4"])
        for film in found.values():
            self.assertEqual(int(films_test.ffprobe(film, "nb_read_frames")), 72)

    def test_data_sets(self):
        found = self.run_in_small(command_with("set"))
        self.assertEqual(sorted(found), sorted(
            f"{asset}_sphere24_{i:02}{layer}.png" for asset in ASSETS
            for i in range(1, 25) for layer in ("", ".depth", ".normal", ".mask")))
        for name in found:
            if name.endswith(".depth.png"):
                self.assertIn("sightline:scale", data_sets_test.read_png(found[name])[4])

    def test_cut_outs(self):
        found = self.run_in_small(command_with("cut-outs"))
        self.assertEqual(sorted(found), ["chair.png", "desk_lamp.png"])
        for picture in found.values():
            self.assertEqual(corner(picture)[3], 0)

    def test_turntables(self):
        found = self.run_in_small(command_with("turns"))
        for asset in ASSETS:
            self.assertEqual(sum(name.startswith(asset) for name in found), 36)

    @unittest.skipUnless(FFMPEG, "ffmpeg is not installed")
    def test_films_of_one_asset(self):
        for name, frames in (("turn.mp4", 72), ("bow.gif", 48)):
            found = self.run_in_small(command_with(name))
            self.assertEqual(int(films_test.ffprobe(found[name], "nb_read_frames")), frames)

    def test_standard_streams(self):
        found = self.run_in_small(command_with("chair.jpg"))
        with open(found["chair.jpg"], "rb") as file:
            self.assertEqual(file.read(3), b"\xff\xd8\xff")


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    if not FFMPEG:
        print("ffmpeg is not installed: films are not made in this test.")
    unittest.main()
