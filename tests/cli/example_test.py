#!/usr/bin/env python3
"""Runs one of the programs in examples/ and checks what it makes.

Usage: example_test.py PROGRAM, whose name chooses the check.
"""
import os
import re
import struct
import subprocess
import sys
import tempfile
import zlib


def png_bytes(path):
    """The size of a PNG and its filtered rows: all of them zero where the picture is black."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
    at, compressed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            size = struct.unpack(">II", data[at + 8:at + 16])
        if kind == b"IDAT":
            compressed += data[at + 8:at + 8 + length]
        at += 12 + length
    return size, zlib.decompress(compressed)


def check_render_scene(folder, output):
    size, rows = png_bytes(os.path.join(folder, "ball.png"))
    assert size == (320, 240), size
    colours = sum(1 for value in rows if value)
    assert colours > len(rows) / 4, f"{colours} of {len(rows)} bytes are not zero"
    with open(os.path.join(folder, "ball.exr"), "rb") as file:
        assert file.read(4) == b"\x76\x2f\x31\x01", "ball.exr is no EXR"
    assert re.search(r"\b300 tiles\b", output), output


def check_compare_engines(_, output):
    different, rays = map(int, re.search(r"^(\d+) of (\d+) hits differ", output).groups())
    right = dict(re.findall(r"^(\S+) is right in (\d+) of them", output, re.M))
    assert rays == 5000 and different > 100, output
    assert int(right["exact"]) == different, output
    assert int(right["embree-default"]) < different, output


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run([program], cwd=folder, check=True, text=True, capture_output=True)
        globals()["check_" + os.path.basename(program)](folder, run.stdout)


if __name__ == "__main__":
    main(os.path.abspath(sys.argv[1]))
