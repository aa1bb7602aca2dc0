#!/usr/bin/env python3
"""CGAL's AABB tree and the referee agree on difficult rays: engines_cgal_test.py SIGHTLINE CGAL_ENGINE.

SIGHTLINE_CGAL_RAYS sets the number of rays.
"""
import base64
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM, ENGINE = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
RAYS = int(os.environ.get("SIGHTLINE_CGAL_RAYS", 100000))
MISTAKES = ("near_tie", "missed", "false_hit", "wrong_primitive", "wrong_t", "wrong_uv", "undecidable",
            "unjudged", "unchecked")

# Dyadic numbers, so that rays through a vertex of a copy can be written without rounding.
SHEARED = [1, 0, 0, 0, 1.5, 1, 0, 0, 0, 0.125, 1, 0, 0, 0, 0, 1]
MIRRORED = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1]
ALMOST_FLAT = [1, 0, 2 ** -12, 0, 0, 1, 0, 0, 0, 0, 2 ** -14, 0, 0, 0, 0, 1]  # still instanced
IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
FAR = [8, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 4096, 0, 1]


def lattice(choice):
    """A point whose coordinates are multiples of 1/4."""
    return [choice.randrange(9) / 4 - 1 for _ in range(3)]


def difficult_mesh(seed):
    """Triangles on a lattice, so that vertices, edges and faces coincide; slivers; copies; degenerate ones."""
    choice, points = random.Random(seed), []
    for i in range(24):
        a, b, c = (lattice(choice) for _ in range(3))
        if i % 4 == 0:  # a sliver
            c = [b[0] + 2 ** -20, b[1], b[2] + 2 ** -22]
        elif i % 4 == 1:  # two faces in one plane that overlap
            for point in (a, b, c):
                point[2] = 0.25
        points += [a, b, c]
    triangles = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(24)]
    triangles += triangles[:6] + [(c, b, a) for a, b, c in triangles[6:12]] + [(0, 0, 1)]
    return points, triangles


def globe(steps):
    """A closed mesh, with thin triangles at its poles."""
    points = [(math.sin(math.pi * i / steps) * math.cos(math.pi * k / steps),
               math.cos(math.pi * i / steps), math.sin(math.pi * i / steps) * math.sin(math.pi * k / steps))
              for i in range(steps + 1) for k in range(2 * steps)]
    triangles = []
    for i in range(steps):
        for k in range(2 * steps):
            here, beside = 2 * steps * i + k, 2 * steps * i + (k + 1) % (2 * steps)
            triangles += [(here, beside, here + 2 * steps), (beside, beside + 2 * steps, here + 2 * steps)]
    return points, triangles


def write_scene(path, placed_meshes):
    """A glTF file of (mesh, matrices) pairs; a mesh with several matrices is instanced."""
    data, views, accessors, meshes, nodes = b"", [], [], [], []

    def add(rows, kind, component, letter):
        nonlocal data
        packed = b"".join(struct.pack(f"<3{letter}", *row) for row in rows)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
        data += packed
        count = len(rows) if kind == "VEC3" else 3 * len(rows)
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count,
                          "type": kind})
        if kind == "VEC3":
            stored = list(struct.iter_unpack("<3f", packed))
            accessors[-1].update(min=list(map(min, *stored)), max=list(map(max, *stored)))
        return len(accessors) - 1

    for (points, triangles), matrices in placed_meshes:
        position = add(points, "VEC3", 5126, "f")
        meshes.append({"primitives": [{"attributes": {"POSITION": position},
                                       "indices": add(triangles, "SCALAR", 5125, "I")}]})
        nodes += [{"mesh": len(meshes) - 1, "matrix": matrix} for matrix in matrices]
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    with open(path, "w") as file:
        json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}],
                   "nodes": nodes, "meshes": meshes, "accessors": accessors, "bufferViews": views,
                   "buffers": [{"uri": uri, "byteLength": len(data)}]}, file)


def moved(point, matrix):
    """point · matrix, whose columns the list has one after the other."""
    return [sum(x * matrix[4 * i + k] for i, x in enumerate(point)) + matrix[12 + k] for k in range(3)]


def exact_rays(mesh, matrices, count):
    """Rays that meet vertices and the middles of edges exactly, or run along edges, as the formats hold them."""
    choice, rays = random.Random(count), []
    points, triangles = mesh
    for i in range(count):
        a, b = (points[corner] for corner in choice.choice(triangles)[:2])
        matrix = choice.choice(matrices)
        target = moved(a if i % 2 else [(x + y) / 2 for x, y in zip(a, b)], matrix)
        origin = moved(b, matrix) if i % 8 == 0 else [3 * x for x in lattice(choice)]
        direction = [x - y for x, y in zip(target, origin)]
        direction = direction if any(direction) else [1, 0, 0]
        # Segments may end or begin at the target.
        tnear, tfar = choice.choice([(0, math.inf), (0, math.inf), (0, 1), (1, math.inf), (0.5, 2)])
        rays.append(struct.pack("<8fI", *origin, tnear, *direction, tfar, i % 4))
    return rays


COPIES = [(difficult_mesh(2), [SHEARED, MIRRORED, ALMOST_FLAT, FAR]), (globe(8), [SHEARED, ALMOST_FLAT])]


class EngineOfCgal(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_program(self, *command):
        result = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)

    def compare(self, *options):
        # Embree's wrong answers would be judged too, at several times the price.
        self.run_program(PROGRAM, "compare", self.path("scene.gltf"), "--quiet", "--rounds", "1", "--intersector",
                         "exact", "--methods", "exact", "--report", self.path("report"), "--overwrite", *options)

    def verdicts(self, *options, engine_options=()):
        """Lets CGAL answer the recorded rays, and returns the number of its answers by verdict."""
        self.run_program(PROGRAM, "compare", self.path("scene.gltf"), "--quiet", *options, "--export-triangles",
                         self.path("triangles"))
        self.run_program(ENGINE, self.path("triangles"), self.path("rays"), self.path("answers"), *engine_options)
        self.compare("--rays", self.path("rays"), "--answers", "cgal=" + self.path("answers"), *options)
        with open(self.path("report/results.json")) as file:
            return {m["name"]: m["total"] for m in json.load(file)["methods"]}["cgal"]

    def meshes_and_placements(self):
        with open(self.path("triangles"), "rb") as file:
            return struct.unpack("<2Q", file.read(32)[16:])

    def assert_agrees(self, total, count, least_ties):
        self.assertEqual(total["rays"], count)
        self.assertEqual({name: total[name] for name in MISTAKES}, dict.fromkeys(MISTAKES, 0))
        self.assertEqual(total["same"] + total["tie"], count)
        self.assertGreater(total["tie"], least_ties * count)

    def agrees_on_aimed_rays(self, placed_meshes, *options):
        write_scene(self.path("scene.gltf"), placed_meshes)
        self.compare("--aim", "vertices,edges,silhouettes,surface", "--aim-rays", str(RAYS // 4), "--record-rays",
                     self.path("rays"), "--max-judged", "1", *options)
        self.assert_agrees(self.verdicts(*options), RAYS // 4, 0.02)

    def test_agrees_on_slivers_and_coincident_faces(self):
        self.agrees_on_aimed_rays([(difficult_mesh(1), [IDENTITY]), (globe(12), [MIRRORED])])

    def test_agrees_on_instances(self):
        self.agrees_on_aimed_rays(COPIES)
        self.assertEqual(self.meshes_and_placements(), (2, 6))

    def test_agrees_on_flattened_instances(self):
        self.agrees_on_aimed_rays(COPIES, "--flatten")
        self.assertEqual(self.meshes_and_placements(), (6, 6))

    def record_exact_rays(self, count):
        mesh, matrices = COPIES[0]
        write_scene(self.path("scene.gltf"), [(mesh, matrices)])
        rays = exact_rays(mesh, matrices, count)
        # Version 1 of the format needs no hashes; the file of verdicts has those of version 2.
        with open(self.path("rays"), "wb") as file:
            file.write(b"SLRAYS1\n" + struct.pack("<Q", count) + b"".join(rays))
        self.compare("--rays", self.path("rays"), "--verdicts", self.path("verdicts"),
                     "--max-judged", "1")
        with open(self.path("verdicts"), "rb") as file:
            hashes = file.read(32)[16:]
        with open(self.path("rays"), "wb") as file:
            file.write(b"SLRAYS2\n" + struct.pack("<Q", count) + hashes + struct.pack("<4d", 0, 0, 0, 1) +
                       b"".join(ray + b"\xff" * 12 for ray in rays))

    def test_agrees_on_rays_that_meet_vertices_and_edges_exactly(self):
        self.record_exact_rays(RAYS // 4)
        self.assert_agrees(self.verdicts(), RAYS // 4, 0.1)

    def test_answers_with_the_farthest_hit_are_wrong(self):
        self.record_exact_rays(2000)
        self.assertGreater(self.verdicts(engine_options=["farthest"])["wrong"], 200)


if __name__ == "__main__":
    unittest.main()
