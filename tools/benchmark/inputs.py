"""Scenes made for the benchmark: an asset under one sun or many lamps, a large mesh, large textures."""
import array
import json
import math
import os
import struct
import subprocess
import tempfile


def glb(document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    return (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary)) +
            struct.pack("<II", len(text), 0x4E4F534A) + text +
            struct.pack("<II", len(binary), 0x004E4942) + binary)


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)
    return path


def read_glb(path):
    """The JSON and the binary chunk."""
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length]), data[28 + length:]


def add_lights(document, light, nodes):
    """Adds a light of KHR_lights_punctual and nodes that hold it."""
    document.setdefault("extensionsUsed", []).append("KHR_lights_punctual")
    document.setdefault("extensions", {})["KHR_lights_punctual"] = {"lights": [light]}
    roots = document["scenes"][document.get("scene", 0)]["nodes"]
    for node in nodes:
        roots.append(len(document["nodes"]))
        document["nodes"].append({**node, "extensions": {"KHR_lights_punctual": {"light": 0}}})


def under_one_sun(asset, path):
    """A copy of a .glb asset with one directional light, from (0.6, 1, 0.8)."""
    document, binary = read_glb(asset)
    # The shortest rotation of -z onto the direction in which the light travels.
    norm = math.sqrt(0.6 ** 2 + 1 + 0.8 ** 2)
    x, y, z = -0.6 / norm, -1 / norm, -0.8 / norm
    turn = [y, -x, 0, 1 - z]
    size = math.sqrt(sum(q * q for q in turn))
    add_lights(document, {"type": "directional", "intensity": 3},
               [{"rotation": [q / size for q in turn]}])
    return write(path, glb(document, binary))


def under_lamps(asset, path, count):
    """A copy of a .glb asset with point lights on a circle of radius 3 above it."""
    document, binary = read_glb(asset)
    angles = [2 * math.pi * i / count for i in range(count)]
    add_lights(document, {"type": "point", "intensity": 100 / count},
               [{"translation": [3 * math.cos(a), 2, 3 * math.sin(a)]} for a in angles])
    return write(path, glb(document, binary))


def large_textures(enlarge_image, asset, path, side=4096):
    """A copy of a .glb asset whose images are JPEGs of side × side pixels."""
    document, binary = read_glb(asset)
    views = document["bufferViews"]
    parts = []
    for view in views:
        start = view.get("byteOffset", 0)
        parts.append(binary[start:start + view["byteLength"]])
    with tempfile.TemporaryDirectory() as folder:
        small, large = os.path.join(folder, "small"), os.path.join(folder, "large.jpg")
        for image in document.get("images", []):
            write(small, parts[image["bufferView"]])
            subprocess.run([enlarge_image, small, large, str(side)], check=True)
            with open(large, "rb") as file:
                parts[image["bufferView"]] = file.read()
            image["mimeType"] = "image/jpeg"
    binary = b""
    for view, part in zip(views, parts):
        view["byteOffset"], view["byteLength"] = len(binary), len(part)
        binary += part + b"\0" * (-len(part) % 4)
    document["buffers"][0]["byteLength"] = len(binary)
    return write(path, glb(document, binary))


def waves(path, cells):
    """A wavy sheet of 2·cells² triangles."""
    if os.path.exists(path):
        return path
    points, side = array.array("f"), cells + 1
    for row in range(side):
        for column in range(side):
            x, z = column / cells - 0.5, row / cells - 0.5
            points.extend((x, 0.05 * math.sin(30 * x) * math.cos(25 * z), z))
    order = array.array("I")
    for row in range(cells):
        for column in range(cells):
            a = row * side + column
            order.extend((a, a + side, a + 1, a + 1, a + side, a + side + 1))
    vertex_bytes, index_bytes = len(points) * 4, len(order) * 4
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": vertex_bytes + index_bytes}],
        "bufferViews": [{"buffer": 0, "byteLength": vertex_bytes},
                        {"buffer": 0, "byteOffset": vertex_bytes, "byteLength": index_bytes}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": side * side, "type": "VEC3",
             "min": [-0.5, -0.05, -0.5], "max": [0.5, 0.05, 0.5]},
            {"bufferView": 1, "componentType": 5125, "count": len(order), "type": "SCALAR"}]}
    return write(path, glb(document, points.tobytes() + order.tobytes()))
