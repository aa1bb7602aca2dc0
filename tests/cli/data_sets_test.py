#!/usr/bin/env python3
"""`sightline render --data --poses`: 16-bit layers and cameras that agree with each other.

data_sets_test.py PROGRAM [unittest's arguments]
"""
import base64
import json
import math
import os
import struct
import subprocess
import sys
import unittest
import zlib

import batch_test
import layers_test

FAR = [4198400, 1171456, -4646912]
SIZE = (40, 30)


def read_png(path):
    """Width, height, channels, rows of values and texts of a PNG of 16 bits."""
    with open(path, "rb") as file:
        data = file.read()
    at, compressed, texts, kinds = 8, b"", {}, []
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        kinds.append(kind)
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", chunk[:10])
        if kind == b"tEXt":
            key, _, text = chunk.partition(b"\0")
            texts[key.decode()] = text.decode()
        if kind == b"IDAT":
            compressed += chunk
        at += 12 + length
    assert bits == 16, bits
    assert b"sRGB" not in kinds and b"gAMA" not in kinds, "data are no colours"
    channels = {0: 1, 2: 3}[colour]
    raw, step = zlib.decompress(compressed), 2 * channels
    above, rows = bytearray(width * step), []
    for y in range(height):
        begin = y * (width * step + 1)
        row, kind = bytearray(raw[begin + 1:begin + 1 + width * step]), raw[begin]
        for i in range(len(row)):
            left, corner = (row[i - step], above[i - step]) if i >= step else (0, 0)
            row[i] = row[i] + (0, left, above[i], (left + above[i]) // 2,
                               paeth(left, above[i], corner))[kind] & 255
        rows.append(struct.unpack(f">{width * channels}H", bytes(row)))
        above = row
    return width, height, channels, rows, texts


def paeth(a, b, c):
    near = sorted((abs(a + b - c - x), i) for i, x in enumerate((a, b, c)))[0][1]
    return (a, b, c)[near]


def rigid_inverse(m, p):
    """The point in the camera's space; m takes the camera's space to the world's."""
    q = [p[i] - m[i][3] for i in range(3)]
    return [sum(m[i][j] * q[i] for i in range(3)) for j in range(3)]


def project(view, p):
    """The pixel's coordinates and the depth of a point, as docs/data_sets.md says."""
    x, y, z = rigid_inverse(view["camera_to_world"], p)
    (fx, fy), (cx, cy) = view["focal"], view["centre"]
    depth = -z
    divisor = depth if view["projection"] == "perspective" else 1
    return cx + fx * x / divisor, cy - fy * y / divisor, depth


def solid(translation):
    """A wedge of triangles that no view sees edge-on."""
    points = [(0, 0, 0), (2, 0, 0.5), (0.5, 1.5, 0), (0.7, 0.4, 1.6)]
    positions = struct.pack("<12f", *(c for p in points for c in p))
    indices = struct.pack("<12H", 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2)
    asset = batch_test.triangle()
    data = positions + indices
    asset["buffers"] = [{"byteLength": len(data), "uri": "data:application/octet-stream;base64,"
                         + base64.b64encode(data).decode()}]
    asset["bufferViews"] = [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}]
    asset["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                           "min": [0, 0, 0], "max": [2, 1.5, 1.6]},
                          {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]
    asset["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    asset["nodes"] = [{"mesh": 0, "name": "wedge", "translation": translation}]
    asset["scenes"] = [{"nodes": [0]}]
    del asset["cameras"]
    return asset


class DataSets(batch_test.BatchTest):
    def render(self, *arguments, status=0):
        samples = [] if "--samples" in arguments else ["--samples", "1"]
        done = subprocess.run([batch_test.PROGRAM, "render", self.scene, *samples, "--size",
                               f"{SIZE[0]}x{SIZE[1]}", "--exr-compression", "none", *arguments],
                              cwd=self.folder, capture_output=True, text=True, timeout=250)
        self.assertEqual(done.returncode, status, done.stderr)
        self.stdout = done.stdout
        return done.stderr

    def load(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return json.load(file)

    def check_round_trip(self, translation, *arguments):
        """Every point of the position layer, projected by the poses, lies in its pixel at the depth
        that the file says."""
        self.scene = self.add("a.gltf", solid(translation))
        self.render("-o", "{view}.exr", "--views", "front,30/20,-100/-40,top", "--data",
                    "depth,normal,mask,object,material", "--poses", "poses.json", *arguments)
        poses = self.load("poses.json")
        self.assertEqual([v["view"] for v in poses["views"]], ["front", "az030_el20", "az260_el-40", "top"])
        origin = poses["origin"]
        for view in poses["views"]:
            exr = layers_test.Exr(self.path(view["files"][0]))
            exr_origin = exr.attributes.get("sightline:origin", struct.pack("<3d", 0, 0, 0))
            self.assertEqual(list(struct.unpack("<3d", exr_origin)), origin)
            self.check_view(view, exr)
        return poses

    def check_view(self, view, exr):
        layers = {name: read_png(self.path(layer["file"])) for name, layer in view["layers"].items()}
        scale = view["layers"]["depth"]["scale"]
        self.assertEqual(float(layers["depth"][4]["sightline:scale"]), scale)
        depths, ids = ([v for row in layers[name][3] for v in row] for name in ("depth", "object"))
        points = list(zip(*(exr.floats("position." + c) for c in "XYZ")))
        seen = 0
        for i, (depth, point) in enumerate(zip(depths, points)):
            self.assertEqual(depth > 0, ids[i] > 0)
            self.assertEqual(exr.words["object.id"][i], ids[i])
            if depth == 0:
                continue
            seen += 1
            x, y, z = project(view, point)
            column, row = i % view["width"], i // view["width"]
            self.assertLess(abs(x - (column + 0.5)), 0.5 + 1e-3)
            self.assertLess(abs(y - (row + 0.5)), 0.5 + 1e-3)
            # Half a step, and the rounding of floats as large as the depth.
            self.assertLess(abs(z - depth * scale), scale / 2 + z * 2**-20)
        self.assertGreater(seen, len(depths) / 12)
        self.check_normals(view, exr, layers["normal"], ids)
        mask = [v for row in layers["mask"][3] for v in row]
        self.assertEqual([v > 0 for v in mask], [v > 0 for v in ids])

    def check_normals(self, view, exr, normals, ids):
        values = [v for row in normals[3] for v in row]
        layer = view["layers"]["normal"]
        means = list(zip(*(exr.floats("normal." + c) for c in "XYZ")))
        for i, mean in enumerate(means):
            value = values[3 * i:3 * i + 3]
            if not ids[i]:
                self.assertEqual(value, [0, 0, 0])
                continue
            length = math.sqrt(sum(c * c for c in mean))
            for v, c in zip(value, mean):
                self.assertAlmostEqual((v - layer["zero"]) * layer["scale"], c / length,
                                       delta=layer["scale"])

    def test_points_land_where_the_depth_says_in_perspective(self):
        self.assertEqual(self.check_round_trip([0, 0, 0])["origin"], [0, 0, 0])

    def test_points_land_where_the_depth_says_without_perspective(self):
        poses = self.check_round_trip([3, 0, 0], "--ortho")
        self.assertEqual({v["projection"] for v in poses["views"]}, {"orthographic"})

    def test_points_land_where_the_depth_says_far_from_the_origin(self):
        for arguments in ([], ["--ortho"]):
            poses = self.check_round_trip(FAR, *arguments)
            for given, found in zip(FAR, poses["origin"]):
                self.assertLess(abs(given - found), 3)
                self.assertNotEqual(found, 0)

    def test_points_land_where_the_depth_says_in_a_tiny_scene(self):
        asset = solid([0, 0, 0])
        asset["nodes"][0]["scale"] = [1e-7] * 3
        self.add("a.gltf", asset)
        for arguments in ([], ["--ortho"]):
            self.scene = self.path("assets", "a.gltf")
            self.render("-o", "a.exr", "--camera", "30/20", "--data", "depth,normal,mask,object",
                        "--poses", "poses.json", *arguments)
            view = self.load("poses.json")["views"][0]
            self.check_view(view, layers_test.Exr(self.path("a.exr")))

    def test_a_crop_has_the_pixels_of_its_window(self):
        self.scene = self.add("a.gltf", solid([0, 0, 0]))
        self.render("-o", "a.exr", "--camera", "30/20", "--crop", "10,5,30,25", "--data",
                    "depth,normal,mask,object", "--poses", "poses.json")
        view = self.load("poses.json")["views"][0]
        self.assertEqual((view["width"], view["height"], view["centre"]), (20, 20, [10, 10]))
        self.check_view(view, layers_test.Exr(self.path("a.exr")))

    def test_the_known_corners_of_a_far_asset_project_into_its_outline(self):
        """Independent of the renderer's own positions: the asset's vertices, in double."""
        self.scene = self.add("a.gltf", solid(FAR))
        self.render("-o", "{view}.png", "--views", "front,30/20", "--data", "mask", "--poses", "poses.json")
        poses = self.load("poses.json")
        corners = [[c + t - o for c, t, o in zip(p, FAR, poses["origin"])]
                   for p in [(0, 0, 0), (2, 0, 0.5), (0.5, 1.5, 0), (0.7, 0.4, 1.6)]]
        for view in poses["views"]:
            rows = read_png(self.path(view["layers"]["mask"]["file"]))[3]
            seen = [(x, y) for y, row in enumerate(rows) for x, v in enumerate(row) if v]
            found = [project(view, c) for c in corners]
            for axis in (0, 1):
                low, high = min(p[axis] for p in seen), max(p[axis] for p in seen) + 1
                # A corner sharper than a pixel may miss the one sample of its last pixels.
                self.assertAlmostEqual(min(f[axis] for f in found), low, delta=2)
                self.assertAlmostEqual(max(f[axis] for f in found), high, delta=2)

    def test_a_mask_has_the_coverage_of_a_transparent_background(self):
        self.scene = self.add("a.gltf", solid([0, 0, 0]))
        self.render("-o", "a.png", "--data", "mask", "--background", "transparent", "--samples", "16")
        values = {v for row in read_png(self.path("a.mask.png"))[3] for v in row}
        self.assertTrue({0, 65535} < values, values)

    def test_a_fixed_scale_is_kept_and_refused_where_it_is_too_small(self):
        self.scene = self.add("a.gltf", solid([0, 0, 0]))
        self.render("-o", "a.png", "--data", "depth", "--depth-scale", "0.001", "--poses", "poses.json")
        self.assertEqual(read_png(self.path("a.depth.png"))[4]["sightline:scale"], "0.001")
        os.remove(self.path("a.png")), os.remove(self.path("a.depth.png"))
        message = self.render("-o", "a.png", "--data", "depth", "--depth-scale", "1e-7", "--quiet", status=1)
        self.assertRegex(message, r"^sightline: a.depth.png: a depth of .* use a --depth-scale of .*\n$")
        self.assertFalse(os.path.exists(self.path("a.png")))
        self.assertFalse(os.path.exists(self.path("a.depth.png")))

    def test_data_do_not_change_the_picture(self):
        self.scene = self.add("a.gltf", solid([0, 0, 0]))
        self.render("-o", "a.png"), self.render("-o", "b.png", "--data", "depth,normal,mask,object,material")
        with open(self.path("a.png"), "rb") as a, open(self.path("b.png"), "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_the_forms_of_radiance_field_tools_have_the_same_cameras(self):
        self.scene = self.add("a.gltf", solid(FAR))
        os.makedirs(self.path("set"))
        for form in ("sightline", "nerfstudio", "blender"):
            self.render("-o", "set/{view}.png", "--views", "ring:3@20", "--data", "depth,mask", "--poses",
                        f"set/{form}.json", "--poses-form", form, "--depth-scale", "0.001")
        poses = self.load("set/sightline.json")
        for form in ("nerfstudio", "blender"):
            transforms = self.load(f"set/{form}.json")
            self.assertEqual(transforms["origin"], poses["origin"])
            self.assertEqual((transforms["w"], transforms["h"]), SIZE)
            self.assertAlmostEqual(transforms["fl_x"], SIZE[0] / 2 / math.tan(transforms["camera_angle_x"] / 2))
            self.assertEqual([transforms["cx"], transforms["cy"]], [SIZE[0] / 2, SIZE[1] / 2])
            for frame, view in zip(transforms["frames"], poses["views"]):
                self.assertEqual(frame["transform_matrix"], view["camera_to_world"])
                self.assertEqual([transforms["fl_x"], transforms["fl_y"]], view["focal"])
                name = frame["file_path"] + ("" if form == "nerfstudio" else ".png")
                self.assertTrue(os.path.exists(self.path("set", name)), name)
                self.assertEqual(frame["depth_scale"], 0.001)
                for key in ("depth_file_path", "mask_path"):
                    self.assertTrue(os.path.exists(self.path("set", frame[key])))

    def test_what_cannot_be_is_refused_before_anything_is_written(self):
        self.scene = self.add("a.gltf", solid([0, 0, 0]))
        for arguments, reason in (
                (["-o", "a.png", "--poses", "p.json", "--poses-form", "blender", "--ortho"], "no orthographic"),
                (["-o", "a.mp4", "--turntable", "9", "--poses", "p.json"], "are of pictures"),
                (["-o", "a.mp4", "--turntable", "9", "--data", "depth"], "are of pictures"),
                (["-o", "a.png", "-o", "a.depth.png", "--data", "depth"], "a.depth.png is given as output twice"),
                (["-o", "a.png", "--poses", "a.png"], "a.png is given as output twice"),
                (["-o", "a.png", "--data", "colour"], "'colour' is not one of")):
            self.assertIn(reason, self.render(*arguments, status=2))
        self.assertIn("the folder no does not exist",
                      self.render("-o", "a.png", "--poses", "no/p.json", status=1))
        self.assertEqual(os.listdir(self.folder), ["assets"])


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
