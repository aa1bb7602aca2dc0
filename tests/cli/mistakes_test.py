#!/usr/bin/env python3
"""Typical mistakes: mistakes.txt has each command, what it prints and how it ends.

mistakes_test.py PROGRAM [--write | unittest's arguments]

--write prints the table as the program answers today, to be read before it is kept.
"""
import json
import os
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
TABLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "mistakes.txt")

ASSET = {
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_materials_variants"],
    "extensions": {"KHR_materials_variants": {"variants": [{"name": "dawn"}, {"name": "dusk"}]}},
    "scenes": [{"name": "one", "nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]}],
    "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"byteLength": 36, "uri": "data.bin"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]}],
}

FILES = {
    "asset.gltf": json.dumps(ASSET),
    "-dash.gltf": json.dumps(ASSET),
    "assets/a.gltf": json.dumps(ASSET),
    "assets/b.gltf": json.dumps(ASSET),
    "data.bin": struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0),
    "assets/data.bin": struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0),
    "broken.gltf": '{"asset": {"version": "2.0"},\n "scenes": [}',
    "empty.gltf": "",
    "page.glb": "<!DOCTYPE html>",
    "chair.obj": "v 0 0 0\n",
    "car.fbx": "Kaydara FBX Binary  \0",
    "renamed.glb": "Kaydara FBX Binary  \0",
    "toy.usdz": "PK\3\4",
    "part.stl": "solid part\n",
    "desk.blend": "BLENDER-v300",
    "broken.json": '{"assets": [',
    "typing.json": '{"assets": [{"path": "asset.gltf", "smaples": 4}]}',
    "lost.json": '{"assets": [{"path": "lost.glb"}]}',
    "outdir/keep": "",
    "none/readme.txt": "",
    "taken": "",
}


def fill(folder):
    for name, content in FILES.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())


def answer(line, folder):
    """What the command prints, with the status in brackets as the last line."""
    done = subprocess.run([PROGRAM, *shlex.split(line)[1:]], cwd=folder, text=True, capture_output=True,
                          timeout=120)
    text = (done.stdout + done.stderr).replace(os.path.realpath(folder), "/HERE").replace(folder, "/HERE")
    return f"{text}[{done.returncode}]\n"


def table():
    """The table's commands and their answers."""
    with open(TABLE, encoding="utf-8") as file:
        entries = re.split(r"^\$ ", file.read(), flags=re.M)[1:]
    for entry in entries:
        line, _, text = entry.partition("\n")
        yield line, re.sub(r"\]\n.*", "]\n", text, flags=re.S)


class Mistakes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-mistakes-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        fill(self.folder)

    def test_are_answered_as_in_the_table(self):
        for line, expected in table():
            with self.subTest(line):
                self.assertEqual(answer(line, self.folder), expected)
        self.assertGreaterEqual(len(list(table())), 50)

    def test_are_answered_in_one_line_without_words_of_libraries(self):
        for line, expected in table():
            with self.subTest(line):
                self.assertEqual(expected.count("\n"), 2, expected)
                self.assertTrue(expected.startswith("sightline: "), expected)
                self.assertIn(expected[-3:], ("1]\n", "2]\n"))
                self.assertNotRegex(expected, r"exception|filesystem|libpng|expected:|TEXT|\b[45]0\d\b")

    def test_write_nothing(self):
        before = sorted(os.walk(self.folder))
        for line, _ in table():
            answer(line, self.folder)
        self.assertEqual(sorted(os.walk(self.folder)), before)


def write():
    """The table with today's answers; other lines are kept."""
    with tempfile.TemporaryDirectory(prefix="sightline-mistakes-") as folder, \
            open(TABLE, encoding="utf-8") as file:
        fill(folder)
        for line in file:
            if line.startswith("$ "):
                sys.stdout.write(line + answer(line[2:], folder))
            elif not (line.startswith("sightline: ") or re.fullmatch(r"\[\d\]\n", line)):
                sys.stdout.write(line)


if __name__ == "__main__":
    write() if sys.argv[1:] == ["--write"] else unittest.main()
