#!/usr/bin/env python3
"""What a batch's journal says of memory and time: each picture's own, limits by their name.

batch_memory_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import batch_test

SIDE = 8192  # texels of 4 bytes: a texture takes 256 MiB, its pyramid a third more


def plain_png(side, color):
    """A PNG of one colour with alpha."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    packer = zlib.compressobj(1)
    row = b"\0" + bytes(color) * side
    pixels = b"".join(packer.compress(row) for _ in range(side)) + packer.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0))
            + chunk(b"IDAT", pixels) + chunk(b"IEND", b""))


def textured():
    """The triangle with a base colour and an emissive texture."""
    asset = batch_test.triangle()
    asset["images"] = [{"uri": "first.png"}, {"uri": "second.png"}]
    asset["textures"] = [{"source": 0}, {"source": 1}]
    asset["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
                           "emissiveTexture": {"index": 1}, "emissiveFactor": [1, 1, 1]}]
    asset["accessors"].append(dict(asset["accessors"][0], type="VEC2", max=[1, 1], min=[0, 0]))
    asset["meshes"][0]["primitives"][0].update(
        material=0, attributes={"POSITION": 0, "TEXCOORD_0": 1})
    return asset


def limited_group(limit):
    """The folder of a new control group with that limit of bytes; None if there can be none."""
    for parent, file in (("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")):
        try:
            group = tempfile.mkdtemp(prefix="sightline-", dir=parent)
        except OSError:
            continue
        try:
            # A file that the kernel does not provide cannot be opened.
            with open(os.path.join(group, file), "r+", encoding="utf-8") as limit_file:
                limit_file.write(str(limit))
            return group
        except OSError:
            os.rmdir(group)
    return None


class Memory(batch_test.BatchTest):
    def setUp(self):
        super().setUp()
        self.add("small.gltf", batch_test.triangle())

    def add_large(self):
        if "asan" in batch_test.PROGRAM or "fuzz" in batch_test.PROGRAM:
            self.skipTest("Notice: sanitizers take memory of their own")
        self.add("large.gltf", textured())
        for name, color in (("first.png", (9, 8, 7, 255)), ("second.png", (1, 2, 3, 255))):
            with open(self.path("assets", name), "wb") as file:
                file.write(plain_png(SIDE, color))

    def journal(self):
        with open(os.path.join(self.out, "journal.jsonl"), encoding="utf-8") as file:
            return {line["name"]: line for line in map(json.loads, file)}

    def test_of_each_picture_is_its_own_in_a_worker_that_is_used_again(self):
        self.add_large()
        self.batch("--jobs", "1", "--full-textures")
        lines = self.journal()
        self.assertEqual(list(lines), ["large", "small"])
        self.assertGreater(lines["large"]["memory"], 2 * SIDE * SIDE * 4)
        self.assertLess(lines["small"]["memory"], lines["large"]["memory"] - SIDE * SIDE * 4)

    def test_beyond_the_limit_is_a_verdict_that_names_it(self):
        self.add_large()
        self.batch("--jobs", "1", "--full-textures", "--memory", "500", status=3)
        lines = self.journal()
        self.assertEqual(lines["small"]["verdict"], "ok")
        self.assertEqual(lines["large"]["verdict"], "out-of-memory")
        self.assertIn("500 MiB (--memory)", lines["large"]["message"])
        self.assertGreater(lines["large"]["seconds"], 0)
        self.assertGreater(lines["large"]["memory"], 0)

    def test_that_the_kernel_denies_is_a_verdict_too(self):
        self.add_large()
        group = limited_group(300 << 20)
        if not group:
            self.skipTest("Notice: no control group with a limit of memory can be made here")
        self.addCleanup(os.rmdir, group)

        def enter():
            with open(os.path.join(group, "cgroup.procs"), "w", encoding="utf-8") as file:
                file.write(str(os.getpid()))
        done = subprocess.run(self.command("--jobs", "1", "--full-textures"), capture_output=True, text=True,
                              cwd=self.folder, timeout=250, preexec_fn=enter)
        self.assertEqual(done.returncode, 3, done.stderr)
        lines = self.journal()
        self.assertEqual(lines["small"]["verdict"], "ok")
        self.assertEqual(lines["large"]["verdict"], "out-of-memory")
        self.assertIn("the machine has no more", lines["large"]["message"])

    def test_and_time_of_a_picture_that_took_too_long_are_recorded(self):
        self.batch("--timeout", "0.5", *batch_test.SLOW, status=3)
        for line in self.journal().values():
            self.assertEqual(line["verdict"], "timeout")
            self.assertGreaterEqual(line["seconds"], 0.5)
            self.assertGreater(line["memory"], 0)

    def test_is_not_taken_for_a_file_that_is_too_large(self):
        with open(self.path("sky.hdr"), "wb") as file:
            file.truncate(100 << 30)
        self.batch("--env", self.path("sky.hdr"), status=3)
        for line in self.journal().values():
            self.assertEqual(line["verdict"], "failed")
            self.assertIn("more than the limit", line["message"])


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
