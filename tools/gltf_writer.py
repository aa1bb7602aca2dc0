"""Writes small self-contained glTF 2.0 files, with the same bytes on every machine."""
import base64
import json
import math
import re
import struct
import zlib

FLOAT, UNSIGNED_SHORT = 5126, 5123
NEAREST, LINEAR, REPEAT, CLAMP_TO_EDGE = 9728, 9729, 10497, 33071


def rounded(value):
    """The value with its numbers rounded, because libraries differ in the last bit of a sine."""
    if isinstance(value, float):
        value = round(value, 6)
        return int(value) if value == int(value) else value
    if isinstance(value, (list, tuple)):
        return [rounded(v) for v in value]
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    return value


def png(rows):
    """A PNG of rows of pixels, each a tuple of 3 or 4 bytes; stored, not compressed, so that the
    bytes do not depend on zlib's version."""
    channels = len(rows[0][0])
    raw = b"".join(b"\0" + bytes(c for pixel in row for c in pixel) for row in rows)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(
            ">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2 if channels == 3 else 6, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
            chunk(b"IDAT", zlib.compress(raw, 0)) + chunk(b"IEND", b""))


def turn(axis, degrees):
    """The quaternion of a rotation about a unit axis."""
    half = math.radians(degrees) / 2
    return [a * math.sin(half) for a in axis] + [math.cos(half)]


def look_at(eye, at):
    """Translation and rotation of a camera at `eye` that looks at `at`, +y up."""
    x, y, z = (a - e for a, e in zip(at, eye))
    yaw = math.degrees(math.atan2(-x, -z))
    pitch = math.degrees(math.atan2(y, math.hypot(x, z)))
    ax, _, _, aw = turn((1, 0, 0), pitch)
    _, by, _, bw = turn((0, 1, 0), yaw)
    return {"translation": list(eye), "rotation": [bw * ax, by * aw, -by * ax, bw * aw]}


class Gltf:
    """A glTF document under construction; methods that add an item return its index."""

    def __init__(self, feature, options=""):
        self.buffer = bytearray()
        self.document = {
            "asset": {"version": "2.0", "generator": "Sightline make_scenes",
                      "extras": {"feature": feature, "options": options}},
            "extensionsUsed": [], "scene": 0, "scenes": [{"nodes": []}]}

    def add(self, kind, item):
        self.document.setdefault(kind, []).append(item)
        return len(self.document[kind]) - 1

    def use(self, extension, value):
        """An `extensions` member; adds the extension to `extensionsUsed`."""
        if extension not in self.document["extensionsUsed"]:
            self.document["extensionsUsed"].append(extension)
        return {extension: value}

    def extend(self, extension, kind, item):
        """Adds an item to the list `kind` of a document-level extension."""
        self.use(extension, None)
        items = self.document.setdefault("extensions", {}).setdefault(
            extension, {}).setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def node(self, **members):
        """A node at the root of the scene."""
        self.document["scenes"][0]["nodes"].append(self.add("nodes", members))

    def view(self, data):
        self.buffer.extend(b"\0" * (-len(self.buffer) % 4))
        start = len(self.buffer)
        self.buffer.extend(data)
        return self.add("bufferViews",
                        {"buffer": 0, "byteOffset": start, "byteLength": len(data)})

    def accessor(self, rows, kind, component=FLOAT):
        """Tuples (VEC2 …) or plain indices (SCALAR) as an accessor."""
        flat = [c for row in rows for c in (row if isinstance(row, (tuple, list)) else (row,))]
        if component == FLOAT:
            flat = [round(c, 6) + 0.0 for c in flat]  # no negative zero
        data = struct.pack(f"<{len(flat)}{'f' if component == FLOAT else 'H'}", *flat)
        accessor = {"bufferView": self.view(data), "componentType": component,
                    "count": len(rows), "type": kind}
        if kind == "VEC3":
            stored = list(struct.iter_unpack("<3f", data))
            accessor["min"] = [min(row[i] for row in stored) for i in range(3)]
            accessor["max"] = [max(row[i] for row in stored) for i in range(3)]
        return self.add("accessors", accessor)

    def mesh(self, material, positions, indices, normals=None, uvs=None):
        attributes = {"POSITION": self.accessor(positions, "VEC3")}
        if normals:
            attributes["NORMAL"] = self.accessor(normals, "VEC3")
        if uvs:
            attributes["TEXCOORD_0"] = self.accessor(uvs, "VEC2")
        primitive = {"attributes": attributes, "material": material,
                     "indices": self.accessor(indices, "SCALAR", UNSIGNED_SHORT)}
        return self.add("meshes", {"primitives": [primitive]})

    def texture(self, rows, filtering=LINEAR, wrap=REPEAT):
        image = self.add("images", {"mimeType": "image/png", "bufferView": self.view(png(rows))})
        sampler = self.add("samplers", {"magFilter": filtering, "minFilter": filtering,
                                        "wrapS": wrap, "wrapT": wrap})
        return self.add("textures", {"source": image, "sampler": sampler})

    def material(self, color=(1, 1, 1), alpha=1, metallic=0, roughness=1, texture=None, **members):
        surface = {"baseColorFactor": [*color, alpha], "metallicFactor": metallic,
                   "roughnessFactor": roughness}
        if texture is not None:
            surface["baseColorTexture"] = {"index": texture}
        return self.add("materials", {"pbrMetallicRoughness": surface, **members})

    def glass(self, ior=1.5, color=(1, 1, 1), distance=None):
        """A clear solid; white light takes on `color` after `distance`."""
        volume = {"thicknessFactor": 1}
        if distance:
            volume.update(attenuationDistance=distance, attenuationColor=list(color))
        return self.material(roughness=0, extensions={
            **self.use("KHR_materials_transmission", {"transmissionFactor": 1}),
            **self.use("KHR_materials_ior", {"ior": ior}),
            **self.use("KHR_materials_volume", volume)})

    def shape(self, kind, material, parameters, **members):
        """A node that carries an analytic surface (docs/shapes.md)."""
        index = self.extend("KHR_implicit_shapes", "shapes", {"type": kind, kind: parameters})
        self.node(extensions=self.use("SIGHTLINE_implicit_shapes", {"shape": index, "material": material}),
                  **members)

    def camera(self, eye, at, yfov_degrees):
        index = self.add("cameras", {"type": "perspective", "perspective": {
            "yfov": math.radians(yfov_degrees), "znear": 0.01}})
        self.node(name="camera", camera=index, **look_at(eye, at))

    def point_light(self, position, candela, color=(1, 1, 1)):
        index = self.extend("KHR_lights_punctual", "lights",
                            {"type": "point", "intensity": candela, "color": list(color)})
        self.node(name="light", translation=list(position),
                  extensions=self.use("KHR_lights_punctual", {"light": index}))

    def rotate(self, name, nodes, times, turns):
        """An animation that turns the nodes in the same way."""
        sampler = {"input": self.accessor(times, "SCALAR"), "output": self.accessor(turns, "VEC4")}
        self.document["accessors"][sampler["input"]].update(min=[times[0]], max=[times[-1]])
        self.add("animations", {"name": name, "samplers": [sampler], "channels": [
            {"sampler": 0, "target": {"node": node, "path": "rotation"}} for node in nodes]})

    def background(self, color):
        self.document["scenes"][0]["extensions"] = self.use(
            "SIGHTLINE_background", {"color": list(color)})

    def finished(self, **source):
        """The document with its buffer, which `source` locates."""
        document = {k: v for k, v in self.document.items() if v != []}
        if self.buffer:
            document["buffers"] = [{"byteLength": len(self.buffer), **source}]
        return rounded(document)

    def text(self):
        data = base64.b64encode(bytes(self.buffer)).decode("ascii")
        document = self.finished(uri="data:application/octet-stream;base64," + data)
        return re.sub(r"\[[^][{}\"]+\]", lambda m: " ".join(m.group().split())
                      .replace("[ ", "[").replace(" ]", "]"), json.dumps(document, indent=1) + "\n")

    def glb(self):
        text = json.dumps(self.finished(), separators=(",", ":")).encode()
        chunks = b""
        for kind, data, fill in ((b"JSON", text, b" "), (b"BIN\0", bytes(self.buffer), b"\0")):
            data += fill * (-len(data) % 4)
            chunks += struct.pack("<I4s", len(data), kind) + data
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def quad(corner, across, along, tiles=(1, 1)):
    """Positions, indices, normals and uvs of a parallelogram that faces across × along."""
    opposite = [c + a + b for c, a, b in zip(corner, across, along)]
    positions = [tuple(corner), tuple(c + a for c, a in zip(corner, across)), tuple(opposite),
                 tuple(c + b for c, b in zip(corner, along))]
    (ax, ay, az), (bx, by, bz) = across, along
    normal = (ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)
    length = math.sqrt(sum(n * n for n in normal))
    normals = [tuple(n / length for n in normal)] * 4
    u, v = tiles
    return positions, [0, 1, 2, 0, 2, 3], normals, [(0, v), (u, v), (u, 0), (0, 0)]


def lathe(profile, steps=64):
    """Positions, indices and normals of a surface of revolution about y: `profile` is a list of (radius,
    height), ordered so that the outside lies to the right; a repeated point makes a crease."""
    positions, normals, indices = [], [], []
    for i, (radius, height) in enumerate(profile):
        ahead = profile[i + 1] if i + 1 < len(profile) and profile[i + 1] != profile[i] else None
        behind = profile[i - 1] if i > 0 and profile[i - 1] != profile[i] else None
        (r0, h0), (r1, h1) = behind or profile[i], ahead or profile[i]
        slope, rise = r1 - r0, h1 - h0
        length = math.hypot(slope, rise)
        for k in range(steps + 1):
            angle = 2 * math.pi * k / steps
            c, s = math.cos(angle), -math.sin(angle)
            positions.append((radius * c, height, radius * s))
            normals.append((rise / length * c, -slope / length, rise / length * s))
    row = steps + 1
    for i in range(len(profile) - 1):
        if profile[i] == profile[i + 1]:
            continue
        for k in range(steps):
            a, b = i * row + k, i * row + k + 1
            if profile[i][0] > 0:
                indices += [a, b, a + row]
            if profile[i + 1][0] > 0:
                indices += [b, b + row, a + row]
    return positions, indices, normals
