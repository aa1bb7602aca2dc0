#!/usr/bin/env python3
"""The layers of an EXR, read by a decoder of the file and of Cryptomatte that shares nothing with the program."""
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = None
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENE = os.path.join(ROOT, "scenes", "alpha_instances.gltf")
SCHEMA = os.path.join(ROOT, "docs", "batch-manifest.schema.json")
# Options of `render` that a manifest does not have: they do not change a picture.
NOT_IN_A_MANIFEST = {"help", "output", "threads", "stats", "record-rays", "explain", "quiet",
                    "resume", "render-part", "merge-parts", "progress", "format", "poses", "poses-form",
                    "views", "turntable", "frames", "fps"}  # which it has in other places


def murmur3_32(data):
    """MurmurHash3_x86_32 with seed 0, from its description."""
    mask = 0xffffffff

    def rotated(x, bits):
        return (x << bits | x >> (32 - bits)) & mask

    def mixed(word):
        return rotated(word * 0xcc9e2d51 & mask, 15) * 0x1b873593 & mask

    h, whole = 0, len(data) // 4 * 4
    for at in range(0, whole, 4):
        h = rotated(h ^ mixed(int.from_bytes(data[at:at + 4], "little")), 13)
        h = (h * 5 + 0xe6546b64) & mask
    h ^= mixed(int.from_bytes(data[whole:], "little")) ^ len(data)
    h = (h ^ h >> 16) * 0x85ebca6b & mask
    h = (h ^ h >> 13) * 0xc2b2ae35 & mask
    return h ^ h >> 16


def identifier(name):
    """A name's id: exponents 0 and 255 are avoided by flipping their last bit."""
    bits = murmur3_32(name.encode())
    return bits ^ 1 << 23 if bits >> 23 & 255 in (0, 255) else bits


class Exr:
    """An uncompressed scanline EXR of one part: attributes as bytes, channels as lists of words."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        assert data[:4] == b"\x76\x2f\x31\x01"
        at, self.attributes = 8, {}

        def text():
            nonlocal at
            end = data.index(b"\0", at)
            word, at = data[at:end].decode(), end + 1
            return word

        while name := text():
            text()  # its type
            size = struct.unpack_from("<I", data, at)[0]
            self.attributes[name] = data[at + 4:at + 4 + size]
            at += 4 + size
        assert self.attributes["compression"] == b"\0"
        x0, y0, x1, y1 = struct.unpack("<4i", self.attributes["dataWindow"])
        width, height = x1 - x0 + 1, y1 - y0 + 1
        names = self.channel_names()
        self.words = {name: [] for name, _ in names}
        for offset in struct.unpack_from(f"<{height}Q", data, at):
            offset += 8  # the row and its size
            for name, size in names:
                self.words[name] += struct.unpack_from(f"<{width}{'HI'[size == 4]}", data, offset)
                offset += size * width

    def channel_names(self):
        """Names and bytes a value, in the order of the file."""
        names, table = [], self.attributes["channels"]
        while table[0]:
            name, _, table = table.partition(b"\0")
            kind = struct.unpack_from("<i", table)[0]
            names.append((name.decode(), 2 if kind == 1 else 4))
            table = table[16:]
        return names

    def floats(self, name):
        words = self.words[name]
        return struct.unpack(f"<{len(words)}f", struct.pack(f"<{len(words)}I", *words))

    def cryptomattes(self):
        """Layers' names and manifests by the rules of the metadata."""
        found = {}
        for key, value in self.attributes.items():
            if not (match := re.fullmatch("cryptomatte/([0-9a-f]{7})/name", key)):
                continue
            name, place = value.decode(), f"cryptomatte/{match[1]}/"
            assert match[1] == f"{murmur3_32(value):08x}"[:7]
            assert self.attributes[place + "hash"] == b"MurmurHash3_32"
            assert self.attributes[place + "conversion"] == b"uint32_to_float32"
            found[name] = json.loads(self.attributes[place + "manifest"])
        return found

    def ranks(self, layer):
        """Per pixel a list of (id, coverage)."""
        pixels = [[] for _ in self.words["R"]]
        for number in range(3):
            for ids, shares in (("R", "G"), ("B", "A")):
                name = f"{layer}{number:02}."
                for pixel, word, share in zip(pixels, self.words[name + ids],
                                              self.floats(name + shares)):
                    pixel.append((word, share))
        return pixels


class LayersTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sightline-layers-")
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "a.exr")

    def render(self, *options):
        subprocess.run([PROGRAM, "render", SCENE, "-o", self.path, "--quiet", "--size", "96x64",
                        "--samples", "4", "--exr-compression", "none", *options], check=True)
        return Exr(self.path)

    def test_hashes_agree_with_the_specification(self):
        self.assertEqual(murmur3_32(b"hello, world"), 0x149bbb7f)
        self.assertEqual(identifier("bunny"), 0x13851a76)

    def test_cryptomatte_decodes_with_its_manifest(self):
        exr = self.render("--aov", "cryptomatte", "--background", "transparent")
        mattes = exr.cryptomattes()
        self.assertEqual(set(mattes), {"CryptoObject", "CryptoMaterial"})
        self.assertTrue({"floor", "leaves", "pane 0 again"} <= set(mattes["CryptoObject"]))
        alpha = exr.floats("A")
        for layer, manifest in mattes.items():
            for name, code in manifest.items():
                self.assertEqual(code, f"{identifier(name):08x}")
            known = {int(code, 16) for code in manifest.values()}
            seen = set()
            for pixel, whole in zip(exr.ranks(layer), alpha):
                self.assertAlmostEqual(sum(share for _, share in pixel), whole, places=5)
                shares = [share for _, share in pixel]
                self.assertEqual(shares, sorted(shares, reverse=True))
                for word, share in pixel:
                    self.assertEqual(word == 0, share == 0)
                    seen.add(word)
            self.assertTrue(seen - {0} <= known)
            self.assertGreater(len(seen), 3)

    def test_light_groups_sum_to_beauty(self):
        exr = self.render("--aov", "lights", "--env", "studio")
        groups = {n.split(".")[1] for n in exr.words if n.startswith("light.")}
        self.assertEqual(groups, {"light", "environment", "emission"})
        for color in "RGB":
            for total, *parts in zip(exr.floats(color),
                                     *(exr.floats(f"light.{g}.{color}") for g in groups)):
                self.assertAlmostEqual(sum(parts), total, delta=1e-5 * max(1, total))

    def test_the_beauty_layer_alone_and_half_floats(self):
        self.assertEqual(set(self.render("--aov", "beauty").words), set("RGBA"))
        exr = self.render("--exr-type", "half")
        sizes = dict(exr.channel_names())
        self.assertEqual({n for n, size in sizes.items() if size == 2},
                         {*"RGBA", *(f"normal.{c}" for c in "XYZ"),
                          *(f"albedo.{c}" for c in "RGB")})

    def test_the_manifest_schema_has_the_options_of_render(self):
        text = subprocess.run([PROGRAM, "render", "--help"], capture_output=True, text=True,
                              check=True).stdout
        options = set(re.findall(r"^  (?:-\w,)?--([a-z-]+)", text, re.M)) - NOT_IN_A_MANIFEST
        self.assertGreater(len(options), 30)
        with open(SCHEMA, encoding="utf-8") as file:
            schema = json.load(file)
        self.assertEqual(set(schema["$defs"]["render"]), options)
        assets = schema["properties"]["assets"]["items"]
        views = schema["$defs"]["pictures"]["views"]["oneOf"][1]["additionalProperties"]
        for place in (schema, assets, views):
            self.assertTrue(options <= set(place["properties"]))
            for name in options:
                self.assertEqual(place["properties"][name], {"$ref": f"#/$defs/render/{name}"})


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
