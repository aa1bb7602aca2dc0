"""Seed assets in parts that can be mutated: the JSON, and the bytes of buffers and images."""
import base64
import binascii
import copy
import json
import math
import os
import struct
import sys
import urllib.parse

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CORPUS = os.path.join(os.path.dirname(ROOT), "shared", "corpus")
sys.path.insert(0, os.path.join(ROOT, "tools"))
from gltf_writer import Gltf, quad, turn  # noqa: E402

GLB_MAGIC, JSON_CHUNK, BIN_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
MOST_BYTES = 4 << 20  # of a seed asset
PLACEHOLDER = "soak-data:"  # stands for a data URI, whose bytes are a part


class Asset:
    """A glTF file. `parts` has the bytes of external files by path, of data URIs by placeholder, and
    of the binary chunk as "bin". Edits of the JSON text and of the whole file come last, in order."""

    def __init__(self, name):
        self.name, self.document, self.parts = name, None, {}
        self.text_edits, self.file_edits = [], []
        self.hostile = ()  # damaged images, which may take the place of the asset's

    def copy(self):
        twin = Asset(self.name)
        twin.document, twin.parts = copy.deepcopy(self.document), dict(self.parts)
        twin.hostile = self.hostile
        return twin

    def items(self, kind):
        """The objects of a top-level array; mutated documents may hold anything there."""
        found = self.document.get(kind) if isinstance(self.document, dict) else None
        return [i for i in found if isinstance(i, dict)] if isinstance(found, list) else []

    def part_of(self, item):
        """The name of the part that a buffer or an image refers to, or None."""
        name = item.get("uri", "bin")
        name = urllib.parse.unquote(name) if isinstance(name, str) else None
        return name if name in self.parts else None

    def size(self):
        return sum(map(len, self.parts.values()))

    def files(self):
        """The bytes of each file by its path."""
        text = json.dumps(self.document).encode()
        for name, data in self.parts.items():
            if name.startswith(PLACEHOLDER):
                uri = b"data:application/octet-stream;base64," + base64.b64encode(data)
                text = text.replace(f'"{name}"'.encode(), b'"' + uri + b'"')
        for edit in self.text_edits:
            text = edit(text)
        main = text
        if self.name.endswith(".glb"):
            binary = [(BIN_CHUNK, self.parts["bin"])] if "bin" in self.parts else []
            main = pack_glb([(JSON_CHUNK, text), *binary])
        for edit in self.file_edits:
            main = edit(main)
        external = {n: d for n, d in self.parts.items() if n != "bin" and not n.startswith(PLACEHOLDER)}
        return {**external, self.name: main}


def pack_glb(chunks):
    body = b""
    for kind, data in chunks:
        data += (b" " if kind == JSON_CHUNK else b"\0") * (-len(data) % 4)
        body += struct.pack("<II", len(data), kind) + data
    return struct.pack("<III", GLB_MAGIC, 2, 12 + len(body)) + body


def chunks_of(data):
    """Kinds and bytes of a GLB's chunks, as far as they are whole."""
    at, found = 12, []
    while at + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, at)
        found.append((kind, data[at + 8:at + 8 + size]))
        at += 8 + size
    return found


def take_parts(asset, folder):
    """Moves data URIs and external files into the asset's parts."""
    for item in asset.items("buffers") + asset.items("images"):
        uri = item.get("uri")
        if not isinstance(uri, str):
            continue
        if uri.startswith("data:"):
            try:
                data = base64.b64decode(uri.partition(",")[2])
            except (binascii.Error, ValueError):
                continue  # stays text
            item["uri"] = f"{PLACEHOLDER}{len(asset.parts)}"
            asset.parts[item["uri"]] = data
        else:
            name = os.path.normpath(urllib.parse.unquote(uri))
            path = os.path.join(folder, name)
            if not name.startswith((".", "/")) and "\0" not in name and os.path.isfile(path):
                with open(path, "rb") as file:
                    asset.parts[name] = file.read()


def load(path):
    """The asset of a file, or None if it cannot be taken apart or is large."""
    with open(path, "rb") as file:
        data = file.read(MOST_BYTES + 1)
    asset = Asset("a.glb" if data[:4] == b"glTF" else "a.gltf")
    text = data
    if asset.name == "a.glb":
        chunks = dict(chunks_of(data))
        text = chunks.get(JSON_CHUNK, b"")
        if BIN_CHUNK in chunks:
            asset.parts["bin"] = chunks[BIN_CHUNK]
    try:
        asset.document = json.loads(text)
    except (ValueError, RecursionError):
        return None
    take_parts(asset, os.path.dirname(path))
    return asset if len(data) + asset.size() <= MOST_BYTES else None


def everything():
    """An asset with what the scenes of scenes/ lack: a skin, morph targets, an animation, sparse and
    normalised accessors, instances, lights, and textures in a material with extensions."""
    scene = Gltf("everything")
    image = scene.texture([[(255, 0, 0, 255), (0, 255, 0, 128)], [(0, 0, 255, 0), (255, 255, 255, 255)]])
    texture = {"index": image}
    material = scene.add("materials", {
        "alphaMode": "BLEND", "normalTexture": texture, "occlusionTexture": texture, "emissiveTexture": texture,
        "emissiveFactor": [0.2, 0.2, 0.2],
        "pbrMetallicRoughness": {"baseColorTexture": texture, "metallicRoughnessTexture": texture},
        "extensions": {**scene.use("KHR_materials_clearcoat", {"clearcoatFactor": 0.5, "clearcoatTexture": texture}),
                       **scene.use("KHR_materials_transmission", {"transmissionFactor": 0.5}),
                       **scene.use("KHR_materials_volume", {"thicknessFactor": 0.1, "attenuationDistance": 1}),
                       **scene.use("KHR_materials_sheen", {"sheenColorFactor": [1, 0, 0]}),
                       **scene.use("KHR_materials_iridescence", {"iridescenceFactor": 1}),
                       **scene.use("KHR_materials_anisotropy", {"anisotropyStrength": 0.5}),
                       **scene.use("KHR_materials_dispersion", {"dispersion": 1})}})
    mesh = scene.mesh(material, *quad((-1, -1, 0), (2, 0, 0), (0, 2, 0), (2, 2)))
    primitive = scene.document["meshes"][mesh]["primitives"][0]
    primitive["attributes"]["JOINTS_0"] = scene.accessor([(0, 1, 0, 0)] * 4, "VEC4", 5123)
    primitive["attributes"]["WEIGHTS_0"] = scene.accessor([(0.5, 0.5, 0.0, 0.0)] * 4, "VEC4")
    target = scene.add("accessors", {
        "componentType": 5126, "count": 4, "type": "VEC3", "sparse": {
            "count": 1, "indices": {"bufferView": scene.view(struct.pack("<H", 2)), "componentType": 5123},
            "values": {"bufferView": scene.view(struct.pack("<3f", 0, 0, 0.5))}}})
    primitive["targets"] = [{"POSITION": target}]
    joints = [scene.add("nodes", {"translation": [0, i, 0]}) for i in range(2)]
    scene.document["nodes"][joints[0]]["children"] = [joints[1]]
    skin = scene.add("skins", {"joints": joints})
    scene.node(children=[joints[0]])
    scene.node(mesh=mesh, skin=skin, weights=[0.5])
    still = scene.mesh(material, *quad((0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1)))
    for i in range(3):
        scene.node(mesh=still, translation=[i, 0, 0], rotation=turn((0, 1, 0), 20.0 * i))
    times = scene.accessor([0.0, 1.0], "SCALAR")
    turns = scene.accessor([(0.0, 0.0, 0.0, 1.0), (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))], "VEC4")
    weights = scene.accessor([0.0, 1.0], "SCALAR")
    scene.add("animations", {
        "samplers": [{"input": times, "output": turns}, {"input": times, "output": weights}],
        "channels": [{"sampler": 0, "target": {"node": joints[1], "path": "rotation"}},
                     {"sampler": 1, "target": {"node": joints[1] + 2, "path": "weights"}}]})
    light = scene.extend("KHR_lights_punctual", "lights", {"type": "spot", "intensity": 20, "spot": {}})
    scene.node(translation=[0, 0, 3], extensions={"KHR_lights_punctual": {"light": light}})
    scene.node(camera=scene.add("cameras", {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}),
               translation=[0, 0, 5])
    scene.document["buffers"] = [{"byteLength": len(scene.buffer)}]
    asset = Asset("a.glb")
    asset.document, asset.parts = scene.document, {"bin": bytes(scene.buffer)}
    return asset


def seeds(with_corpus):
    """Pairs of a name and an asset: the project's scenes, `everything`, and the corpus."""
    folders = [os.path.join(ROOT, "scenes")]
    if with_corpus:
        folders += [os.path.join(CORPUS, name) for name in ("valid", "reported", "invalid")]
    paths = [os.path.join(path, name) for folder in folders for path, _, names in os.walk(folder)
             for name in names if name.lower().endswith((".gltf", ".glb"))]
    loaded = [(os.path.relpath(path, os.path.dirname(ROOT)), load(path)) for path in sorted(paths)]
    found = [("everything", everything())] + [(name, asset) for name, asset in loaded if asset]
    hostile = hostile_images() if with_corpus else ()
    for _, asset in found:
        asset.hostile = hostile
    return found


def hostile_images():
    """The bytes of the corpus' damaged images; empty where there is no corpus."""
    found = []
    for path, folders, names in os.walk(os.path.join(CORPUS, "hostile-image")):
        folders.sort()
        for name in sorted(names):
            with open(os.path.join(path, name), "rb") as file:
                found.append(file.read())
    return found
