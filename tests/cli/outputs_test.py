#!/usr/bin/env python3
"""No output replaces an input or a file of other origin, whichever option names it.

outputs_test.py PROGRAM [unittest's arguments]
"""
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from batch_test import triangle

PROGRAM = os.path.abspath(sys.argv.pop(1))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SMALL = ["--size", "16x16", "--samples", "1"]


def textured_asset():
    """A triangle with the texture texture.png, and a second image that nothing uses."""
    asset = triangle()
    asset["images"] = [{"uri": "texture.png"}, {"uri": "unused.png"}]
    asset["textures"] = [{"source": 0}]
    asset["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    asset["meshes"][0]["primitives"][0]["material"] = 0
    return asset


class Outputs(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-outputs-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        scene = os.path.join(ROOT, "scenes", "whitted.gltf")
        for picture in ("texture.png", "unused.png", "sky.hdr"):
            self.run_program("render", scene, "-o", picture, *SMALL, "--quiet", status=0)
        with open(self.path("a.gltf"), "w", encoding="utf-8") as file:
            json.dump(textured_asset(), file)
        os.link(self.path("a.gltf"), self.path("hard.gltf"))
        os.symlink("a.gltf", self.path("soft.gltf"))

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def run_program(self, *arguments, status):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, text=True,
                              capture_output=True, timeout=120)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def hashes(self):
        """The hash of every file below the folder, links resolved."""
        return {os.path.join(path, name): hashlib.sha256(self.read(os.path.join(path, name))).digest()
                for path, _, names in os.walk(self.folder) for name in names}

    def check_refused(self, *arguments, output):
        before = self.hashes()
        message = self.run_program(*arguments, status=2)
        self.assertRegex(message, rf"^sightline: \S*{output}: would be written, but is also read.*\n$")
        self.assertLessEqual(before.items(), self.hashes().items())

    def test_render_replaces_no_input(self):
        render = ["render", "a.gltf", "--env", "sky.hdr", *SMALL, "--quiet"]
        free = ["-o", "free.png"]
        for output in ("texture.png", "unused.png", "sky.hdr"):
            self.check_refused(*render, "-o", output, output=output)
            self.check_refused(*render, "-o", "free.exr", "-o", "./" + output, output=output)
        for option in ("--stats", "--record-rays"):
            for output in ("a.gltf", "hard.gltf", "soft.gltf", "texture.png", "sky.hdr"):
                self.check_refused(*render, *free, option, output, output=output)

    def test_compare_replaces_no_input(self):
        for name, picture in (("index.html", "a.gltf"), ("results.json", "a.gltf")):
            os.makedirs(self.path(name + "-report"))
            os.link(self.path(picture), self.path(name + "-report", name))
            self.check_refused("compare", "a.gltf", "--report", name + "-report", *SMALL, "--quiet",
                               output=name)
        for output in ("a.gltf", "texture.png"):
            self.check_refused("compare", "a.gltf", "--report", "report", "--record-rays", output,
                               *SMALL, "--quiet", output=output)

    def test_batch_replaces_no_input(self):
        self.write("list.json", json.dumps({"assets": [{"path": "a.gltf"}]}))
        out = ["--out", "out", *SMALL, "--quiet"]
        self.check_refused("batch", "a.gltf", *out, "--log", "a.gltf", output="a.gltf")
        self.check_refused("batch", "a.gltf", *out, "--log", "sky.hdr", "--env", "sky.hdr",
                           output="sky.hdr")
        self.check_refused("batch", "--manifest", "list.json", *out, "--log", "list.json",
                           output="list.json")

    def test_a_batch_spares_the_textures_of_its_assets(self):
        texture = self.read("texture.png")
        self.run_program("batch", "a.gltf", "--out", ".", "--name", "texture", "--overwrite", *SMALL,
                         "--quiet", status=3)
        self.assertEqual(self.read("texture.png"), texture)
        outcome = json.loads(self.read("journal.jsonl").splitlines()[0])
        self.assertEqual(outcome["verdict"], "output-is-input")

    def test_a_batch_replaces_only_its_own_files(self):
        batch = ["batch", "a.gltf", "--out", "out", *SMALL, "--quiet"]
        for name in ("index.html", "a.png"):
            self.write("out/" + name, "someone's own")
            message = self.run_program(*batch, status=1)
            self.assertIn(f"out/{name}: was not made by this program; add --overwrite", message)
            self.assertEqual(self.read("out/" + name), b"someone's own")
            self.run_program(*batch, "--overwrite", status=0)
            self.assertNotEqual(self.read("out/" + name), b"someone's own")
            shutil.rmtree(self.path("out"))
        self.write("out/journal.jsonl", "someone's own\n")
        self.assertIn("is not the journal of a batch", self.run_program(*batch, "--resume", status=1))
        self.assertEqual(self.read("out/journal.jsonl"), b"someone's own\n")

    def test_a_batch_replaces_the_files_of_an_earlier_one(self):
        batch = ["batch", "a.gltf", "--out", "out", "--size", "16x16", "--quiet"]
        self.run_program(*batch, "--samples", "1", status=0)
        first = self.read("out/a.png")
        self.run_program(*batch, "--samples", "4", "--resume", status=0)
        self.assertNotEqual(self.read("out/a.png"), first)
        os.remove(self.path("out/journal.jsonl"))  # the claims remain
        self.run_program(*batch, "--samples", "1", status=0)
        self.assertEqual(self.read("out/a.png"), first)

    def test_links_in_the_output_folder_are_not_followed(self):
        batch = ["batch", "a.gltf", "--out", "out", *SMALL, "--quiet"]
        self.write("elsewhere/file", "someone's own")
        for name, target in (("index.html", "file"), ("a.png", "file"), ("journal.jsonl", "file"),
                             (".sightline", ".")):
            os.makedirs(self.path("out"))
            os.symlink(os.path.normpath(self.path("elsewhere", target)), self.path("out", name))
            self.run_program(*batch, status=1)
            if name in ("index.html", "a.png"):
                self.run_program(*batch, "--overwrite", status=0)
                self.assertFalse(os.path.islink(self.path("out", name)))
            self.assertEqual(os.listdir(self.path("elsewhere")), ["file"])
            self.assertEqual(self.read("elsewhere/file"), b"someone's own")
            shutil.rmtree(self.path("out"))
        os.makedirs(self.path("out"))
        os.symlink(self.path("elsewhere"), self.path("out/sub"))
        message = self.run_program(*batch, "--name", "sub/{asset}", status=1)
        self.assertIn("out/sub: is a link out of the folder", message)
        self.assertEqual(os.listdir(self.path("elsewhere")), ["file"])

    def test_reports_replace_only_their_own_files(self):
        for command in (["compare", "a.gltf", *SMALL, "--methods", "exact"],
                        ["atlas", "--families", "S1", "--rays", "20"]):
            command += ["--report", "report", "--quiet"]
            for name in ("index.html", "results.json", "results.csv", "chart-mine.svg"):
                self.write("report/" + name, "someone's own")
                message = self.run_program(*command, status=1)
                self.assertIn(f"report/{name}: was not made by this program", message)
                self.assertEqual(self.read("report/" + name), b"someone's own")
                os.remove(self.path("report", name))
            self.run_program(*command, status=0)
            self.run_program(*command, status=0)
            shutil.rmtree(self.path("report"))

    def interrupt(self, delay, *arguments):
        """Status, message and seconds until the end of a render that is interrupted after `delay`."""
        command = [PROGRAM, "render", os.path.join(ROOT, "scenes", "whitted.gltf"), *arguments]
        with subprocess.Popen(command, cwd=self.folder, text=True, stderr=subprocess.PIPE) as process:
            time.sleep(delay)
            process.send_signal(signal.SIGINT)
            begin = time.monotonic()
            _, message = process.communicate(timeout=120)
        return process.returncode, message, time.monotonic() - begin

    def test_an_interrupted_render_keeps_the_earlier_picture(self):
        earlier = {name: self.read(name) for name in ("texture.png", "sky.hdr")}
        outputs = [word for name in earlier for word in ("-o", name)]
        delay = 0.5
        while not os.path.exists(self.path("texture.partial.png")):
            status, message, _ = self.interrupt(delay, *outputs, "--size", "1024x1024", "--samples",
                                                "256", "--quiet")
            self.assertEqual(status, 1, message)
            for name, content in earlier.items():
                self.assertEqual(self.read(name), content)
            delay *= 2
        self.assertRegex(message, r"interrupted; \d+ of 4096 tiles are in texture.partial.png")
        self.assertTrue(os.path.exists(self.path("sky.partial.hdr")))

    def test_an_interrupted_render_of_any_size_ends_soon(self):
        # Writing the untraced rest of this picture takes a minute.
        status, message, seconds = self.interrupt(2, "-o", "big.exr", "--aov", "beauty", "--size",
                                                  "30000x30000", "--samples", "1", "--quiet")
        self.assertEqual(status, 1)
        self.assertIn("interrupted", message)
        self.assertLess(seconds, 15)  # 2 s on a machine that has nothing else to do
        self.assertFalse(os.path.exists(self.path("big.exr")))


if __name__ == "__main__":
    unittest.main()
