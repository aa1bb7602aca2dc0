"""Files by which `sightline compare` and other programs exchange rays, triangles and answers.

docs/engines.md describes the formats; all numbers are little-endian.
"""
import numpy

RAY = numpy.dtype([("origin", "<f4", 3), ("tnear", "<f4"), ("direction", "<f4", 3),
                   ("tfar", "<f4"), ("kind", "<u4"), ("source", "<u4", 3)])
ANSWER = numpy.dtype([("instance", "<u4"), ("geometry", "<u4"), ("primitive", "<u4"),
                      ("t", "<f4"), ("u", "<f4"), ("v", "<f4"), ("occluded", "<u4")])
KINDS = ["camera", "shadow", "reflection", "refraction"]
NONE = 0xFFFFFFFF
# By code; 255 stands for a ray that was not judged.
VERDICTS = ["same", "tie", "near_tie", "missed", "false_hit", "wrong_primitive", "wrong_t", "wrong_uv",
            "undecidable", "unjudged"]


def _take(data, offset, dtype, count):
    """The next `count` numbers and the offset behind them; ValueError if they are not there."""
    dtype = numpy.dtype(dtype)
    end = offset + count * dtype.itemsize
    if end > len(data):
        raise ValueError("truncated")
    return numpy.frombuffer(data, dtype, count, offset), end


def read_rays(path):
    """Of --record-rays: an array of RAY, and the two hashes that answers repeat."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"SLRAYS2\n":
        raise ValueError(f"{path}: not a ray file of version 2")
    (count, scene, rays), at = _take(data, 8, "<u8", 3)
    _, at = _take(data, at, "<f8", 4)  # the frame: origin and scale
    return _take(data, at, RAY, int(count))[0], (int(scene), int(rays))


def read_triangles(path):
    """Of --export-triangles: the triangles in world space, as doubles, and their ids.

    Returns (corners, ids): an array of shape (n, 3, 3), and one of (n, 3) with the instance, the
    geometry and the primitive of each triangle.
    """
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"SLTRIS1\n":
        raise ValueError(f"{path}: not a triangle file of version 1")
    (_, mesh_count, placement_count), at = _take(data, 8, "<u8", 3)
    meshes = []
    for _ in range(int(mesh_count)):
        (vertices, triangles), at = _take(data, at, "<u8", 2)
        positions, at = _take(data, at, "<f4", 3 * int(vertices))
        indices, at = _take(data, at, "<u4", 3 * int(triangles))
        meshes.append((positions.reshape(-1, 3).astype(float), indices.reshape(-1, 3)))
    corners, ids = [], []
    for _ in range(int(placement_count)):
        (instance, geometry), at = _take(data, at, "<u4", 2)
        matrix, at = _take(data, at, "<f4", 12)
        positions, indices = meshes[geometry]
        rows = matrix.reshape(4, 3).astype(float)
        corners.append((positions @ rows[:3] + rows[3])[indices])
        ids.append(numpy.column_stack([numpy.full(len(indices), instance),
                                       numpy.full(len(indices), geometry),
                                       numpy.arange(len(indices))]))
    if not corners:
        return numpy.zeros((0, 3, 3)), numpy.zeros((0, 3), int)
    return numpy.concatenate(corners), numpy.concatenate(ids)


def scene_hash_of(path):
    """The hash of the geometry in a file of --export-triangles."""
    with open(path, "rb") as file:
        return int(_take(file.read(16), 8, "<u8", 1)[0][0])


def write_answers(path, answers, scene_hash, rays_hash, ns_per_ray=None):
    """`answers`: an array of ANSWER, one for each ray; `ns_per_ray`: by kind, or None."""
    with open(path, "wb") as file:
        file.write(b"SLANSW1\n")
        numpy.array([len(answers), scene_hash, rays_hash], "<u8").tofile(file)
        answers.astype(ANSWER).tofile(file)
        if ns_per_ray is not None:
            numpy.array([ns_per_ray.get(kind, numpy.nan) for kind in KINDS], "<f8").tofile(file)


def read_verdicts(path):
    """Of --verdicts: {method: array of a code for each ray}, see VERDICTS."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"SLVERD1\n":
        raise ValueError(f"{path}: not a file of verdicts of version 1")
    (rays, _, _, methods), at = _take(data, 8, "<u8", 4)
    verdicts = {}
    for _ in range(int(methods)):
        (length,), at = _take(data, at, "<u8", 1)
        name, at = data[at:at + int(length)].decode(), at + int(length)
        verdicts[name], at = _take(data, at, "u1", int(rays))
    return verdicts
