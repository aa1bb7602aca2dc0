#!/usr/bin/env python3
"""The products of tools/make_scenes are faultless, and their surfaces face outwards.

products_test.py PROGRAM [unittest's arguments]
"""
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from collections import Counter

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tools", "benchmark"))

from inputs import read_glb  # noqa: E402

PROGRAM = ""


def make_products(folder):
    subprocess.run([os.path.join(ROOT, "tools/make_scenes"), "--products", folder], check=True)


def meshes(path):
    """The positions, normals and triangles of each mesh of a GLB."""
    document, buffer = read_glb(path)

    def rows(index):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        form = {"VEC3": "<3f", "SCALAR": "<H"}[accessor["type"]]
        return list(struct.iter_unpack(form, buffer[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]))

    for mesh in document["meshes"]:
        primitive = mesh["primitives"][0]
        order = [i for i, in rows(primitive["indices"])]
        yield (rows(primitive["attributes"]["POSITION"]), rows(primitive["attributes"]["NORMAL"]),
               list(zip(order[::3], order[1::3], order[2::3])))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def twice_the_area(positions, triangle):
    """The vector on the front of the triangle."""
    a, b, c = (positions[i] for i in triangle)
    return cross([y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)])


def is_closed(positions, triangles):
    """Whether each edge has a neighbour on its other side; vertices at one place, to a micrometre, are one."""
    places = [tuple(round(1e6 * x) for x in p) for p in positions]
    edges = Counter((places[t[i]], places[t[i - 1]]) for t in triangles for i in range(3))
    return all(edges[b, a] == count for (a, b), count in edges.items() if a != b)


class Products(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        make_products(cls.folder.name)
        cls.paths = [os.path.join(cls.folder.name, name) for name in sorted(os.listdir(cls.folder.name))]

    def test_are_read_without_a_fault(self):
        self.assertEqual(len(self.paths), 12)
        for path in self.paths:
            done = subprocess.run([PROGRAM, "info", path], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertNotIn("warning", done.stdout)

    def test_normals_are_on_the_front_of_their_triangles(self):
        for path in self.paths:
            for positions, normals, triangles in meshes(path):
                sides = [dot(twice_the_area(positions, t), [sum(n) for n in zip(*(normals[i] for i in t))])
                         for t in triangles]
                behind = -sum(s for s in sides if s < 0)
                self.assertLess(behind, 1e-3 * sum(abs(s) for s in sides), path)

    def test_closed_surfaces_face_outwards(self):
        for path in self.paths:
            closed = 0
            for positions, _, triangles in meshes(path):
                if is_closed(positions, triangles):
                    closed += 1
                    volume = sum(dot(positions[t[0]], twice_the_area(positions, t)) for t in triangles)
                    self.assertGreater(volume, 0, path)
            self.assertGreater(closed, 0, path)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
