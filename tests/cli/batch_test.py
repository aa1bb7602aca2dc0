#!/usr/bin/env python3
"""`sightline batch` end to end: pictures, faults, resuming, comparison.

batch_test.py PROGRAM [unittest's arguments]
"""
import base64
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = None
QUICK = ["--size", "24x16", "--samples", "2"]
SLOW = ["--size", "1024x1024", "--samples", "4096"]  # takes far longer than any test waits


def triangle():
    """A small asset: one triangle, two cameras and a light."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    uri = "data:application/octet-stream;base64," + base64.b64encode(positions).decode()
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36, "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [0, 0, 0], "max": [1, 1, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]},
                  {"camera": 0, "translation": [0.3, 0, 3]}],
        "scenes": [{"nodes": [0, 1, 2]}], "scene": 0}


def pictures(folder):
    """Contents of all pictures below a folder by name, without the batch's own files."""
    found = {}
    for path, names, files in os.walk(folder):
        names[:] = [n for n in names if n != ".sightline"]
        for name in files:
            if name not in ("journal.jsonl", "index.html"):
                with open(os.path.join(path, name), "rb") as file:
                    found[os.path.relpath(os.path.join(path, name), folder)] = file.read()
    return found


def records(folder):
    """Records of the contact sheet by name of the picture."""
    with open(os.path.join(folder, "index.html"), encoding="utf-8") as file:
        data = re.search(r'id="data">(.*)</script>', file.read()).group(1)
    return {p["name"]: p for p in json.loads(data)["pictures"]}


def children(pid):
    """Process ids of the workers."""
    found = []
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
                parent = file.read().rpartition(")")[2].split()[1]
            if int(parent) == pid:
                found.append(int(process))
        except OSError:
            pass  # the process has ended
    return found


def is_running(pid):
    """Whether a process runs; a zombie does not."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


class BatchTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-batch-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = self.path("out")

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def add(self, name, content=None):
        path = self.path("assets", name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            if isinstance(content, str):
                file.write(content)
            else:
                json.dump(content or triangle(), file)
        return path

    def command(self, *arguments, out=None, inputs=("assets",)):
        return [PROGRAM, "batch", *[self.path(i) for i in inputs], "--out", out or self.out,
                *([] if "--size" in arguments else QUICK), *arguments]

    def batch(self, *arguments, status=0, **places):
        done = subprocess.run(self.command(*arguments, **places), capture_output=True, text=True,
                              cwd=self.folder, timeout=250)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def assert_jpeg(self, path):
        """That the thumbnail, named as on the contact sheet, exists."""
        with open(os.path.join(self.out, path), "rb") as file:
            self.assertEqual(file.read(3), b"\xff\xd8\xff")

    def start(self, *arguments):
        process = subprocess.Popen(self.command(*arguments), cwd=self.folder,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def wait_for(self, condition):
        end = time.monotonic() + 60
        while not condition():
            self.assertLess(time.monotonic(), end, "the condition did not come true in time")
            time.sleep(0.02)


class Pictures(BatchTest):
    def test_have_names_from_folders_and_are_on_the_contact_sheet(self):
        self.add("a.gltf"), self.add("x/b.gltf")
        self.batch("--format", "png,exr")
        self.assertEqual(sorted(pictures(self.out)), ["a.exr", "a.png", "x/b.exr", "x/b.png"])
        sheet = records(self.out)
        self.assertEqual(sorted(sheet), ["a", "x/b"])
        self.assert_jpeg(sheet["a"]["picture"])
        self.assertEqual(sheet["a"]["verdict"], "ok")

    def test_equal_those_of_the_command_on_the_contact_sheet(self):
        self.add("a b's.gltf")
        self.batch("--turntable", "3", "--background", "0.1,0.2,0.3")
        command = records(self.out)["a b's_0001"]["command"]
        self.assertTrue(command.startswith("sightline render "))
        os.mkdir(self.path("alone"))
        subprocess.run(PROGRAM + command.removeprefix("sightline") + " --quiet", shell=True,
                       check=True, cwd=self.path("alone"))
        self.assertEqual(pictures(self.path("alone"))["a b's_0001.png"],
                         pictures(self.out)["a b's_0001.png"])

    def test_multiply_with_views_cameras_and_frames(self):
        self.add("a.gltf")
        self.batch("--all-cameras", "--views", "front,left", "--frames", "1..2")
        self.assertEqual(sorted(pictures(self.out)),
                         [f"a_{view}_000{i}.png" for view in ("camera0", "camera1", "front", "left")
                          for i in (1, 2)])

    def test_differ_for_each_step_of_a_turntable(self):
        both_sides = triangle()
        both_sides["materials"] = [{"doubleSided": True}]
        both_sides["meshes"][0]["primitives"][0]["material"] = 0
        self.add("a.gltf", both_sides)
        self.batch("--turntable", "4")
        self.assertEqual(len(set(pictures(self.out).values())), 4)

    def test_follow_the_options_of_each_asset_in_a_manifest(self):
        self.add("a.gltf"), self.add("b.gltf")
        with open(self.path("m.json"), "w", encoding="utf-8") as file:
            json.dump({"assets": [{"path": "assets/a.gltf"},
                                  {"path": "assets/b.gltf", "name": "x/{stem}", "size": "8x8",
                                   "format": ["jpg", "png"]}]}, file)
        self.batch("--manifest", self.path("m.json"), inputs=())
        self.assertEqual(sorted(pictures(self.out)), ["a.png", "x/b.jpg", "x/b.png"])
        size = struct.unpack(">II", pictures(self.out)["x/b.png"][16:24])
        self.assertEqual(size, (8, 8))

    def test_are_logged_as_one_event_per_line(self):
        self.add("a.gltf")
        self.batch("--log", self.path("log"))
        with open(self.path("log"), encoding="utf-8") as file:
            events = [json.loads(line) for line in file]
        self.assertEqual([e["event"] for e in events], ["start", "begin", "task", "end"])

    def test_have_the_same_bits_for_any_number_of_workers_and_threads(self):
        for i in range(5):
            self.add(f"{i}.gltf")
        self.batch("--jobs", "1", "--threads", "1", "--format", "exr")
        self.batch("--jobs", "3", "--threads", "3", "--format", "exr", out=self.path("out2"))
        self.assertEqual(pictures(self.out), pictures(self.path("out2")))


class RefusedBeforeTheStart(BatchTest):
    def refuse(self, *arguments, status=1, **places):
        message = self.batch(*arguments, status=status, **places)
        self.assertEqual(pictures(self.out) if os.path.exists(self.out) else {}, {})
        return message

    def test_a_template_that_does_not_tell_pictures_apart(self):
        self.add("a.gltf"), self.add("b.gltf")
        for arguments, example in ((["--name", "x_%04d", "--turntable", "2"], "as in 'x_{frame:04}'"),
                                   (["--name", "{stem}", "--views", "front,left"], "as in '{stem}_{view}'"),
                                   (["--name", "x"], "as in 'x_{asset}'"),
                                   (["--name", "{stm}"], "as in '{stem}_{view}'"),
                                   (["--name", "../{stem}"], "'front/{stem}'"),
                                   (["--views", "front,front"], "'front' is given twice")):
            self.assertIn(example, self.refuse(*arguments, status=2))
            self.assertFalse(os.path.exists(self.out))

    def test_a_view_that_no_asset_has(self):
        self.add("a.gltf"), self.add("b.gltf")
        message = self.refuse("--views", "frnt", status=2)
        self.assertIn("no asset has the camera 'frnt' (2 searched)", message)
        self.assertIn("3/4", self.refuse("--views", "3/4", status=2))
        one = triangle()
        one["cameras"].append({"name": "eye", **one["cameras"][0]})
        one["nodes"][2]["camera"] = 1
        self.add("b.gltf", one)
        self.assertIn("failed: a_eye: ", self.batch("--views", "eye,front", status=3))

    def test_an_invalid_option_of_render(self):
        self.add("a.gltf"), self.add("b.gltf")
        with open(self.path("m.json"), "w", encoding="utf-8") as file:
            json.dump({"assets": [{"path": "assets/a.gltf"},
                                  {"path": "assets/b.gltf", "depth": -3}]}, file)
        self.assertIn("--depth", self.refuse("--manifest", self.path("m.json"), inputs=()))

    def test_no_input(self):
        self.refuse(inputs=(), status=2)
        self.refuse(inputs=("missing",))

    def test_a_folder_with_an_earlier_batch(self):
        self.add("a.gltf")
        self.batch()
        self.assertIn("--resume", self.batch(status=1))

    def test_a_folder_that_cannot_be_written(self):
        self.add("a.gltf")
        with open(self.out, "w", encoding="utf-8"):
            pass
        self.assertIn("out", self.batch(status=1))


class FaultsAffectOneAsset(BatchTest):
    def test_a_broken_asset_is_reported_and_the_others_are_rendered(self):
        self.add("a.gltf"), self.add("b.gltf", "{ broken"), self.add("c.gltf")
        message = self.batch(status=3)
        self.assertIn("failed: b: ", message)
        self.assertEqual(sorted(pictures(self.out)), ["a.png", "c.png"])
        sheet = records(self.out)
        self.assertEqual(sheet["b"]["verdict"], "failed")
        self.assertIn("JSON", sheet["b"]["message"])

    def test_pictures_that_show_nothing_are_named_and_do_not_fail_the_batch(self):
        behind, unlit = triangle(), triangle()
        behind["nodes"][1]["translation"] = [0, 0, -3]
        unlit["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 1, "baseColorFactor": [0, 0, 0, 1]}}]
        unlit["meshes"][0]["primitives"][0]["material"] = 0
        self.add("a.gltf"), self.add("b.gltf", behind), self.add("c.gltf", unlit)
        message = self.batch("--env", "none", "--background", "0,0,0", "--format", "exr",
                             "--use-file-cameras")
        self.assertIn("empty: b: the picture is empty: ", message)
        self.assertIn("black: c: the picture is black: ", message)
        self.assertIn("3 pictures", message)
        self.assertIn("0 failed, 1 empty, 2 black", message)  # a has no light either
        with open(os.path.join(self.out, "journal.jsonl"), encoding="utf-8") as file:
            journal = {o["name"]: o["verdict"] for o in map(json.loads, file)}
        self.assertEqual(journal, {"a": "black", "b": "empty", "c": "black"})
        sheet = records(self.out)
        self.assertEqual({n: p["verdict"] for n, p in sheet.items()}, journal)
        self.assert_jpeg(sheet["b"]["picture"])
        self.assertEqual(sorted(pictures(self.out)), ["a.exr", "b.exr", "c.exr"])
        self.assertIn("3 unchanged", self.batch(
            "--env", "none", "--background", "0,0,0", "--format", "exr", "--use-file-cameras", "--resume"))

    def test_a_picture_over_the_time_limit_is_a_timeout(self):
        self.add("a.gltf"), self.add("b.gltf")
        with open(self.path("m.json"), "w", encoding="utf-8") as file:
            json.dump({"assets": [{"path": "assets/a.gltf", "size": "1024x1024", "samples": 9999},
                                  {"path": "assets/b.gltf"}]}, file)
        self.batch("--manifest", self.path("m.json"), "--timeout", "20", inputs=(), status=3)
        self.assertEqual({n: p["verdict"] for n, p in records(self.out).items()},
                         {"a": "timeout", "b": "ok"})

    def test_a_killed_worker_fails_its_asset_only(self):
        self.add("a.gltf"), self.add("b.gltf")
        process = self.start("--jobs", "1", "--size", "1024x1024", "--samples", "16")
        self.wait_for(lambda: children(process.pid))
        os.kill(children(process.pid)[0], signal.SIGKILL)
        self.assertEqual(process.wait(200), 3)
        self.assertEqual({n: p["verdict"] for n, p in records(self.out).items()},
                         {"a": "killed", "b": "ok"})

    def test_too_much_memory_fails_its_asset_only(self):
        if "asan" in PROGRAM or "fuzz" in PROGRAM:
            self.skipTest("Notice: sanitizers map more than any limit")
        self.add("a.gltf"), self.add("b.gltf")
        with open(self.path("m.json"), "w", encoding="utf-8") as file:
            json.dump({"assets": [{"path": "assets/a.gltf", "size": "20000x20000", "samples": 1},
                                  {"path": "assets/b.gltf"}]}, file)
        self.batch("--manifest", self.path("m.json"), "--memory", "1500", inputs=(), status=3)
        self.assertEqual({n: p["verdict"] for n, p in records(self.out).items()},
                         {"a": "out-of-memory", "b": "ok"})

    def test_names_may_contain_any_characters(self):
        names = ["two words", "ünïcode", "line\nbreak", "-o", "--out", "a'b\"c", "{asset}", "%2e",
                 "</script><!--", "x" * 250]
        for name in names:
            self.add(name + ".gltf")
        self.batch()
        self.assertEqual(sorted(pictures(self.out)), sorted(n + ".png" for n in names))
        self.assertEqual(sorted(records(self.out)), sorted(names))
        self.batch("--resume")


class Resuming(BatchTest):
    def setUp(self):
        super().setUp()
        for i in range(6):
            self.add(f"{i}.gltf")

    def skipped(self):
        return sorted(n for n, p in records(self.out).items() if p.get("skipped"))

    def test_skips_finished_pictures(self):
        self.batch()
        times = [os.stat(self.path("out", f"{i}.png")).st_mtime_ns for i in range(6)]
        self.batch("--resume")
        self.assertEqual(times, [os.stat(self.path("out", f"{i}.png")).st_mtime_ns for i in range(6)])
        self.assertEqual(len(self.skipped()), 6)

    def test_renders_again_what_changed(self):
        self.batch()
        changed = triangle()
        changed["nodes"][0]["scale"] = [2, 1, 1]
        self.add("1.gltf", changed)                      # another input
        os.remove(self.path("out", "2.png"))             # a lost output
        with open(self.path("out", "3.png"), "ab") as f:  # a damaged output
            f.write(b"x")
        self.batch("--resume")
        self.assertEqual(self.skipped(), ["0", "4", "5"])
        self.batch("--resume", "--depth", "3")           # other options
        self.assertEqual(self.skipped(), [])

    def test_renders_again_if_a_referenced_file_or_the_environment_changed(self):
        asset = triangle()
        asset["buffers"][0]["uri"] = "b%20in"
        self.add("0.gltf", asset)
        for name, scale in (("b in", 1), ("b in", 2)):
            with open(self.path("assets", name), "wb") as file:
                file.write(struct.pack("<9f", 0, 0, 0, scale, 0, 0, 0, 1, 0))
            self.batch("--resume")
        self.assertEqual(self.skipped(), ["1", "2", "3", "4", "5"])
        for content in (b"\x80\x80\x80\x81", b"\x40\x80\x80\x81"):
            with open(self.path("sky.hdr"), "wb") as file:
                file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + content * 2)
            self.batch("--resume", "--env", self.path("sky.hdr"))
            self.assertEqual(self.skipped(), [])

    def test_tries_failures_again(self):
        self.add("3.gltf", "broken")
        self.batch(status=3)
        self.add("3.gltf")
        self.batch("--resume")
        self.assertEqual(self.skipped(), ["0", "1", "2", "4", "5"])

    def test_leaves_no_workers_of_a_killed_batch(self):
        process = self.start(*SLOW)
        self.wait_for(lambda: children(process.pid))
        workers = children(process.pid)
        process.kill()
        process.wait()
        self.wait_for(lambda: not any(map(is_running, workers)))

    def test_works_after_sigterm_and_the_grace_time(self):
        process = self.start("--jobs", "1", "--grace", "1", "--log", self.path("log"), *SLOW)
        self.wait_for(lambda: children(process.pid))
        process.terminate()
        self.assertEqual(process.wait(200), 1)  # without finishing the picture
        self.assertEqual(records(self.out), {})
        self.assertIn("--resume", process.stderr.read())
        self.batch("--resume")

    def test_is_refused_while_the_first_batch_runs(self):
        process = self.start(*SLOW)
        self.wait_for(lambda: children(process.pid))
        self.assertIn("another batch", self.batch("--resume", status=1))

    def test_reports_an_input_that_vanished_as_failed(self):
        process = self.start("--jobs", "1", "--size", "256x256", "--samples", "64")
        self.wait_for(lambda: children(process.pid))
        os.remove(self.path("assets", "5.gltf"))
        self.assertEqual(process.wait(200), 3)
        self.assertEqual(records(self.out)["5"]["verdict"], "failed")


class Comparing(BatchTest):
    def test_marks_changes_which_can_fail_the_batch(self):
        for name in ("a", "b", "c"):
            self.add(name + ".gltf")
        self.batch(out=self.path("old"))
        changed = triangle()
        changed["nodes"][0]["scale"] = [0.5, 1, 1]
        self.add("b.gltf", changed)
        os.remove(self.path("old", "c.png"))
        self.batch("--compare-to", self.path("old"))
        sheet = records(self.out)
        self.assertEqual({n: p["change"]["kind"] for n, p in sheet.items()},
                         {"a": "same", "b": "changed", "c": "added"})
        self.assertGreater(sheet["b"]["change"]["flip"], 0.001)
        self.assertEqual(sheet["b"]["earlierLink"], "../old/b.png")
        self.assert_jpeg(sheet["b"]["earlierPicture"])
        self.batch("--resume", "--compare-to", self.path("old"), "--fail-on-change", status=3)

    def test_succeeds_if_nothing_changed(self):
        self.add("a.gltf")
        self.batch(out=self.path("old"))
        self.batch("--compare-to", self.path("old"), "--fail-on-change")


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
