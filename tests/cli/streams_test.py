#!/usr/bin/env python3
"""A stderr that is closed, full or a broken pipe costs messages, never pictures; scenes from standard input, pictures
to standard output, and progress for programs.

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


SMALL = ["--size", "16x16", "--samples", "1"]


class Setting(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-streams-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scratch = os.path.join(self.folder, "scratch")
        os.makedirs(self.scratch)
        with open(os.path.join(SCENES, "whitted.gltf"), "rb") as file:
            self.scene = file.read()

    def run_program(self, *arguments, status=0, given=None, **streams):
        done = subprocess.run([PROGRAM, *arguments], cwd=self.folder, input=given, check=False, timeout=120,
                              stderr=subprocess.PIPE, **{"stdout": subprocess.PIPE, **streams},
                              env=dict(os.environ, TMPDIR=self.scratch))
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(os.listdir(self.scratch), [])
        return done.stdout, done.stderr.decode()

    def read(self, name):
        with open(os.path.join(self.folder, name), "rb") as file:
            return file.read()


class StandardStreams(Setting):
    def test_a_picture_is_the_same_through_pipes_and_files(self):
        scene = os.path.join(SCENES, "whitted.gltf")
        for ending in ("png", "jpg", "webp", "tif", "hdr"):
            self.run_program("render", scene, "-o", "a." + ending, *SMALL)
            out, errors = self.run_program("render", "-", "-o", "-", "--format", ending, *SMALL, given=self.scene)
            self.assertEqual(out, self.read("a." + ending))
            self.assertIn("camera: ", errors)  # the summary
        self.assertEqual(self.run_program("render", "-", "-o", "-", *SMALL, given=self.scene)[0], self.read("a.png"))
        out, _ = self.run_program("render", "-", "-o", "-", "--format", "exr", "-o", "b.exr", *SMALL,
                                  given=self.scene)
        self.assertEqual(out, self.read("b.exr"))

    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_a_film_is_the_same_through_pipes_and_files(self):
        for ending in ("mp4", "gif", "webp"):
            self.run_program("render", "-", "-o", "a." + ending, "--turntable", "2", *SMALL, given=self.scene)
            out, _ = self.run_program("render", "-", "-o", "-", "--format", ending, "--turntable", "2", *SMALL,
                                      given=self.scene)
            self.assertEqual(out, self.read("a." + ending))

    def test_views_of_standard_input_are_named_stdin(self):
        self.run_program("render", "-", "-o", "{stem}_{view}.png", "--views", "front,top", *SMALL, given=self.scene)
        self.assertEqual(sorted(n for n in os.listdir(self.folder) if n.endswith(".png")),
                         ["stdin_front.png", "stdin_top.png"])

    def test_standard_input_cannot_refer_to_files(self):
        asset = json.loads(self.scene)
        asset["buffers"] = [{"uri": "a.bin", "byteLength": 36}]
        asset["bufferViews"] = [{"buffer": 0, "byteLength": 36}]
        asset["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                               "min": [0, 0, 0], "max": [1, 1, 1]}]
        asset["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}]}]
        asset["nodes"], asset["scenes"] = [{"mesh": 0}], [{"nodes": [0]}]
        with open(os.path.join(self.folder, "a.bin"), "wb") as file:
            file.write(bytes(36))
        _, errors = self.run_program("render", "-", "-o", "a.png", *SMALL, status=1,
                                     given=json.dumps(asset).encode())
        self.assertEqual(errors, "sightline: standard input: buffers[0].uri: 'a.bin' names another file, which "
                                 "standard input cannot have beside it; give the asset as one .glb, or its path\n")
        self.assertFalse(os.path.exists(os.path.join(self.folder, "a.png")))

    def test_what_is_no_asset_is_told(self):
        for given, reason in ((b"", "is empty"), (b"glTF\2\0", "the header is truncated"), (b"solid x", "STL")):
            _, errors = self.run_program("render", "-", "-o", "-", status=1, given=given)
            self.assertRegex(errors, r"^sightline: standard input.*\n$")
            self.assertIn(reason, errors)

    def test_a_reader_that_ends_early_is_told(self):
        reader, writer = os.pipe()
        os.close(reader)
        _, errors = self.run_program("render", "-", "-o", "-", *SMALL, "--quiet", status=1, given=self.scene,
                                     stdout=writer)
        os.close(writer)
        self.assertEqual(errors, "sightline: standard output: the picture was not taken: Broken pipe\n")
        with open("/dev/full", "wb") as full:
            _, errors = self.run_program("render", "-", "-o", "-", *SMALL, "--quiet", status=1, given=self.scene,
                                         stdout=full)
        self.assertIn("No space left on device", errors)

    def test_a_terminal_is_refused(self):
        master, terminal = os.openpty()
        _, errors = self.run_program("render", "-", "-o", "-", status=2, given=self.scene, stdout=terminal)
        self.assertIn("standard output is a terminal", errors)
        _, errors = self.run_program("render", "-", "-o", "a.png", status=2, stdin=terminal)
        self.assertIn("standard input is a terminal", errors)
        os.close(master), os.close(terminal)

    def test_standard_output_takes_one_picture(self):
        for arguments, reason in ((["-o", "-", "-o", "-"], "- is given as output twice"),
                                  (["-o", "-", "--views", "front,top"], "takes one picture"),
                                  (["-o", "-", "--turntable", "3"], "takes one picture"),
                                  (["-o", "-", "--resume"], "give it a name"),
                                  (["-o", "-", "--explain"], "needs standard output for itself"),
                                  (["-o", "-", "--poses", "p.json"], "give it a name"),
                                  (["-o", "-", "--format", "bmp"], "'bmp' is not one of")):
            out, errors = self.run_program("render", "-", *arguments, status=2, given=self.scene)
            self.assertEqual(out, b"")
            self.assertIn(reason, errors)


class JsonProgress(Setting):
    def lines(self, errors):
        return [json.loads(line) for line in errors.splitlines() if line.startswith("{")]

    def check(self, lines, stage, total):
        """The lines of a stage count from 0 to all."""
        lines = [line for line in lines if line["stage"] == stage]
        self.assertEqual((lines[0]["done"], lines[0]["eta_s"]), (0, None))
        self.assertEqual((lines[-1]["done"], lines[-1]["eta_s"]), (total, 0))
        self.assertEqual([line["done"] for line in lines], sorted(line["done"] for line in lines))
        self.assertEqual({line["total"] for line in lines}, {total})
        return lines

    def test_a_render_tells_tiles_and_pictures(self):
        out, errors = self.run_program("render", "-", "-o", "{view}.png", "--views", "front,top", "--size", "64",
                                       "--samples", "1", "--progress", "json", given=self.scene)
        self.assertEqual(out, b"front.png\ntop.png\n")
        lines = self.lines(errors)
        for i, name in enumerate(("front.png", "top.png")):
            self.check([line for line in lines if line.get("name") == name], "render", 16)
            self.assertEqual({(line["number"], line["of"]) for line in lines if line.get("name") == name},
                             {(i + 1, 2)})
        self.check(lines, "pictures", 2)
        out, errors = self.run_program("render", "-", "-o", "a.png", *SMALL, "--progress", "json", "--quiet",
                                       given=self.scene)
        self.assertEqual((out, {line["stage"] for line in self.lines(errors)}), (b"", {"render"}))
        self.assertTrue(all(line.startswith("{") for line in errors.splitlines()))

    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_a_film_tells_the_frames_that_ffmpeg_has_taken(self):
        _, errors = self.run_program("render", "-", "-o", "a.mp4", "--turntable", "3", *SMALL, "--progress", "json",
                                     given=self.scene)
        self.check(self.lines(errors), "film", 3)

    def test_a_batch_tells_pictures(self):
        for name in "abc":
            with open(os.path.join(self.folder, name + ".gltf"), "wb") as file:
                file.write(self.scene if name != "b" else b"nothing")
        out, errors = self.run_program("batch", ".", "--out", "out", *SMALL, "--progress", "json", status=3)
        self.assertEqual(out, b"")
        last = [line for line in self.lines(errors) if line["stage"] == "batch"][-1]
        self.assertEqual([last[k] for k in ("done", "total", "skipped", "failed", "eta_s")], [3, 3, 0, 1, 0])

    def test_no_progress_is_shown_where_none_is_asked_for(self):
        _, errors = self.run_program("render", "-", "-o", "a.png", *SMALL, "--quiet", "--progress", "none",
                                     given=self.scene)
        self.assertEqual(errors, "")


if __name__ == "__main__":
    unittest.main()
