#!/usr/bin/env python3
"""Kept tiles: a render that is killed goes on, parts are joined, and the bits are the same."""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENES = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scenes")
NAMES = ("a.exr", "a.png")
TILES = "a.exr.tiles"


class ResumeTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-resume-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        shutil.copy(os.path.join(SCENES, "whitted.gltf"), self.folder)

    def command(self, *options, size="320x200", samples="16"):
        outputs = [word for name in NAMES for word in ("-o", name)]
        return [PROGRAM, "render", "whitted.gltf", *outputs, "--size", size, "--samples", samples,
                "--quiet", *options]

    def render(self, *options, status=0, **picture):
        done = subprocess.run(self.command(*options, **picture), cwd=self.folder, text=True,
                              capture_output=True, timeout=250)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def pictures(self):
        """The bytes of the pictures, which are taken away."""
        found = []
        for name in NAMES:
            with open(self.path(name), "rb") as file:
                found.append(file.read())
            os.remove(self.path(name))
        return found

    def kept(self):
        """Bytes of kept tiles."""
        if not os.path.isdir(self.path(TILES)):
            return 0
        return sum(os.path.getsize(self.path(TILES, n)) for n in os.listdir(self.path(TILES)))

    def end_after(self, kept, how):
        """Starts a render and ends it by the signal when so many bytes are kept."""
        process = subprocess.Popen(self.command("--resume"), cwd=self.folder,
                                   stderr=subprocess.DEVNULL)
        while process.poll() is None and self.kept() < kept:
            time.sleep(0.001)
        process.send_signal(how)
        return process.wait()

    def test_killed_at_any_instant_it_goes_on_to_the_same_bits(self):
        self.render()
        undisturbed = self.pictures()
        chance = random.Random(4)
        for how in [signal.SIGKILL] * 4 + [signal.SIGTERM, signal.SIGINT]:
            ended, least = 0, 0
            while not os.path.exists(self.path("a.png")) and ended < 4:
                status = self.end_after(least + chance.randrange(1, 1 << 20), how)
                ended += 1
                if status == 0:
                    break
                self.assertEqual(status, 1 if how != signal.SIGKILL else -signal.SIGKILL)
                self.assertFalse(os.path.exists(self.path("a.exr")))
                self.assertGreaterEqual(self.kept(), least)
                least = self.kept()
            if not os.path.exists(self.path("a.png")):
                self.render("--resume")
            self.assertEqual(self.pictures(), undisturbed)
            self.assertFalse(os.path.exists(self.path(TILES)))
        self.assertEqual(os.listdir(self.folder), ["whitted.gltf"])

    def test_what_is_kept_is_not_traced_again_and_damage_is(self):
        self.render()
        undisturbed = self.pictures()
        for index in range(1, 3):
            self.render("--part", f"{index}/2")
        names = sorted(os.listdir(self.path(TILES)))
        self.assertEqual(len(names), 2)
        # A torn end, a file of zeros, and a flipped bit.
        with open(self.path(TILES, names[0]), "r+b") as file:
            size = os.path.getsize(file.name)
            file.seek(size // 2)
            byte = file.read(1)
            file.seek(size // 2)
            file.write(bytes([byte[0] ^ 1]))
            file.truncate(size - 100)
        with open(self.path(TILES, "zeros"), "wb") as file:
            file.write(bytes(1000))
        warning = self.render("--resume")
        self.assertIn("1 files of tiles are of another picture", warning)
        self.assertEqual(self.pictures(), undisturbed)

    def test_parts_join_to_the_same_bits_only_when_all_are_there(self):
        self.render()
        undisturbed = self.pictures()
        for index in (3, 1, 4):
            self.render("--part", f"{index}/4")
        self.assertIn("65 tiles are missing", self.render("--join", status=1))
        first = self.kept()
        self.render("--part", "4/4")  # twice does no harm
        self.assertEqual(self.kept(), first)
        self.render("--part", "2/4")
        self.render("--join")
        self.assertEqual(self.pictures(), undisturbed)
        self.assertFalse(os.path.exists(self.path(TILES)))

    def test_a_crop_that_cuts_tiles_is_kept_and_joined_too(self):
        crop = ("--crop", "13,7,150,101", "--error", "0.05", "--max-samples", "8")
        picture = [word for word in self.command(*crop) if word not in ("--samples", "16")]

        def render(*options):
            subprocess.run([*picture, *options], cwd=self.folder, check=True)

        render()
        undisturbed = self.pictures()
        for index in (2, 1):
            render("--part", f"{index}/2")
        render("--join")
        self.assertEqual(self.pictures(), undisturbed)

    def test_layers_of_every_kind_are_kept(self):
        layers = ("--aov", "depth,object,cryptomatte,lights", "--exr-type", "half",
                  "--exr-layout", "tiled", "--exr-parts", "multi")
        self.render(*layers, samples="2")
        undisturbed = self.pictures()
        self.render("--part", "1/1", *layers, samples="2")
        self.render("--join", *layers, samples="2")
        self.assertEqual(self.pictures(), undisturbed)

    def test_tiles_of_other_options_or_files_are_not_used(self):
        self.render("--part", "1/1", samples="1")
        self.render()
        undisturbed = self.pictures()
        self.assertIn("another picture", self.render("--resume"))
        self.assertEqual(self.pictures(), undisturbed)
        self.render("--part", "1/1")
        self.render("--join", "--tone-map", "aces")  # what the tiles do not depend on may change
        self.render("--part", "1/1")
        with open(self.path("whitted.gltf"), "a", encoding="utf-8") as file:
            file.write("\n")
        self.assertIn("tiles are missing", self.render("--join", status=1))

    def test_options_that_do_not_go_together_are_refused(self):
        for options in (("--part", "0/4"), ("--part", "5/4"), ("--part", "x"),
                        ("--part", "1/2", "--join"), ("--resume", "--record-rays", "r")):
            self.render(*options, status=2)


if __name__ == "__main__":
    unittest.main()
