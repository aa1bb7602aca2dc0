#!/usr/bin/env python3
"""--ground and what goes with it, by the program: pictures, reports, batches, mistakes.

ground_test.py PROGRAM [unittest's arguments]
"""
import base64
import json
import math
import os
import struct
import subprocess
import sys
import unittest

import batch_test
import layers_test

SMALL = ["--size", "48x32", "--samples", "4"]


class Ground(batch_test.BatchTest):
    def run_program(self, *arguments, scene=None):
        return subprocess.run([batch_test.PROGRAM, "render", scene or self.path("asset.gltf"), *SMALL, *arguments],
                              cwd=self.folder, capture_output=True, text=True, timeout=250)

    def render(self, *arguments, status=0, scene=None):
        done = self.run_program(*arguments, scene=scene)
        self.assertEqual(done.returncode, status, done.stderr)
        self.stdout = done.stdout
        return done.stderr

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def setUp(self):
        super().setUp()
        with open(self.path("asset.gltf"), "w", encoding="utf-8") as file:
            json.dump(batch_test.triangle(), file)

    def test_says_where_it_lies(self):
        self.render("-o", "a.png", "--ground", "shadow", "--explain")
        self.assertRegex(self.stdout, r"ground +shadow +at y = -\d\S*, below the lowest point")
        self.render("-o", "a.png", "--ground", "#FF0000", "--ground-height", "-2", "--explain", "--stats", "s.json")
        self.assertRegex(self.stdout, r"ground +matte +at y = -2\S*, as asked for")
        needs = {n["name"]: n for n in json.loads(self.read("s.json"))["needs"]}
        self.assertEqual(needs["ground"]["choice"], "matte")
        self.render("-o", "a.png", "--explain")
        self.assertNotIn("ground ", self.stdout)

    def test_each_ground_changes_the_picture_and_none_does_not(self):
        grounds = [[], ["--ground", "none"], ["--ground", "shadow"], ["--ground", "cyclorama"],
                   ["--ground", "white"], ["--ground", "shadow", "--ground-height", "0.4"],
                   ["--ground", "shadow", "--ground-mirror", "0.9"]]
        for i, ground in enumerate(grounds):
            self.render("-o", f"{i}.png", "--camera", "20/30", *ground)
        pictures = [self.read(f"{i}.png") for i in range(len(grounds))]
        self.assertEqual(pictures[0], pictures[1])
        self.assertEqual(len(set(pictures)), len(grounds) - 1)

    def test_does_not_change_the_framing(self):
        cameras = []
        for ground in ("none", "shadow", "white"):
            self.render("-o", "a.exr", "--camera", "iso", "--ground", ground, "--aov", "depth,object", "--stats", "s.json")
            cameras.append(json.loads(self.read("s.json"))["needs"][0])
        self.assertEqual(cameras[0], cameras[1])
        self.assertEqual(cameras[0], cameras[2])

    def test_is_the_same_in_parts_and_in_one(self):
        options = ["--camera", "iso", "--ground", "shadow", "--background", "transparent"]
        for part in ("1/2", "2/2"):
            self.render("-o", "parts.png", *options, "--render-part", part)
        self.render("-o", "parts.png", *options, "--merge-parts")
        self.render("-o", "whole.png", *options)
        self.assertEqual(self.read("parts.png"), self.read("whole.png"))

    def test_is_the_same_after_an_interruption(self):
        options = ["--camera", "iso", "--ground", "shadow", "--background", "transparent"]
        self.render("-o", "a.png", *options, "--render-part", "1/2")
        kept = os.listdir(self.path("a.png.tiles"))
        self.assertEqual(len(kept), 1)
        self.render("-o", "a.png", *options, "--resume")
        self.assertFalse(os.path.exists(self.path("a.png.tiles")))
        self.render("-o", "whole.png", *options)
        self.assertEqual(self.read("a.png"), self.read("whole.png"))

    def test_a_crop_is_that_part_of_the_whole(self):
        x0, y0, x1, y1 = 5, 11, 41, 32
        for ground in ("shadow", "cyclorama", "#804020"):
            options = ["--camera", "iso", "--ground", ground, "--aov", "beauty", "--exr-compression", "none"]
            options += ["--background", "transparent"] if ground == "shadow" else []
            self.render("-o", "whole.exr", *options)
            self.render("-o", "part.exr", *options, "--crop", f"{x0},{y0},{x1},{y1}")
            whole, part = layers_test.Exr(self.path("whole.exr")), layers_test.Exr(self.path("part.exr"))
            for channel, values in part.words.items():
                rows = [whole.words[channel][y * 48 + x0:y * 48 + x1] for y in range(y0, y1)]
                self.assertEqual(values, sum(rows, []), (ground, channel))
            self.assertGreater(len(set(part.words["R"])), 10, ground)

    def test_is_the_same_in_several_pictures_and_alone(self):
        options = ["--ground", "shadow", "--env", "sky.png", "--env-blur", "10"]
        self.render("-o", "sky.png", "--background", "#4080C0")
        self.render("-o", "{frame}.png", *options, "--turntable", "3@25", "--quiet")
        self.render("-o", "{view}.png", *options, "--views", "front,60/40", "--quiet")
        alone = {f"{i}": ["--camera", "0/25", "--orbit", f"{120 * i}"] for i in range(3)}
        alone.update(front=["--camera", "front"], az060_el40=["--camera", "60/40"])
        for name, camera in alone.items():
            self.render("-o", "alone.png", *options, *camera, "--quiet")
            self.assertEqual(self.read("alone.png"), self.read(name + ".png"), name)
        self.assertEqual(len({self.read(name + ".png") for name in alone}), len(alone))

    def test_places_that_are_no_numbers_end_in_a_line_or_a_picture(self):
        not_numbers = struct.pack("<9f", 0, 0, 0, math.nan, 0, 0, 0, math.inf, 0)
        far = struct.pack("<9f", 0, 0, 0, 3e38, 0, 0, 0, -3e38, 0)
        point = struct.pack("<9f", *[0.5] * 9)
        huge_node = [1e20, 0, 0, 0, 0, 1e20, 0, 0, 0, 0, 1e20, 0, 1e20, -1e20, 0, 1]
        for positions in (not_numbers, far, point, None):
            asset = batch_test.triangle()
            if positions:
                uri = "data:application/octet-stream;base64," + base64.b64encode(positions).decode()
                asset["buffers"][0]["uri"] = uri
            else:
                asset["nodes"][0]["matrix"] = huge_node
            with open(self.path("odd.gltf"), "w", encoding="utf-8") as file:
                json.dump(asset, file)
            for ground in ("shadow", "cyclorama", "red"):
                for camera in ("front", "iso", "bottom"):
                    said = self.run_program("-o", "a.png", "--ground", ground, "--camera", camera, "--quiet",
                                            scene=self.path("odd.gltf"))
                    self.assertIn(said.returncode, (0, 1))
                    self.assertEqual(said.returncode == 0, os.path.exists(self.path("a.png")), said.stderr)
                    for line in said.stderr.splitlines():
                        self.assertRegex(line, r"^(warning|sightline): ")
                        self.assertNotIn("not finite", line)
                    if said.returncode == 0:
                        os.remove(self.path("a.png"))
                    else:
                        self.assertEqual(said.stderr.count("\n"), 1, said.stderr)

    def test_is_an_option_of_a_batch_and_of_its_assets(self):
        self.add("a.gltf"), self.add("b.gltf")
        manifest = {"ground": "shadow", "background": "transparent", "size": "24x16", "samples": 2,
                    "assets": [{"path": "assets/a.gltf"},
                               {"path": "assets/b.gltf", "ground": [0.2, 0.1, 0], "ground-height": -1}]}
        with open(self.path("m.json"), "w", encoding="utf-8") as file:
            json.dump(manifest, file)
        done = subprocess.run([batch_test.PROGRAM, "batch", "--manifest", "m.json", "--out", "out"], cwd=self.folder,
                              capture_output=True, text=True, timeout=250)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = batch_test.pictures(self.path("out"))
        self.assertEqual(len(found), 2)
        self.assertEqual(len(set(found.values())), 2)

    def test_an_empty_scene_has_none_and_says_so_in_one_line(self):
        for scene in ({"asset": {"version": "2.0"}}, {"asset": {"version": "2.0"}, "scenes": [{}], "scene": 0}):
            with open(self.path("empty.gltf"), "w", encoding="utf-8") as file:
                json.dump(scene, file)
            for ground in ("shadow", "cyclorama", "red"):
                for light in ("studio", "none"):
                    said = self.render("-o", "a.png", "--ground", ground, "--light", light, "--quiet",
                                       scene=self.path("empty.gltf"))
                    self.assertRegex(said, r"\Awarning: [^\n]*nothing to draw\n\Z")

    def test_points_and_planes_seen_edge_on_have_one(self):
        asset = batch_test.triangle()
        asset["nodes"][0]["rotation"] = [0.7071068, 0, 0, 0.7071068]  # lies in y = 0
        for scale in ([1, 1, 1], [1e-30, 1e-30, 1e-30], [1, 0, 0]):
            asset["nodes"][0]["scale"] = scale
            with open(self.path("flat.gltf"), "w", encoding="utf-8") as file:
                json.dump(asset, file)
            for ground in ("shadow", "cyclorama", "red"):
                said = self.render("-o", "a.png", "--camera", "front", "--ground", ground, "--quiet",
                                   scene=self.path("flat.gltf"))
                for line in said.splitlines():
                    self.assertRegex(line, r"^warning: .*(scaled to a line or a point|nothing to draw|smaller than a pixel|looks past)")

    def test_mistakes_are_one_line_before_any_work(self):
        for options, words in (
                (["--ground", "shadw"], "did you mean 'shadow'"),
                (["--ground", "#12"], "none, shadow, cyclorama"),
                (["--ground-height", "1"], "--ground-height needs a ground"),
                (["--ground", "shadow", "--ground-height", "nan"], "--ground-height"),
                (["--ground", "shadow", "--ground-mirror", "2"], "--ground-mirror"),
                (["--ground", "red", "--ground-mirror", "0.5"], "--ground-mirror is for --ground shadow"),
                (["--ground", "cyclorama", "--background", "transparent"], "give --background a colour"),
                (["--alpha-for", "blueish"], "--alpha-for")):
            said = self.render("-o", "a.png", *options, status=2)
            self.assertEqual(said.count("\n"), 1, said)
            self.assertIn(words, said)
            self.assertFalse(os.path.exists(self.path("a.png")))


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
