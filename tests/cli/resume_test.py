#!/usr/bin/env python3
"""Kept tiles: a killed render continues, parts are merged, and the bits are the same."""
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
SAMPLES = "1" if "asan" in PROGRAM or "fuzz" in PROGRAM else "4"  # sanitizers are ten times slower
NAMES = ("a.exr", "a.png")
TILES = "a.exr.tiles"


class ResumeTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-resume-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        shutil.copy(os.path.join(SCENES, "whitted.gltf"), self.folder)

    def command(self, *options, size="320x200", samples=SAMPLES):
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
        """The bytes of the pictures, which are removed."""
        found = []
        for name in NAMES:
            with open(self.path(name), "rb") as file:
                found.append(file.read())
            os.remove(self.path(name))
        return found

    def kept(self):
        """Size of the kept tiles in bytes."""
        if not os.path.isdir(self.path(TILES)):
            return 0
        return sum(os.path.getsize(self.path(TILES, n)) for n in os.listdir(self.path(TILES)))

    def end_after(self, kept, signal_number):
        """Starts a render and sends it the signal once that many bytes are kept."""
        process = subprocess.Popen(self.command("--resume"), cwd=self.folder,
                                   stderr=subprocess.DEVNULL)
        while process.poll() is None and self.kept() < kept:
            time.sleep(0.001)
        process.send_signal(signal_number)
        return process.wait()

    def test_a_render_killed_at_any_time_continues_to_the_same_bits(self):
        self.render()
        undisturbed = self.pictures()
        chance = random.Random(4)
        interrupted = 0
        for how in [signal.SIGKILL] * 4 + [signal.SIGTERM, signal.SIGINT]:
            ended, least = 0, 0
            while not os.path.exists(self.path("a.png")) and ended < 4:
                status = self.end_after(least + chance.randrange(1, 1 << 20), how)
                ended += 1
                if status == 0:
                    break
                interrupted += 1
                self.assertEqual(status, 1 if how != signal.SIGKILL else -signal.SIGKILL)
                self.assertFalse(os.path.exists(self.path("a.exr")))
                self.assertGreaterEqual(self.kept(), least)
                least = self.kept()
            if not os.path.exists(self.path("a.png")):
                self.render("--resume")
            self.assertEqual(self.pictures(), undisturbed)
            self.assertFalse(os.path.exists(self.path(TILES)))
        self.assertGreaterEqual(interrupted, 6)
        self.assertEqual(os.listdir(self.folder), ["whitted.gltf"])

    def test_damaged_tiles_are_traced_again(self):
        self.render()
        undisturbed = self.pictures()
        for index in range(1, 3):
            self.render("--render-part", f"{index}/2")
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
        self.assertIn("1 files of tiles belong to another picture", warning)
        self.assertEqual(self.pictures(), undisturbed)

    def test_parts_merge_to_the_same_bits_once_all_exist(self):
        self.render()
        undisturbed = self.pictures()
        for index in (3, 1, 4):
            self.render("--render-part", f"{index}/4")
        self.assertIn("65 tiles are missing", self.render("--merge-parts", status=1))
        first = self.kept()
        self.render("--render-part", "4/4")  # a part may be rendered twice
        self.assertEqual(self.kept(), first)
        self.render("--render-part", "2/4")
        self.render("--merge-parts")
        self.assertEqual(self.pictures(), undisturbed)
        self.assertFalse(os.path.exists(self.path(TILES)))

    def test_parts_of_a_crop_that_cuts_tiles_merge_to_the_same_bits(self):
        crop = ("--crop", "13,7,150,101", "--error", "0.05", "--max-samples", "8")
        picture = [word for word in self.command(*crop) if word not in ("--samples", SAMPLES)]

        def render(*options):
            subprocess.run([*picture, *options], cwd=self.folder, check=True)

        render()
        undisturbed = self.pictures()
        for index in (2, 1):
            render("--render-part", f"{index}/2")
        render("--merge-parts")
        self.assertEqual(self.pictures(), undisturbed)

    def test_layers_of_every_type_are_kept(self):
        layers = ("--aov", "depth,object,cryptomatte,lights", "--exr-type", "half",
                  "--exr-layout", "tiled", "--exr-parts", "multi")
        self.render(*layers, samples="2")
        undisturbed = self.pictures()
        self.render("--render-part", "1/1", *layers, samples="2")
        self.render("--merge-parts", *layers, samples="2")
        self.assertEqual(self.pictures(), undisturbed)

    def test_tiles_of_other_options_or_files_are_not_used(self):
        self.render("--render-part", "1/1", samples="2")
        self.render()
        undisturbed = self.pictures()
        self.assertIn("another picture", self.render("--resume"))
        self.assertEqual(self.pictures(), undisturbed)
        self.render("--render-part", "1/1")
        self.render("--merge-parts", "--tone-map", "aces")  # the tiles do not depend on the tone map
        self.render("--render-part", "1/1")
        with open(self.path("whitted.gltf"), "a", encoding="utf-8") as file:
            file.write("\n")
        self.assertIn("tiles are missing", self.render("--merge-parts", status=1))

    def test_options_that_exclude_each_other_are_a_usage_error(self):
        for options in (("--render-part", "0/4"), ("--render-part", "5/4"), ("--render-part", "x"),
                        ("--render-part", "1/2", "--merge-parts"), ("--resume", "--record-rays", "r")):
            self.render(*options, status=2)


if __name__ == "__main__":
    unittest.main()
