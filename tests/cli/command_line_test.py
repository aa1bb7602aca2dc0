#!/usr/bin/env python3
"""The command line's contract: exit codes, one line per error, results alone on stdout."""
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
SCENES = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scenes")
SMALL = ["--size", "16x12", "--samples", "1"]

# A triangle that an animation moves, in two scenes, with two variants of its material.
ASSET = {
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_materials_variants"],
    "extensions": {"KHR_materials_variants": {"variants": [{"name": "dawn"}, {"name": "dusk"}]}},
    "scene": 0,
    "scenes": [{"name": "one", "nodes": [0]}, {"name": "two", "nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"name": "eye", "camera": 0, "translation": [0, 0, 3]}],
    "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
    "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}},
                  {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}}],
    "meshes": [{"primitives": [{
        "attributes": {"POSITION": 0}, "material": 0,
        "extensions": {"KHR_materials_variants": {
            "mappings": [{"material": 1, "variants": [1]}]}}}]}],
    "animations": [{"name": "up", "channels": [
        {"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 1, "output": 2}]}],
    "buffers": [{"byteLength": 68, "uri": "data.bin"}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
                    {"buffer": 0, "byteOffset": 36, "byteLength": 8},
                    {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
         "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR",
         "min": [0], "max": [2.5]},
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
}


def floats(*values):
    return struct.pack(f"<{len(values)}f", *values)


class CommandLineTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-command-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        shutil.copy(os.path.join(SCENES, "whitted.gltf"), self.folder)
        with open(self.path("asset.gltf"), "w", encoding="utf-8") as file:
            json.dump(ASSET, file)
        with open(self.path("data.bin"), "wb") as file:
            file.write(floats(0, 0, 0, 1, 0, 0, 0, 1, 0))
            file.write(floats(0, 2.5))
            file.write(floats(0, 1, 0, 0, 4, 0))

        os.mkfifo(self.path("pipe"))

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_it(self, *words, status=0):
        done = subprocess.run([PROGRAM, *words], cwd=self.folder, text=True, capture_output=True,
                              timeout=120)
        self.assertEqual(done.returncode, status, f"{words}: {done.stdout}{done.stderr}")
        return done

    def refused(self, *words, status, message):
        """One line on stderr, nothing on stdout, no picture."""
        done = self.run_it(*words, status=status)
        self.assertEqual(done.stdout, "")
        self.assertTrue(done.stderr.startswith("sightline: "), done.stderr)
        self.assertIn(message, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertFalse(os.path.exists(self.path("a.exr")))

    def test_a_bad_option_is_a_usage_error(self):
        scene = ["whitted.gltf", "-o", "a.exr"]
        for words in (
                ["--samples", "0"], ["--samples", "1.5"], ["--threads", "0"], ["--seed", "-1"],
                ["--size", "64x"], ["--size", "0x5"], ["--size", "70000x1"], ["--no-such", "1"], ["--light", "moon"],
                ["--background", "1,2"], ["--background", "nan,0,0"], ["--exposure", "nan"],
                ["--exposure", "1e9"], ["--env-rotation", "inf"], ["--fov", "nan"], ["--fov", "180"],
                ["--aperture", "nan"], ["--focus", "1e99"], ["--time", "nan"], ["--error", "nan"],
                ["--look-from", "0,0,inf"], ["--look-from", "1,2,3", "--look-at", "1,2,3"],
                ["--up", "0,0,0"], ["--orbit", "nan"], ["--crop", "0,0,600,9"],
                ["--intersector", "no-such"], ["--intersector", "embree:loop"], ["--isa", "mmx"],
                ["--aov", "no-such"], ["--tone-map", "no-such"], ["--integrator", "no-such"],
                ["--single-sided-shadows", "yes"],
                ["--samples", "1", "--error", "0.1"], ["-o", "a.bmp"], ["-o", "./a.exr"],
                ["--stats", "a.exr"], ["--record-rays", "x/../a.exr"]):
            with self.subTest(words):
                self.refused("render", *scene, *words, status=2, message="sightline render --help")

    def test_a_usage_error_names_the_option_its_value_and_what_it_accepts(self):
        for words, message in (
                (["--samples", "0"], "--samples: '0' is not a whole number from 1 to 1048576"),
                (["--seed", "-1"], "--seed: '-1' is not a whole number from 0"),
                (["--fov", "inf"], "--fov: 'inf' is not a number from 0.01 to 179"),
                (["--tone-map", "x"], "--tone-map: 'x' is not one of pbr-neutral, aces, agx, none"),
                (["--crop", "5,5,5,9"], "--crop: '5,5,5,9' is empty"),
                (["--samples", "1", "--error", "0.1"], "--samples cannot be combined with --error"),
                (["--no-such"], "render has no option --no-such")):
            with self.subTest(words):
                self.refused("render", "whitted.gltf", "-o", "a.exr", *words, status=2,
                             message=message)

    def test_help_shows_one_line_of_choices_ranges_and_defaults_per_option(self):
        text = self.run_it("render", "--help").stdout
        headings = re.findall(r"^(\S[^:\n]*):$", text, re.M)
        self.assertEqual(headings, ["Arguments", "Input", "View", "Light", "Quality", "Output",
                                    "Layers", "Resume and parts", "Several pictures", "Performance",
                                    "Other"])
        self.assertIn("  --samples N                 Samples per pixel, 1 to 1048576 [64]\n", text)
        self.assertIn("Light transport: whitted, appel [whitted]\n", text)
        for noise in ("Excludes", "Needs:", "REQUIRED", "INT", "FLOAT", "TEXT", " in ["):
            self.assertNotIn(noise, text)

    def test_a_command_has_no_option_that_it_does_not_use(self):
        for words in (["info", "whitted.gltf", "--samples", "4"],
                      ["info", "whitted.gltf", "--tone-map", "aces"],
                      ["info", "whitted.gltf", "--up", "0,1,0"],
                      ["info", "whitted.gltf", "--max-image-pixels", "9"],
                      ["compare", "whitted.gltf", "--report", "r", "--aov", "depth"]):
            self.refused(*words, status=2, message=f"{words[0]} has no option {words[-2]}")

    def test_the_example_of_a_commands_help_is_of_that_command(self):
        for command in ("render", "batch", "info", "diff", "compare", "atlas"):
            with self.subTest(command):
                last = self.run_it(command, "--help").stdout.strip().splitlines()[-1]
                self.assertRegex(last, f"^Try `sightline {command} .*`.$")

    def test_whole_numbers_may_have_exponents(self):
        for number, name in (("4", "a.png"), ("4e0", "b.png"), ("0.4E1", "c.png")):
            self.run_it("render", "asset.gltf", "-o", name, "--size", "16x12", "--samples", number)
        differences = self.run_it("diff", "a.png", "b.png", "c.png").stdout
        self.assertEqual(differences.count("rmse 0, largest 0,"), 2, differences)
        for bad in ("1e-3", "1e", "15e-1", "1e99"):
            self.refused("render", "asset.gltf", "-o", "a.exr", "--samples", bad, status=2,
                         message=f"--samples: '{bad}' is not a whole number from 1 to 1048576")

    def test_a_file_name_may_begin_with_a_dash(self):
        shutil.copy(self.path("asset.gltf"), self.path("-dash.gltf"))
        self.run_it("render", *SMALL, "-o", "-a.png", "--", "-dash.gltf")
        self.run_it("render", "./-dash.gltf", *SMALL, "--output=-b.png")
        self.assertTrue(os.path.exists(self.path("-a.png")) and os.path.exists(self.path("-b.png")))

    def test_an_option_with_several_values_takes_one_word(self):
        self.run_it("render", "--aov", "depth", "asset.gltf", *SMALL, "-o", "a.exr")

    def test_more_threads_than_cores_are_no_reason_to_warn(self):
        done = self.run_it("render", "asset.gltf", *SMALL, "-o", "a.png", "--threads", "64", "--quiet")
        self.assertEqual(done.stdout + done.stderr, "")

    def test_an_environment_above_its_limit_is_refused(self):
        words = ["render", "asset.gltf", *SMALL, "-o", "a.exr", "--env", "data.bin", "--max-env-bytes"]
        self.refused(*words, "67", status=1, message="data.bin: 68 bytes, more than the limit of 67 (--max-env-bytes)")
        self.refused(*words, "68", status=1, message="not a PNG")

    def test_a_bad_file_is_one_line(self):
        for words, message in (
                (["no-such.gltf", "-o", "a.exr"], "no-such.gltf: cannot open"),
                (["asset.gltf", "-o", "x/a.exr"], "x/a.exr: the folder x does not exist"),
                (["asset.gltf", "-o", "a.exr", "--stats", "x/s.json"], "the folder x does not"),
                (["asset.gltf", "-o", "a.exr", "--stats", "pipe"], "pipe: cannot write: is not a regular file"),
                (["pipe", "-o", "a.exr"], "pipe: not a regular file"),
                (["asset.gltf", "-o", "a.exr", "--env", "pipe"], "pipe: not a regular file"),
                (["asset.gltf", "-o", "a.exr", "--record-rays", "x/r"], "the folder x does not"),
                (["asset.gltf", "-o", "a.exr", "--env", "no-such.hdr"], "no-such.hdr: does not exist"),
                (["asset.gltf", "-o", "a.exr", "--env", "data.bin"], "not a PNG"),
                (["asset.gltf", "-o", "a.exr", "--camera", "nose"],
                 'there is no camera "nose"; the file has none; the views that frame the scene are fit, '),
                (["asset.gltf", "-o", "a.exr", "--scene", "two", "--camera", "1"],
                 'there is no camera "1"; the file has 0 "eye"'),
                (["asset.gltf", "-o", "a.exr", "--scene", "three"],
                 'there is no scene "three"; the file has 0 "one", 1 "two"'),
                (["asset.gltf", "-o", "a.exr", "--variant", "noon"],
                 'there is no variant "noon"; the file has 0 "dawn", 1 "dusk"'),
                (["asset.gltf", "-o", "a.exr", "--animation", "down"],
                 'there is no animation "down"; the file has 0 "up"'),
                (["whitted.gltf", "-o", "a.exr", "--animation", "up"],
                 'there is no animation "up"; the file has none')):
            with self.subTest(words):
                self.refused("render", *words, *SMALL, status=1, message=message)

    def write_faulty_asset(self):
        faulty = {**ASSET, "samplers": [{"wrapS": 10496}]}
        with open(self.path("faulty.gltf"), "w") as file:
            json.dump(faulty, file)
        return "samplers[0].wrapS: 10496 is not one of: 33071 33648 10497"

    def test_a_file_with_a_fault_is_drawn_with_a_warning_and_refused_by_strict(self):
        fault = self.write_faulty_asset()
        words = ["faulty.gltf", "-o", "a.exr", *SMALL]
        self.refused("render", *words, "--strict", status=1, message=f"faulty.gltf: {fault}\n")
        self.refused("info", "faulty.gltf", "--strict", status=1, message=fault)
        done = self.run_it("render", *words, "--stats", "s.json", "--quiet")
        self.assertTrue(done.stderr.startswith(f"warning: faulty.gltf: {fault}: "), done.stderr)
        with open(self.path("s.json")) as file:
            stats = json.load(file)
        info = json.loads(self.run_it("info", "faulty.gltf", "--json").stdout)
        for report in (stats, info):
            self.assertEqual(report["fault_count"], 1)
            self.assertEqual([(f["key"], f["place"]) for f in report["faults"]],
                             [("sampler-choice", "samplers[0].wrapS")])

    def test_info_lists_the_faults_of_images_and_animations_too(self):
        asset = {**ASSET, "images": [{"uri": "data:image/png;base64,AAAA"}, {"uri": "lost.png"}],
                 "animations": [{**ASSET["animations"][0], "channels": [
                     {"sampler": 7, "target": {"node": 0, "path": "translation"}}]}]}
        with open(self.path("faulty.gltf"), "w") as file:
            json.dump(asset, file)
        info = json.loads(self.run_it("info", "faulty.gltf", "--json").stdout)
        self.assertEqual([(f["key"], f["place"]) for f in info["faults"]],
                         [("channel", "animations[0].channels[0]"),
                          ("missing-texture", "images[1].uri"),
                          ("unreadable-texture", "images[0]")])
        self.assertIn("warning: images[0]: ", self.run_it("info", "faulty.gltf").stdout)
        self.refused("info", "faulty.gltf", "--strict", status=1, message="animations[0].channels[0]")

    def test_the_page_of_faults_is_what_the_program_prints(self):
        with open(os.path.join(os.path.dirname(SCENES), "docs", "faults.md")) as file:
            self.assertEqual(file.read(), self.run_it("faults").stdout)

    def bounds(self, *words):
        return json.loads(self.run_it("info", "asset.gltf", "--json", *words).stdout)["bounds"]

    def test_an_animation_alone_is_posed_at_its_beginning(self):
        self.assertEqual(self.bounds()[0], [0, 0, 0])
        self.assertEqual(self.bounds("--animation", "up")[0], [0, 1, 0])
        self.assertEqual(self.bounds("--animation", "0", "--time", "2.5")[0], [0, 4, 0])
        self.assertEqual(self.bounds("--time", "9")[0], [0, 4, 0])

    def test_info_lists_scenes_variants_animations_cameras_and_extensions(self):
        info = json.loads(self.run_it("info", "asset.gltf", "--json", "--scene", "two").stdout)
        self.assertEqual(info["scenes"], ["one", "two"])
        self.assertEqual(info["variants"], ["dawn", "dusk"])
        self.assertEqual(info["animations"], [{"name": "up", "seconds": 2.5}])
        self.assertEqual(info["cameras"], ["eye"])
        self.assertEqual(info["extensions"], ["KHR_materials_variants"])
        self.assertIn("dusk", self.run_it("info", "asset.gltf").stdout)

    def test_info_and_render_report_the_same_needs(self):
        self.run_it("render", "whitted.gltf", "-o", "a.png", "--stats", "s.json", *SMALL)
        with open(self.path("s.json"), encoding="utf-8") as file:
            rendered = {n["name"]: n["choice"] for n in json.load(file)["needs"]}
        info = json.loads(self.run_it("info", "whitted.gltf", "--json").stdout)["needs"]
        for name, need in info.items():
            self.assertEqual(need["choice"], rendered[name], name)

    def test_the_stages_of_a_render_add_up(self):
        self.run_it("render", "whitted.gltf", "-o", "a.png", "--stats", "s.json", *SMALL)
        with open(self.path("s.json"), encoding="utf-8") as file:
            seconds = json.load(file)["seconds"]
        self.assertEqual(list(seconds), ["open", "parse", "pose", "decode", "build", "prepare", "trace", "shade",
                                         "write", "load", "render", "total"])
        self.assertGreater(seconds["trace"], 0)
        self.assertGreater(seconds["shade"], 0)
        self.assertAlmostEqual(seconds["trace"] + seconds["shade"], seconds["render"])
        self.assertAlmostEqual(seconds["open"] + seconds["parse"] + seconds["decode"], seconds["load"])
        self.assertLessEqual(sum(list(seconds.values())[:9]), seconds["total"])

    def test_an_ending_in_capitals_is_the_same_format(self):
        for name in ("a.exr", "A.EXR"):
            self.run_it("render", "asset.gltf", "-o", name, *SMALL)
        with open(self.path("A.EXR"), "rb") as file:
            self.assertIn(b"depth.Z", file.read(4000))

    def test_names_of_pictures_go_to_stdout_and_messages_to_stderr(self):
        done = self.run_it("render", "asset.gltf", "-o", "a.exr", "-o", "a.png", *SMALL)
        self.assertEqual(done.stdout, "a.exr\na.png\n")
        self.assertRegex(done.stderr, r"^camera: fit \(the file has no camera\); light: studio .*\n[\d.]+ s: load .*\n$")
        done = self.run_it("render", "asset.gltf", "-o", "a.exr", "--quiet", *SMALL)
        self.assertEqual(done.stdout + done.stderr, "")

    def test_a_full_standard_output_is_an_error(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([PROGRAM, "info", "asset.gltf"], cwd=self.folder, text=True,
                                  stdout=full, stderr=subprocess.PIPE, check=False)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)

    def test_layers_without_an_exr_are_a_warning(self):
        done = self.run_it("render", "asset.gltf", "-o", "a.png", "--aov", "depth", *SMALL)
        self.assertIn("warning: asset.gltf: --aov: only .exr holds layers", done.stderr)
        done = self.run_it("render", "asset.gltf", "-o", "a.exr", "--aov", "depth", *SMALL)
        self.assertNotIn("warning", done.stderr)


if __name__ == "__main__":
    unittest.main()
