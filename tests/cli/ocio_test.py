#!/usr/bin/env python3
"""Displays and views of an OpenColorIO configuration that the test writes.

ocio_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import subprocess
import sys
import unittest

import batch_test
import example_test

CONFIG = """ocio_profile_version: 1
strictparsing: false
roles:
  ROLE: lin_rec709
displays:
  Screen:
    - !<View> {name: Half, colorspace: half}
    - !<View> {name: Quarter, colorspace: quarter}
  Other:
    - !<View> {name: Plain, colorspace: lin_rec709}
active_displays: [Screen, Other]
active_views: []
colorspaces:
  - !<ColorSpace>
    name: lin_rec709
    bitdepth: 32f
  - !<ColorSpace>
    name: half
    bitdepth: 32f
    from_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: quarter
    bitdepth: 32f
    from_reference: !<MatrixTransform> {matrix: [0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 1]}
"""


class Ocio(batch_test.BatchTest):
    def setUp(self):
        super().setUp()
        asset = batch_test.triangle()
        asset["materials"] = [{"emissiveFactor": [0.8, 0.4, 0.2], "doubleSided": True,
                               "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}}]
        asset["meshes"][0]["primitives"][0]["material"] = 0
        self.write("asset.gltf", json.dumps(asset))
        self.write("c.ocio", CONFIG.replace("ROLE", "scene_linear"))

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def render(self, *options, status=0, config=None, at="0.3,0.3"):
        environment = {k: v for k, v in os.environ.items() if k != "OCIO"}
        if config:
            environment["OCIO"] = config
        done = subprocess.run(
            [batch_test.PROGRAM, "render", "asset.gltf", "-o", "a.png", "--size", "1", "--samples", "1",
             "--light", "none", "--quiet", "--look-from", at + ",1", "--look-at", at + ",0", "--background",
             "black" if at == "0.3,0.3" else "white", *options],
            cwd=self.folder, capture_output=True, text=True, timeout=250, env=environment)
        self.assertEqual(done.returncode, status, done.stderr)
        return done.stderr

    def pixel(self):
        return tuple(example_test.png_bytes(self.path("a.png"))[1][1:4])

    def test_a_view_takes_the_place_of_the_tone_map(self):
        for options, expected in ((["--ocio", "c.ocio"], (102, 51, 26)),
                                  (["--ocio", "c.ocio", "--ocio-view", "Half"], (102, 51, 26)),
                                  (["--ocio", "c.ocio", "--ocio-view", "Quarter"], (51, 26, 13)),
                                  (["--ocio", "c.ocio", "--ocio-view", "Other/Plain"], (204, 102, 51)),
                                  (["--ocio", "c.ocio", "--exposure", "-1"], (51, 26, 13))):
            said = self.render(*options)
            self.assertEqual(said, "")
            for found, wanted in zip(self.pixel(), expected):
                self.assertAlmostEqual(found, wanted, delta=1, msg=str(options))

    def test_the_environment_variable_names_the_configuration_of_a_view(self):
        self.render()
        plain = self.pixel()
        self.render(config="c.ocio")
        self.assertEqual(self.pixel(), plain)
        self.render("--ocio-view", "Quarter", config=self.path("c.ocio"))
        self.assertAlmostEqual(self.pixel()[0], 51, delta=1)

    def test_backgrounds_keep_their_code_values(self):
        said = self.render("--ocio", "c.ocio", at="5,5")
        self.assertIn("looks past", said)
        self.assertEqual(self.pixel(), (255, 255, 255))

    def test_what_a_configuration_lacks_is_one_line_before_any_work(self):
        os.environ.pop("OCIO", None)
        self.write("broken.ocio", "ocio_profile_version: [")
        self.write("dark.ocio", CONFIG.replace("ROLE", "default").replace("lin_rec709", "mine"))
        for options, words, status in (
                (["--ocio", "c.ocio", "--ocio-view", "Film"], "no view 'Film'; it has Half, Quarter", 1),
                (["--ocio", "c.ocio", "--ocio-view", "TV/Half"], "no display 'TV'; it has Screen, Other", 1),
                (["--ocio", "none.ocio"], "none.ocio", 1),
                (["--ocio", "broken.ocio"], "broken.ocio", 1),
                (["--ocio", "dark.ocio"], "dark.ocio", 1),
                (["--ocio-view", "Half"], "environment variable OCIO", 1),
                (["--ocio", "c.ocio", "--tone-map", "aces"], "--tone-map", 2),
                (["--ocio-view", "Screen/"], "--ocio-view", 2)):
            said = self.render(*options, status=status)
            self.assertEqual(said.count("\n"), 1, said)
            self.assertIn(words, said)
            self.assertFalse(os.path.exists(self.path("a.png")))


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
