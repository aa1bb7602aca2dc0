#!/usr/bin/env python3
"""What a batch finds below its inputs, and what it calls the pictures.

batch_names_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import shutil
import subprocess
import sys
import unittest

import batch_test


class Names(batch_test.BatchTest):
    def test_of_assets_that_collide_are_told_apart(self):
        self.add("a/Box.gltf"), self.add("a/Box.glb"), self.add("b/Box.gltf"), self.add("b/Lamp.gltf")
        message = self.batch(inputs=("assets/a", "assets/b", "assets/b/Lamp.gltf"))
        self.assertEqual(sorted(batch_test.pictures(self.out)), ["Lamp.png", "a/Box.gltf.png", "a/Box.png", "b/Box.png"])
        self.assertIn("1 input passed over: " + self.path("assets/b/Lamp.gltf") + ": is given more than once",
                      message)

    def test_stay_when_a_file_is_added(self):
        self.add("Box.gltf")
        self.batch()
        before = batch_test.pictures(self.out)
        bigger = batch_test.triangle()
        bigger["nodes"][0]["scale"] = [2, 1, 1]
        self.add("Box.glb", bigger), self.add("x/Box.gltf", bigger)
        inputs = ("assets/Box.glb", "assets/Box.gltf", "assets/x/Box.gltf")
        for _ in range(2):
            self.batch("--resume", inputs=inputs)
            after = batch_test.pictures(self.out)
            self.assertEqual(sorted(after), ["Box.glb.png", "Box.png", "x/Box.png"])
            self.assertEqual(after["Box.png"], before["Box.png"])
        os.remove(self.path("assets", "Box.gltf"))
        self.batch("--resume", "--seed", "3", inputs=("assets/Box.glb",))
        self.assertEqual(batch_test.pictures(self.out)["Box.png"], before["Box.png"])

    def test_are_known_for_assets_that_failed(self):
        self.add("Box.gltf", "broken")
        self.batch(status=3)
        self.add("Box.gltf"), self.add("Box.glb")
        self.batch("--resume")
        with open(os.path.join(self.out, "journal.jsonl"), encoding="utf-8") as file:
            names = {(os.path.basename(o["asset"]), o["name"]) for o in map(json.loads, file)}
        self.assertEqual(names, {("Box.gltf", "Box"), ("Box.glb", "Box.glb")})

    def test_that_are_too_long_are_shortened(self):
        self.add("x" * 250 + ".gltf")
        self.batch("--views", "front,left")
        names = sorted(batch_test.pictures(self.out))
        self.assertEqual(len(names), 2)
        self.assertTrue(all(name.startswith("x" * 200) and name.endswith(".png") for name in names))


class Inputs(batch_test.BatchTest):
    def setUp(self):
        super().setUp()
        self.add("a.gltf"), self.add("chair.obj", "v 0 0 0")
        os.symlink("nowhere", self.path("assets", "dangling"))
        os.mkdir(self.path("elsewhere"))
        shutil.copy(self.path("assets", "a.gltf"), self.path("elsewhere", "b.gltf"))
        os.symlink("../elsewhere", self.path("assets", "link"))

    def passed_over(self):
        with open(os.path.join(self.out, "journal.jsonl"), encoding="utf-8") as file:
            lines = [json.loads(line) for line in file]
        return {os.path.basename(p["passed_over"]): p["reason"] for p in lines if "passed_over" in p}

    def test_that_are_passed_over_are_counted_and_listed(self):
        self.assertIn("3 inputs passed over: " + self.path("assets/chair.obj") + ": is Wavefront OBJ",
                      self.batch())
        self.assertEqual(set(self.passed_over()), {"chair.obj", "dangling", "link"})
        self.assertIn("--follow-links", self.passed_over()["link"])
        self.assertEqual(list(batch_test.pictures(self.out)), ["a.png"])
        with open(os.path.join(self.out, "journal.jsonl"), "rb") as file:
            before = file.read()
        self.assertIn("3 inputs passed over", self.batch("--resume"))
        with open(os.path.join(self.out, "journal.jsonl"), "rb") as file:
            self.assertEqual(file.read(), before)

    def test_that_hold_no_asset_are_passed_over(self):
        os.mkdir(self.path("none"))
        done = self.batch(self.path("none"), self.path("x*.glb"))
        self.assertIn("5 inputs passed over", done)
        self.assertEqual(self.passed_over()["none"], "no .gltf or .glb file in this folder")
        self.assertEqual(self.passed_over()["x*.glb"], "no .gltf or .glb file matches this pattern")

    def test_that_do_not_exist_fail_alone(self):
        """Also in a manifest; once it is there, a resumed batch renders it."""
        with open(self.path("list.json"), "w", encoding="utf-8") as file:
            json.dump({"assets": [{"path": "lost.glb"}]}, file)
        words = [self.path("b.gltf"), "--manifest", self.path("list.json")]
        message = self.batch(*words, status=3)
        self.assertEqual(list(batch_test.pictures(self.out)), ["a.png"])
        for name in ("b.gltf", "lost.glb"):
            self.assertIn(f"{name}: cannot open: No such file or directory", message)
        shutil.copy(self.path("assets", "a.gltf"), self.path("b.gltf"))
        shutil.copy(self.path("assets", "a.gltf"), self.path("lost.glb"))
        self.batch(*words, "--resume")
        self.assertEqual(sorted(batch_test.pictures(self.out)), ["a.png", "b.png", "lost.png"])

    def test_that_are_links_out_of_the_folder_are_rendered_on_request(self):
        self.assertIn("2 inputs passed over", self.batch("--follow-links"))
        self.assertEqual(sorted(batch_test.pictures(self.out)), ["a.png", "link/b.png"])

    def test_may_all_be_passed_over_in_a_batch_that_was_killed(self):
        """Lines about them alone are a journal."""
        os.makedirs(self.out)
        with open(os.path.join(self.out, "journal.jsonl"), "w", encoding="utf-8") as file:
            file.write('{"passed_over":"/x","reason":"is a pipe"}\n')
        self.batch("--resume")

    def test_that_cannot_be_read_are_passed_over(self):
        os.makedirs(self.path("assets", "closed"), mode=0o000)
        os.makedirs(self.out)
        os.chmod(self.folder, 0o755), os.chmod(self.out, 0o777)
        # Root may read everything, so the batch runs as another user.
        other_user = ["setpriv", "--reuid=65534", "--clear-groups"] if os.geteuid() == 0 else []
        subprocess.run(other_user + self.command(), check=True, capture_output=True, cwd=self.folder)
        self.assertIn("Permission denied", self.passed_over()["closed"])


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
