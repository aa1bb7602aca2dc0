#!/usr/bin/env python3
"""`sightline render` with several views, and the pictures that a worker of a batch makes of one asset.

views_test.py PROGRAM [unittest's arguments]
"""
import array
import base64
import json
import os
import resource
import signal
import subprocess
import sys
import time
import unittest

import batch_test

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENE = os.path.join(ROOT, "scenes", "whitted.gltf")
SMALL = ["--size", "32x24", "--samples", "2"]
VIEWS = ["front", "top", "az000_el20", "az120_el20", "az240_el20"]
LIST = "front,top,ring:3@20"
# Sanitizers are ten times slower.
SLOWNESS = 1 if "asan" in sys.argv[1] or "fuzz" in sys.argv[1] else 10


def textured(factor=1):
    """A triangle that is seen from both sides, with the texture texture.png."""
    asset = batch_test.triangle()
    asset["nodes"][0]["scale"] = [factor, 1, 1]
    asset["images"] = [{"uri": "texture.png"}]
    asset["textures"] = [{"source": 0}]
    asset["materials"] = [{"doubleSided": True,
                           "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    asset["accessors"].append(dict(asset["accessors"][0], type="VEC2", max=[1, 1], min=[0, 0]))
    asset["meshes"][0]["primitives"][0].update(material=0,
                                               attributes={"POSITION": 0, "TEXCOORD_0": 1})
    return asset


def moving(path="translation", end=(2, 0, 0), how="LINEAR"):
    """The same, moving to the right within a second."""
    asset = textured()
    values = array.array("f", [0, 1, *([1, 1, 1] if path == "scale" else [0, 0, 0]), *end])
    asset["buffers"].append({"byteLength": 32, "uri": "data:application/octet-stream;base64,"
                             + base64.b64encode(values.tobytes()).decode()})
    buffer = len(asset["buffers"]) - 1
    view = len(asset["bufferViews"])
    asset["bufferViews"] += [{"buffer": buffer, "byteLength": 8},
                             {"buffer": buffer, "byteOffset": 8, "byteLength": 24}]
    first = len(asset["accessors"])
    asset["accessors"] += [{"bufferView": view, "componentType": 5126, "count": 2, "type": "SCALAR",
                            "min": [0], "max": [1]},
                           {"bufferView": view + 1, "componentType": 5126, "count": 2, "type": "VEC3"}]
    asset["animations"] = [{"samplers": [{"input": first, "output": first + 1, "interpolation": how}],
                            "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}]}]
    return asset


def processor_time(pid):
    """Ticks of the clock that a process has computed."""
    with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as file:
        return int(file.read().rpartition(")")[2].split()[11])


class ViewsTest(batch_test.BatchTest):
    def render(self, scene, *arguments, status=0):
        done = subprocess.run([batch_test.PROGRAM, "render", scene, *arguments], cwd=self.folder,
                              capture_output=True, text=True, timeout=250)
        self.assertEqual(done.returncode, status, done.stderr)
        self.stdout = done.stdout
        return done.stderr

    def files(self, *folders):
        """Contents of the files of a folder by name."""
        return {name: self.read(*folders, name) for name in os.listdir(self.path(*folders))}

    def read(self, *names):
        with open(self.path(*names), "rb") as file:
            return file.read()

    def add_texture(self, view="front"):
        """Writes texture.png beside the assets, from the chosen side of a scene."""
        os.makedirs(self.path("assets"), exist_ok=True)
        self.render(SCENE, "-o", self.path("assets", "texture.png"), *SMALL, "--quiet", "--camera", view)


class OneCommand(ViewsTest):
    def test_makes_the_pictures_of_one_process_for_each_view(self):
        os.makedirs(self.path("all")), os.makedirs(self.path("alone"))
        self.add_texture(), self.add("a.gltf", textured())
        for scene in (SCENE, self.path("assets", "a.gltf")):
            self.render(scene, "-o", "all/{view}.png", "--views", LIST, *SMALL, "--quiet")
            for name, camera in zip(VIEWS, ["front", "top", "0/20", "120/20", "240/20"]):
                self.render(scene, "-o", f"alone/{name}.png", "--camera", camera, *SMALL, "--quiet")
            self.assertEqual(sorted(self.files("all")), sorted(v + ".png" for v in VIEWS))
            self.assertEqual(self.files("all"), self.files("alone"))
            self.assertEqual(len(set(self.files("all").values())), len(VIEWS))

    def test_makes_the_pictures_of_one_process_for_each_step_of_a_turntable(self):
        os.makedirs(self.path("all")), os.makedirs(self.path("alone"))
        self.add_texture(), self.add("a.gltf", textured())
        scene = self.path("assets", "a.gltf")
        for count, camera in (("3", ["--camera", "0"]), ("3@20", ["--camera", "0/20"])):
            own = [] if "@" in count else camera
            self.render(scene, "-o", "all/{stem}_{frame:02}.png", "--turntable", count, *own, *SMALL)
            for i in range(3):
                self.render(scene, "-o", f"alone/a_{i:02}.png", *camera, "--orbit", str(i * 120), *SMALL)
            self.assertEqual(self.files("all"), self.files("alone"))
            self.assertEqual(len(set(self.files("all").values())), 3)

    def test_makes_the_pictures_of_one_process_for_each_time(self):
        os.makedirs(self.path("all")), os.makedirs(self.path("alone"))
        self.add_texture(), self.add("a.gltf", moving())
        scene, views = self.path("assets", "a.gltf"), ["front", "top"]
        self.render(scene, "-o", "all/{view}_{frame}.png", "--frames", "0..4", "--fps", "4", "--views",
                    "front,top", "--stats", "{view}_{frame}.json", *SMALL)
        for view in views:
            for i in range(5):
                self.render(scene, "-o", f"alone/{view}_{i}.png", "--camera", view, "--time", str(i / 4),
                            "--frame-for", "0..4@4", *SMALL)
        self.assertEqual(self.files("all"), self.files("alone"))
        self.assertGreaterEqual(len(set(self.files("all").values())), 5)
        for name, is_posed in (("front_0", False), ("top_0", False), ("front_1", True), ("top_4", False)):
            seconds = json.loads(self.read(name + ".json"))["seconds"]
            self.assertEqual([seconds[s] > 0 for s in ("open", "parse", "pose")],
                             [name == "front_0"] * 2 + [is_posed], name)

    def test_writes_the_command_that_makes_each_picture_alone_into_it(self):
        self.render(SCENE, "-o", "{view}.exr", "--views", "front,top", *SMALL, "--quiet")
        first = self.read("top.exr")
        command = ["sightline", "render", SCENE, "--camera=top", "--samples=2", "--size=32x24",
                   "--output=top.exr"]
        self.assertIn(" ".join(command).encode(), first)
        os.remove(self.path("top.exr"))
        subprocess.run(command, executable=batch_test.PROGRAM, check=True, cwd=self.folder,
                       capture_output=True)
        self.assertEqual(self.read("top.exr"), first)

    def test_does_not_depend_on_the_order_of_the_views(self):
        self.add_texture(), self.add("a.gltf", textured())
        for folder, views in (("all", VIEWS[:2]), ("alone", VIEWS[1::-1])):
            os.makedirs(self.path(folder))
            self.render(self.path("assets", "a.gltf"), "-o", folder + "/{view}.png", "--views",
                        ",".join(views), *SMALL)
        self.assertEqual(self.files("all"), self.files("alone"))

    def test_loads_once_and_writes_statistics_for_each_view(self):
        self.add_texture(), self.add("a.gltf", textured())
        self.render(self.path("assets", "a.gltf"), "-o", "{view}.png", "--views", "front,back",
                    "--stats", "{view}.json", *SMALL)
        self.assertEqual(self.stdout, "front.png\nback.png\n")
        first, second = (json.loads(self.read(v + ".json")) for v in ("front", "back"))
        self.assertEqual([first["outputs"], second["outputs"]], [["front.png"], ["back.png"]])
        self.assertGreater(first["bytes"]["files"], 0)
        self.assertEqual(second["bytes"]["files"], 0)
        self.assertEqual([second["seconds"][s] for s in ("open", "parse")], [0, 0])
        for seconds in (first["seconds"], second["seconds"]):
            self.assertGreater(seconds["write"], 0)
            self.assertGreaterEqual(seconds["total"],
                                    sum(seconds[s] for s in ("load", "build", "prepare", "render", "write")))

    def test_warns_once_of_what_all_views_share(self):
        self.add("a.gltf", textured())  # its texture is missing
        message = self.render(self.path("assets", "a.gltf"), "-o", "{view}.png", "--views", "front,left",
                              *SMALL, "--quiet")
        self.assertEqual(message.count("texture.png"), 1, message)
        self.assertEqual(message.count("left.png"), 1, message)  # the triangle's edge: nothing is seen

    def test_plans_thousands_of_views_before_anything_is_read(self):
        # In less than 2 ms a view, with names as wide as the last one's.
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        said = self.render("nothing.gltf", "-o", "{view}.png", "--views", "sphere:5000", *SMALL, status=1)
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, 100 / SLOWNESS)
        self.assertIn("nothing.gltf", said)
        for name, views, words in (("a.png", "sphere:5000", "add {view}, as in 'a_{view}.png'"),
                                   ("{view}.png", "sphere:5000,front,sphere:5000", "the view 'sphere5000_0001' is given twice"),
                                   ("{view}.jpg", "sphere:5000", "cannot hold transparency"),
                                   ("{view}.png", "sphere:500000", "1 to 100000 views"),
                                   ("no/{view}.png", "sphere:5000", "no")):
            said = self.render("nothing.gltf", "-o", name, "--views", views, "--background", "transparent", *SMALL,
                               status=1 if name.startswith("no/") else 2)
            self.assertEqual(said.count("\n"), 1, said)
            self.assertIn(words, said)
        self.assertEqual(os.listdir(self.folder), [])

    def test_takes_braces_as_they_are_without_several_views(self):
        self.render(SCENE, "-o", "{view}.png", *SMALL, "--quiet")
        self.assertEqual(list(self.files()), ["{view}.png"])

    def test_replaces_no_input_and_writes_nothing_before_it_is_refused(self):
        os.makedirs(self.path("assets"))
        self.render(SCENE, "-o", self.path("assets", "top.png"), *SMALL, "--quiet")
        asset = textured()
        asset["images"] = [{"uri": "top.png"}]
        self.add("a.gltf", asset)
        before = self.files("assets")
        message = self.render(self.path("assets", "a.gltf"), "-o", "assets/{view}.png", "--views",
                              "front,top", *SMALL, status=2)
        self.assertRegex(message, r"^sightline: assets/top.png: would be written, but is also read.*\n$")
        self.assertEqual(self.files("assets"), before)

    def test_makes_the_same_files_of_each_kind_as_one_process_for_each_time(self):
        os.makedirs(self.path("all")), os.makedirs(self.path("alone"))
        self.add_texture(), self.add("a.gltf", moving())
        scene, common = self.path("assets", "a.gltf"), ["--data", "depth,object", "--quiet", *SMALL]
        outputs = [word for ending in ("png", "jpg", "hdr", "webp") for word in ("-o", "%s/%s." + ending)]
        self.render(scene, *(o % ("all", "{frame}") if "%" in o else o for o in outputs), "--record-rays",
                    "all/{frame}.rays", "--frames", "0..4", "--fps", "4", *common)
        for i in range(5):
            self.render(scene, *(o % ("alone", i) if "%" in o else o for o in outputs), "--record-rays",
                        f"alone/{i}.rays", "--time", str(i / 4), "--frame-for", "0..4@4", *common)
        self.assertEqual(len(self.files("all")), 5 * 7)
        self.assertEqual(self.files("all"), self.files("alone"))

    def fail_at_the_second(self, *arguments):
        """Stderr of three views of which the second one's picture is more than a file may have."""
        self.add("a.gltf", batch_test.triangle())
        limit = 1500

        def limit_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        done = subprocess.run([batch_test.PROGRAM, "render", self.path("assets", "a.gltf"), "--size", "256x256",
                               "--samples", "16", "--views", "left,front,right", *arguments], cwd=self.folder,
                              capture_output=True, text=True, timeout=250, preexec_fn=limit_files)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.stdout = done.stdout
        return done.stderr

    def test_a_picture_that_cannot_be_written_ends_it_after_those_before(self):
        self.add("a.gltf", batch_test.triangle())
        self.render(self.path("assets", "a.gltf"), "-o", "left.png", "--size", "256x256", "--samples", "16",
                    "--camera", "left", "--quiet")
        left = self.read("left.png")
        os.remove(self.path("left.png"))
        message = self.fail_at_the_second("-o", "{view}.png")
        self.assertEqual(message.splitlines()[-1], "sightline: front.png: cannot write: File too large")
        self.assertEqual(message.count(" s: load "), 1, message)  # the times of the first
        self.assertEqual(self.stdout, "left.png\n")
        self.assertEqual(sorted(os.listdir(self.folder)), ["assets", "left.png"])
        self.assertEqual(self.read("left.png"), left)

    def test_a_picture_that_cannot_be_rendered_ends_it_after_those_before(self):
        self.add("a.gltf", moving("scale", [float("inf")] * 3, "STEP"))
        message = self.render(self.path("assets", "a.gltf"), "-o", "{frame}.png", "--frames", "0..4", "--fps", "2",
                              *SMALL, status=1)
        self.assertIn("nothing", message.splitlines()[-1])
        self.assertEqual(self.stdout, "0.png\n1.png\n")
        self.assertEqual(sorted(os.listdir(self.folder)), ["0.png", "1.png", "assets"])

    def test_has_whole_pictures_alone_if_it_is_killed(self):
        self.add_texture(), self.add("a.gltf", moving())
        command = ["--frames", "0..9", "--fps", "10", "--size", "64x64", "--samples", str(10 * SLOWNESS)]
        scene = self.path("assets", "a.gltf")
        os.makedirs(self.path("all")), os.makedirs(self.path("killed"))
        self.render(scene, "-o", "all/{frame}.png", *command)
        whole = self.files("all")
        for count in (1, 2, 5):
            process = subprocess.Popen([batch_test.PROGRAM, "render", scene, "-o", "killed/{frame}.png", *command],
                                       cwd=self.folder, stderr=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
            self.addCleanup(process.kill)
            self.wait_for(lambda: len(os.listdir(self.path("killed"))) >= count or process.poll() is not None)
            process.kill()
            told = process.communicate(timeout=60)[0].split()
            found = self.files("killed")
            self.assertGreaterEqual(len(found), count)
            self.assertEqual(found, {f"{i}.png": whole[f"{i}.png"] for i in range(len(found))})
            self.assertLessEqual(len(told), len(found))  # none is told before it is whole
            for name in found:
                os.remove(self.path("killed", name))

    def test_keeps_what_is_finished_when_it_is_interrupted(self):
        for send in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([batch_test.PROGRAM, "render", SCENE, "-o", "{view}.png", "--views",
                                        "front,top,left", "--size", "256x256", "--samples", str(10 * SLOWNESS)],
                                       cwd=self.folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE,
                                       text=True)
            self.addCleanup(process.kill)
            self.wait_for(lambda: os.path.exists(self.path("front.png")))
            process.send_signal(send)
            out, message = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 1, message)
            self.assertIn("1 of 3 pictures are finished\n", message.splitlines(True)[-1])
            self.assertEqual(out, "front.png\n")
            self.assertFalse(os.path.exists(self.path("top.png")))
            os.remove(self.path("front.png"))


class KeptAsset(ViewsTest):
    """A worker keeps an asset for its next picture; the pictures are as isolated as ever."""

    def setUp(self):
        super().setUp()
        self.add_texture(), self.add("a.gltf", textured())
        # A worker keeps no asset whose files are so new that a change could go unnoticed.
        for name in os.listdir(self.path("assets")):
            os.utime(self.path("assets", name), (time.time() - 60,) * 2)
        time.sleep(2.2)

    def journal(self):
        return batch_test.pictures(self.out) if os.path.exists(self.out) else {}

    def log(self):
        with open(self.path("log"), encoding="utf-8") as file:
            return [json.loads(line) for line in file if line.endswith("\n")]

    LONG = ["--views", LIST, "--size", "96x96", "--samples", str(15 * SLOWNESS), "--jobs", "1"]

    def test_costs_only_the_picture_in_work_if_the_worker_is_killed(self):
        self.batch(*self.LONG, out=self.path("undisturbed"))
        process = self.start(*self.LONG, "--log", self.path("log"))
        self.wait_for(lambda: os.path.exists(os.path.join(self.out, "a_front.png")))
        kept = os.stat(os.path.join(self.out, "a_front.png")).st_ino
        # The other child writes files to the disk.
        os.kill(max(batch_test.children(process.pid), key=processor_time), signal.SIGKILL)
        self.assertEqual(process.wait(200), 3, process.stderr.read())
        verdicts = {n: p["verdict"] for n, p in batch_test.records(self.out).items()}
        self.assertEqual(sorted(verdicts.values()), ["killed"] + ["ok"] * 4, verdicts)
        self.assertEqual(verdicts["a_front"], "ok")
        self.batch("--resume", *self.LONG)
        self.assertEqual(os.stat(os.path.join(self.out, "a_front.png")).st_ino, kept)
        self.assertEqual(sum(bool(p.get("skipped")) for p in batch_test.records(self.out).values()), 4)
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("undisturbed")))

    def test_is_read_anew_if_it_changes_between_two_of_its_views(self):
        self.batch(*self.LONG, out=self.path("before"))
        process = self.start(*self.LONG)
        self.wait_for(lambda: os.path.exists(os.path.join(self.out, "a_front.png")))
        self.add("b.gltf", textured(3))
        os.replace(self.path("assets", "b.gltf"), self.path("assets", "a.gltf"))
        self.assertEqual(process.wait(200), 0, process.stderr.read())
        self.batch(*self.LONG, out=self.path("after"))
        found, before, after = (batch_test.pictures(f)
                                for f in (self.out, self.path("before"), self.path("after")))
        self.assertEqual(found["a_front.png"], before["a_front.png"])
        last = f"a_{VIEWS[-1]}.png"
        self.assertNotEqual(before[last], after[last])
        self.assertEqual(found[last], after[last])
        self.batch("--resume", *self.LONG)
        self.assertEqual(batch_test.pictures(self.out), after)

    FRAMES = ["--frames", "0..4", "--fps", "4", "--size", "96x96", "--samples", str(15 * SLOWNESS),
              "--camera", "front", "--frame-each"]

    def test_is_read_anew_if_it_changes_between_two_of_its_frames(self):
        self.add("a.gltf", moving())
        os.utime(self.path("assets", "a.gltf"), (time.time() - 60,) * 2)
        time.sleep(2.2)
        self.batch(*self.FRAMES, "--jobs", "1", out=self.path("before"))
        process = self.start(*self.FRAMES, "--jobs", "1")
        self.wait_for(lambda: os.path.exists(os.path.join(self.out, "a_0000.png")))
        asset = moving()
        asset["nodes"][0]["scale"] = [3, 1, 1]
        self.add("b.gltf", asset)
        os.replace(self.path("assets", "b.gltf"), self.path("assets", "a.gltf"))
        self.assertEqual(process.wait(200), 0, process.stderr.read())
        self.batch(*self.FRAMES, "--jobs", "2", out=self.path("after"))
        found, before, after = (batch_test.pictures(f)
                                for f in (self.out, self.path("before"), self.path("after")))
        self.assertEqual(found["a_0000.png"], before["a_0000.png"])
        self.assertNotEqual(before["a_0004.png"], after["a_0004.png"])
        self.assertEqual(found["a_0004.png"], after["a_0004.png"])

    def test_has_the_same_bits_for_any_number_of_workers_and_order_of_views(self):
        for i, (jobs, views) in enumerate((("1", LIST), ("2", LIST), ("1", "ring:3@20,top,front"))):
            self.batch("--views", views, "--jobs", jobs, "--threads", jobs, out=self.path(f"out{i}"))
        self.assertEqual(len(batch_test.pictures(self.path("out0"))), 5)
        for i in (1, 2):
            self.assertEqual(batch_test.pictures(self.path("out0")),
                             batch_test.pictures(self.path(f"out{i}")))


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
