"""Structural damage to assets. A mutation changes an asset in place and returns what it did, or None
if the asset has nothing of that kind; it takes all its choices from the generator it is given."""
import struct
import zlib

from assets import BIN_CHUNK, JSON_CHUNK, chunks_of, pack_glb

NUMBERS = (0, -1, 1, 2, 3, 255, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**53, 2**63, 2**64 - 1, 2**64,
           -2**31, -2**63, 0.5, -0.0, 1e-45, 1e-38, 1e18, 3.5e38, -3.5e38, 1e308, -1e308, 1e-320)
OTHERS = (None, True, False, "", "a", "\0", "../x", "\u202e", "<b>", "x" * 10000, [], {}, [[]], [None], {"a": 1})
FLOATS = (float("nan"), float("inf"), -float("inf"), 1e-45, -1e-38, 3.4e38, -3.4e38, 1e18, -0.0, 0.0, 1.0)
INTEGERS = (0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFE, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
COMPONENTS = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
REFERENCES = {"accessors": ("bufferView",), "bufferViews": ("buffer",), "textures": ("source", "sampler"),
              "nodes": ("mesh", "skin", "camera"), "images": ("bufferView",),
              "skins": ("inverseBindMatrices", "skeleton")}
URIS = ("../outside/secret.png", "/etc/passwd", "file:///etc/passwd", "http://127.0.0.1:9/a.png",
        "%2e%2e/outside/secret.bin", "..%2foutside%2fsecret.bin", "\\\\host\\a", "a.gltf", "a.glb", ".", "", "%00",
        "/dev/zero", "/dev/stdin", "/proc/self/environ", "data:", "data:;base64,", "data:image/png;base64,!!!!",
        "data:application/octet-stream,%",
        "x" * 5000, "\ud800", "a\nb.png")
EXTENSIONS = {
    "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 1},
    "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5},
    "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [1, 1, 1]},
    "KHR_materials_specular": {"specularFactor": 1, "specularColorFactor": [1, 1, 1]},
    "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 1},
    "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 400},
    "KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyRotation": 1},
    "KHR_materials_dispersion": {"dispersion": 1}, "KHR_materials_emissive_strength": {"emissiveStrength": 1},
    "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 1},
    "KHR_materials_unlit": {}, "KHR_texture_transform": {"offset": [0, 0], "scale": [1, 1], "rotation": 1},
    "KHR_lights_punctual": {"light": 0}, "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}},
    "KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}},
    "EXT_meshopt_compression": {"buffer": 0, "byteLength": 4, "byteStride": 4, "count": 1, "mode": "ATTRIBUTES"},
    "UNKNOWN_extension": {"a": 1}}


def odd_value(rng):
    return rng.choice(NUMBERS if rng.random() < 0.7 else OTHERS)


def place(rng, asset, most=12):
    """A container of the JSON and one of its keys, reached by a random walk from the root; or None."""
    container, found = asset.document, None
    for _ in range(most):
        if isinstance(container, dict) and container:
            key = rng.choice(list(container))
        elif isinstance(container, list) and container:
            key = rng.randrange(len(container))
        else:
            break
        found = container, key
        container = container[key]
        if rng.random() < 0.15:
            break
    return found


def value(rng, asset):
    at = place(rng, asset)
    if at:
        at[0][at[1]] = odd_value(rng)
        return f"{at[1]!r} = {str(at[0][at[1]])[:40]!r}"
    return None


def numbers(rng, asset):
    """Overwrites one number by another."""
    for _ in range(20):
        at = place(rng, asset)
        if at and type(at[0][at[1]]) in (int, float):
            at[0][at[1]] = rng.choice((*NUMBERS, at[0][at[1]] + 1, -at[0][at[1]], at[0][at[1]] * 1000))
            return f"number {at[1]!r} = {at[0][at[1]]}"
    return None


def deletion(rng, asset):
    at = place(rng, asset)
    if at:
        del at[0][at[1]]
        return f"no {at[1]!r}"
    return None


def duplication(rng, asset):
    at = place(rng, asset)
    if at and isinstance(at[0], list):
        plain = not isinstance(at[0][at[1]], (dict, list))  # others would multiply with each mutation
        at[0].extend([at[0][at[1]]] * rng.choice((1, 1, 2, 300 if plain else 8)))
        return f"element {at[1]} repeated: {len(at[0])} elements"
    if at:
        at[0][rng.choice(list(at[0])) + rng.choice(("", "x"))] = at[0][at[1]]
        return f"value of {at[1]!r} copied"
    return None


def swap(rng, asset):
    at = place(rng, asset)
    if not at or len(at[0]) < 2:
        return None
    other = rng.randrange(len(at[0])) if isinstance(at[0], list) else rng.choice(list(at[0]))
    at[0][at[1]], at[0][other] = at[0][other], at[0][at[1]]
    return f"{at[1]!r} and {other!r} swapped"


def reference(rng, asset):
    """An index of another object, of none, or just out of range."""
    kind = rng.choice(list(REFERENCES))
    items = asset.items(kind)
    if not items:
        return None
    key = rng.choice(REFERENCES[kind])
    new = rng.choice((rng.randrange(2 * len(items) + 2), len(items), -1, 2**32 - 1, 1e9, 0.5))
    rng.choice(items)[key] = new
    return f"{kind}: {key} = {new}"


def accessor(rng, asset):
    items = asset.items("accessors")
    if not items:
        return None
    key, new = rng.choice((
        ("count", rng.choice((0, 1, 3, 4, 2**16, 2**26, 2**31, 2**32, 2**62, 2**64 - 1))),
        ("byteOffset", rng.choice((1, 2, 4, 2**16, 2**32 - 1, 2**63, 2**64 - 4))),
        ("componentType", rng.choice((*COMPONENTS, 5124, 5130, 0))), ("type", rng.choice((*WIDTHS, "VEC5"))),
        ("normalized", rng.random() < 0.5), ("bufferView", rng.randrange(len(items) + 1)),
        ("min", [rng.choice(NUMBERS)] * 3), ("max", [rng.choice(NUMBERS)] * 3)))
    rng.choice(items)[key] = new
    return f"accessor: {key} = {new}"


def buffer_view(rng, asset):
    kind = rng.choice(("bufferViews", "bufferViews", "buffers"))
    items = asset.items(kind)
    if not items:
        return None
    key = rng.choice(("byteLength", "byteOffset", "byteStride"))
    new = rng.choice((0, 1, 3, 4, 5, 252, 253, 2**20, 2**31, 2**32 - 1, 2**63, 2**64 - 1, 2**64))
    rng.choice(items)[key] = new
    return f"{kind}: {key} = {new}"


def sparse(rng, asset):
    items, views = asset.items("accessors"), asset.items("bufferViews")
    if not items or not views:
        return None
    item = rng.choice(items)
    item["sparse"] = {"count": rng.choice((0, 1, 2, 2**20, 2**32, item.get("count", 1))),
                      "indices": {"bufferView": rng.randrange(len(views)),
                                  "componentType": rng.choice((5121, 5123, 5125, 5126)),
                                  "byteOffset": rng.choice((0, 1, 4, 2**31))},
                      "values": {"bufferView": rng.randrange(len(views)), "byteOffset": rng.choice((0, 2, 4, 2**63))}}
    if rng.random() < 0.3:
        item.pop("bufferView", None)
        item["count"] = rng.choice((1, 2**10, 2**20, 2**26))
    return f"sparse accessor of {item['sparse']['count']}"


def graph(rng, asset):
    """A child that makes a cycle, a second parent or an extreme transform."""
    nodes = asset.items("nodes")
    if not nodes:
        return None
    node, kind = rng.choice(nodes), rng.randrange(4)
    if kind == 0:
        node["children"] = [rng.randrange(len(nodes) + 1) for _ in range(rng.choice((1, 2, 100)))]
    elif kind == 1:
        node["scale"] = [rng.choice((0, -1, 1e-30, 1e30, 1e-10, 1e6)) for _ in range(3)]
    elif kind == 2:
        node["translation"] = [rng.choice((0, 1e6, -1e17, 1e19, 1e38)) for _ in range(3)]
    else:
        node["matrix"] = [rng.choice((0, 1, -1, 1e-20, 1e20, 0.5)) for _ in range(rng.choice((16, 16, 16, 15)))]
    return f"node: {('children', 'scale', 'translation', 'matrix')[kind]}"


def extension(rng, asset):
    """An extension with odd values on an object, sometimes required."""
    owners = [i for kind in ("materials", "nodes", "textures", "bufferViews", "meshes") for i in asset.items(kind)]
    if not owners:
        return None
    name = rng.choice(list(EXTENSIONS))
    members = {k: odd_value(rng) if rng.random() < 0.5 else v for k, v in EXTENSIONS[name].items()}
    owner = rng.choice(owners)
    if not isinstance(owner.get("extensions"), dict):
        owner["extensions"] = {}
    owner["extensions"][name] = members if rng.random() < 0.9 else odd_value(rng)
    asset.document["extensionsUsed"] = [name]
    if rng.random() < 0.3:
        asset.document["extensionsRequired"] = [name]
    return f"extension {name} {str(members)[:60]}"


def uri(rng, asset):
    items = asset.items("buffers") + asset.items("images")
    if not items:
        return None
    item = rng.choice(items)
    item["uri"] = rng.choice(URIS)
    return f"uri {item['uri'][:40]!r}"


def overwrite(data, at, new):
    return data[:at] + new + data[at + len(new):]


def view_spot(asset, item):
    """Part, first byte and size of the buffer view that an accessor or an image refers to, or None."""
    index, views, buffers = item.get("bufferView"), asset.items("bufferViews"), asset.items("buffers")
    if not isinstance(index, int) or not 0 <= index < len(views):
        return None
    start, size, buffer = (views[index].get(key, 0) for key in ("byteOffset", "byteLength", "buffer"))
    if not all(isinstance(n, int) and n >= 0 for n in (start, size, buffer)) or buffer >= len(buffers):
        return None
    part = asset.part_of(buffers[buffer])
    size = min(size, len(asset.parts[part]) - start) if part else 0
    return (part, start, size) if size > 0 else None


def accessor_values(rng, asset):
    """Numbers of an accessor: NaN, infinities, denormals, indices beyond their range."""
    items = asset.items("accessors")
    item = rng.choice(items) if items else {}
    kind, spot = item.get("componentType"), view_spot(asset, item)
    if not spot or not isinstance(kind, int) or kind not in COMPONENTS:
        return None
    (part, start, room), kind = spot, COMPONENTS[kind]
    size, count = struct.calcsize(kind), rng.choice((1, 1, 3, 1000))
    for _ in range(count):
        at = start + rng.randrange(max(1, room // size)) * size
        new = rng.choice(FLOATS) if kind == "f" else rng.choice(INTEGERS)
        packed = struct.pack("<f", new) if kind == "f" else struct.pack("<I", new & 0xFFFFFFFF)[:size]
        if at + size <= len(asset.parts[part]):
            asset.parts[part] = overwrite(asset.parts[part], at, packed)
    return f"{count} values of accessor {items.index(item)}"


def tamper(rng, data):
    """The bytes cut short, lengthened, with flipped bits, a random block, zeros or a part moved."""
    if not data:
        return data
    at, kind = rng.randrange(len(data)), rng.randrange(6)
    size = min(rng.choice((1, 4, 16, 256)), len(data) - at)
    if kind == 0:
        return data[:at]
    if kind == 1:
        return data + rng.randbytes(size)
    if kind == 2:
        for _ in range(rng.choice((1, 8, 64))):
            at = rng.randrange(len(data))
            data = overwrite(data, at, bytes([data[at] ^ 1 << rng.randrange(8)]))
        return data
    if kind == 3:
        return overwrite(data, at, rng.randbytes(size))
    if kind == 4:
        return overwrite(data, at, bytes(size) if rng.random() < 0.5 else b"\xff" * size)
    return data[:at] + data[at + size:]


def part_bytes(rng, asset):
    if not asset.parts:
        return None
    name = rng.choice(list(asset.parts))
    before = len(asset.parts[name])
    asset.parts[name] = tamper(rng, asset.parts[name])
    return f"bytes of {name[:40]}: {before} -> {len(asset.parts[name])}"


def part_missing(rng, asset):
    if not asset.parts:
        return None
    name = rng.choice(list(asset.parts))
    if rng.random() < 0.5:
        del asset.parts[name]
        return f"{name[:40]} is missing"
    other = rng.choice(list(asset.parts))
    asset.parts[name] = asset.parts[other]
    return f"{name[:40]} has the bytes of {other[:40]}"


def png_chunk(rng, data):
    """One chunk of a PNG changed, removed, repeated or moved; its checksum often made right."""
    chunks, at = [], 8
    while at + 12 <= len(data):
        size = struct.unpack_from(">I", data, at)[0]
        chunks.append([data[at + 4:at + 8], data[at + 8:at + 8 + size], None])
        at += 12 + size
    if not chunks:
        return data
    index, kind = rng.randrange(len(chunks)), rng.randrange(6)
    if kind == 0:
        del chunks[index]
    elif kind == 1:
        chunks.insert(index, list(rng.choice(chunks)))
    elif kind == 2:
        rng.shuffle(chunks)
    elif kind == 3:
        chunks[index][2] = rng.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1))
    elif kind == 4:
        chunks[0][1] = struct.pack(">IIBBBBB", rng.choice((0, 1, 2, 4096, 65535, 2**31 - 1)),
                                   rng.choice((0, 1, 2, 4096, 2**32 - 1)), rng.choice((1, 2, 4, 8, 16, 3)),
                                   rng.choice((0, 2, 3, 4, 6, 1)), 0, 0, rng.randrange(3))
    else:
        chunks[index][1] = tamper(rng, chunks[index][1])
    whole = rng.random() < 0.8
    return data[:8] + b"".join(
        struct.pack(">I", len(body) if size is None else size) + name + body +
        struct.pack(">I", zlib.crc32(name + body) if whole else 1) for name, body, size in chunks)


def image(rng, asset):
    """The bytes of an image: chunks of PNG, segments of others, or another file in its place."""
    spots = []
    for item in asset.items("images"):
        part = asset.part_of(item) if "uri" in item else None
        spots.append((part, 0, None) if part else view_spot(asset, item))
    spots = [spot for spot in spots if spot]
    if not spots:
        return None
    part, start, size = rng.choice(spots)
    whole = asset.parts[part]
    data = whole if size is None else whole[start:start + size]
    kind = "bytes"
    if asset.hostile and size is None and rng.random() < 0.2:
        kind, new = "hostile file", rng.choice(asset.hostile)
    elif data[:4] == b"\x89PNG" and rng.random() < 0.7:
        kind, new = "chunk", png_chunk(rng, data)
    else:  # the header more often than the rest
        edge = min(len(data), 700) if rng.random() < 0.5 else len(data)
        new = tamper(rng, data[:edge]) + data[edge:]
    asset.parts[part] = new if size is None else overwrite(whole, start, new[:size].ljust(size, b"\0"))
    return f"image {kind} of {part[:40]}"


def text(rng, asset):
    """The JSON as text: cut short, nested deeply, with twice the same key, with numbers out of range."""
    kind, at = rng.randrange(9), rng.random()
    junk = (b"\xef\xbb\xbf", b"\0", b"\xff\xfe", b"1e999", b"[" * 100000, b'{"a":' * 100000, b"//\n", b",",
            b'"\\ud800"')[kind]

    def edit(data):
        spot = int(at * len(data))
        if kind == 0:
            return junk + data
        if kind == 1 and at < 0.5:
            return data[:spot]
        if kind == 3:
            digits = data.rfind(b":", 0, spot)
            return data[:digits + 1] + junk + b"," + data[digits + 1:].partition(b",")[2]
        if kind == 6 and at < 0.7:
            return b'{"asset": {"version": "2.0"},' + data.lstrip()[1:]
        return data[:spot] + junk + data[spot:]

    asset.text_edits.append(edit)
    return f"JSON text: {junk[:8]!r} at {at:.2f}"


def glb(rng, asset):
    """The chunks of a GLB: order, kinds, sizes, padding; its header."""
    if not asset.name.endswith(".glb"):
        return None
    kind, odd = rng.randrange(7), rng.choice((0, 1, 3, 2**31, 2**32 - 1, 2**32 - 8))

    def edit(data):
        chunks = chunks_of(data)
        if kind == 0:
            return pack_glb(chunks[::-1])
        if kind == 1:
            return pack_glb(chunks[:1] + [(0x12345678, b"extra")] + chunks[1:] * 2)
        if kind == 2:
            return pack_glb([(BIN_CHUNK if k == JSON_CHUNK else k, d) for k, d in chunks])
        if kind == 3:
            return overwrite(data, 8, struct.pack("<I", odd))
        if kind == 4:
            return overwrite(data, 12, struct.pack("<I", odd))
        if kind == 5:
            return overwrite(data, 4, struct.pack("<I", odd))
        return data[:odd % max(1, len(data))]

    asset.file_edits.append(edit)
    return f"GLB: {('reversed', 'extra chunk', 'kinds', 'length', 'chunk size', 'version', 'cut')[kind]}"


# With weights: most damage to the JSON is refused at once, damage to bytes goes deeper.
ALL = {value: 2, numbers: 3, deletion: 2, duplication: 1, swap: 1, reference: 1, accessor: 2, buffer_view: 2, sparse: 2,
       graph: 2, extension: 3, uri: 1, accessor_values: 6, part_bytes: 2, part_missing: 1, image: 6, text: 1, glb: 1}


def mutate(rng, asset):
    """Applies one mutation; returns what it did."""
    for _ in range(20):
        done = rng.choices(list(ALL), ALL.values())[0](rng, asset)
        if done:
            return done
    return "nothing"
