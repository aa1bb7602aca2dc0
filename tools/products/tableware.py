"""Things for the table."""
import math

from gltf_writer import Gltf, turn
from products.materials import BRASS, COPPER, GOLD, brushed, coated, extended, metal, part
from products.shapes import (flowing, inside_out, joined, lattice, moulding, outline, rectangle,
                             revolved, spline, tube)


def spout(path, radii, wall, steps=24):
    """A tube with an open end: its wall goes back inside."""
    stations = list(spline(path, 8))
    widths = [r for (r,), _ in spline([(r,) for r in radii], 8)]
    tip = len(stations) // 3
    outside = tube(stations, widths, steps=steps, ends=False)
    inner = stations[-tip:]
    inside = tube(inner, [w - wall for w in widths[-tip:]], steps=steps, ends=False)
    (end, way), w = stations[-1], widths[-1]
    rim = [(tuple(e + wall / 2 * math.sin(a) * d for e, d in zip(end, way)), way)
           for a in (math.pi * k / 8 for k in range(9))]
    lip = tube(rim, [w - wall / 2 + wall / 2 * math.cos(math.pi * k / 8) for k in range(9)], steps=steps,
               ends=False)
    return joined(outside, lip, inside_out(inside))


def tea_set():
    """A porcelain pot and a cup with tea."""
    scene = Gltf("porcelain: a clear coat on white")
    china = coated(scene, (0.86, 0.855, 0.84), 0.6, 0.02)
    gilt = metal(scene, GOLD, 0.18)
    body = flowing([(0, 0.004), (0.045, 0.004), (0.05, 0), (0.056, 0.003), (0.062, 0.012), (0.082, 0.04),
                    (0.09, 0.075), (0.08, 0.112), (0.055, 0.136), (0.046, 0.141)])
    part(scene, china, revolved(body), name="pot")
    lid = outline([(0, 0.139), (0.0445, 0.139, 0.0015), (0.0455, 0.1435, 0.0015), (0.04, 0.147, 0.006),
                   (0.012, 0.158, 0.01), (0.008, 0.163, 0.004), (0.008, 0.168, 0.003), (0.0145, 0.174, 0.006),
                   (0.0135, 0.183, 0.007), (0, 0.1855)])
    part(scene, china, revolved(lid), name="lid")
    rim = outline([(0.0450, 0.1395), (0.0485, 0.1395, 0.001), (0.0485, 0.1425, 0.001), (0.045, 0.1425)])
    part(scene, gilt, revolved(rim), name="gilt rim")
    path = [(0.066, 0.042, 0), (0.09, 0.05, 0), (0.114, 0.075, 0), (0.126, 0.108, 0), (0.142, 0.132, 0)]
    part(scene, china, spout(path, [0.024, 0.021, 0.0145, 0.0105, 0.0088], 0.0022), name="spout")
    bow = list(spline([(-0.062, 0.124, 0), (-0.088, 0.136, 0), (-0.122, 0.126, 0), (-0.134, 0.096, 0),
                       (-0.118, 0.062, 0), (-0.078, 0.04, 0)], 10))
    part(scene, china, tube(bow, 0.0068, 0.8), name="handle")
    cup(scene, china, gilt, [0.16, 0, 0.1])
    return scene


def cup(scene, china, gilt, place):
    saucer = outline([(0, 0.003), (0.036, 0.003), (0.037, 0, 0.001), (0.041, 0, 0.001), (0.044, 0.004, 0.003),
                      (0.072, 0.0165, 0.002), (0.0735, 0.0185, 0.0008), (0.071, 0.0195, 0.0005),
                      (0.045, 0.0085, 0.02), (0.026, 0.0072, 0.002), (0.024, 0.006, 0.002), (0, 0.006)])
    part(scene, china, revolved(saucer), name="saucer", translation=place)
    wall = outline([(0, 0.009), (0.019, 0.009), (0.02, 0.0065, 0.0008), (0.0235, 0.0065, 0.001),
                    (0.025, 0.012, 0.003), (0.037, 0.028, 0.02), (0.0425, 0.06, 0.0009),
                    (0.0405, 0.06, 0.0009), (0.035, 0.029, 0.02), (0.023, 0.0135, 0.008), (0, 0.0125)])
    part(scene, china, revolved(wall), name="cup", translation=place)
    part(scene, gilt, revolved(outline([(0.0424, 0.0592), (0.0428, 0.061, 0.0006), (0.0403, 0.061, 0.0006),
                                        (0.0405, 0.0598)])), name="gilt rim of the cup", translation=place)
    tea = extended(scene, {"color": (0.23, 0.075, 0.02), "roughness": 0}, ior={"ior": 1.33})
    part(scene, tea, revolved(outline([(0.0398, 0.0505), (0, 0.0505)])), name="tea", translation=place)
    ear = list(spline([(0.038, 0.049, 0), (0.052, 0.053, 0), (0.062, 0.043, 0), (0.053, 0.029, 0),
                       (0.034, 0.0245, 0)], 10))
    part(scene, china, tube(ear, 0.0032, 0.8), name="ear", translation=place, rotation=turn((0, 1, 0), -25))


def carafe():
    """Thick glass, and an amber drink whose volume overlaps the wall."""
    scene = Gltf("glass: transmission, volume and attenuation")
    glass = scene.glass(1.5, (0.93, 0.98, 0.96), 0.12)
    outside = flowing([(0, 0.002), (0.045, 0), (0.058, 0.006), (0.064, 0.03), (0.061, 0.075), (0.038, 0.135),
                       (0.024, 0.18), (0.0245, 0.215), (0.034, 0.247)], 10)
    lip = outline([(0.034, 0.247), (0.0355, 0.2505, 0.0012), (0.0335, 0.2515, 0.0012), (0.032, 0.2485)])[1:-1]
    inside = flowing([(0.032, 0.2485), (0.0218, 0.215), (0.0213, 0.18), (0.035, 0.135), (0.0577, 0.075),
                      (0.0603, 0.033), (0.055, 0.016), (0.04, 0.011), (0, 0.011)], 10)
    part(scene, glass, revolved(outside + lip + inside), name="carafe")
    drink = scene.glass(1.34, (0.86, 0.36, 0.05), 0.03)
    level = 0.108
    wet = [(r + 0.0006, y, nr, ny) for r, y, nr, ny in reversed(inside) if y < level and r > 0]
    fill = [(0, 0.0104, 0, -1)] + [(r, y - 0.0004, -nr, -ny) for r, y, nr, ny in wet]
    r, y = fill[-1][:2]
    part(scene, drink, revolved(fill + [(r, y, 0, 1), (0, y, 0, 1)]), name="drink")
    stopper = outline([(0, 0.222), (0.019, 0.222, 0.004), (0.0225, 0.252, 0.002), (0.012, 0.256, 0.003),
                       (0.012, 0.264, 0.004), (0.026, 0.276, 0.012), (0.026, 0.296, 0.014), (0, 0.3)])
    part(scene, glass, revolved(stopper), name="stopper")
    return scene


def vase():
    """Twisted flutes under a lustre glaze."""
    scene = Gltf("a glaze: iridescence and a clear coat")
    glaze = extended(scene, {"color": (0.012, 0.03, 0.16), "metallic": 0.25, "roughness": 0.3}, clearcoat={
        "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.02}, iridescence={
            "iridescenceFactor": 0.8, "iridescenceIor": 1.8, "iridescenceThicknessMaximum": 420})
    outside = [p[:2] for p in flowing([(0.0, 0.004), (0.042, 0.002), (0.05, 0.003), (0.053, 0.012),
                                       (0.078, 0.07), (0.088, 0.13), (0.07, 0.2), (0.036, 0.255), (0.034, 0.28), (0.05, 0.31)], 12)]
    lip = [(0.0515, 0.3125), (0.051, 0.3145), (0.049, 0.315), (0.047, 0.3135)]
    inside = [p[:2] for p in flowing([(0.0455, 0.311), (0.0305, 0.281), (0.03, 0.254), (0.058, 0.2), (0.072, 0.13),
                                      (0.0, 0.02)], 8)]
    rows, steps, flutes = [], 288, 14
    for i, (r, y) in enumerate(outside + lip + inside):
        depth = 0.05 * math.sin(math.pi * min(1, max(0, (y - 0.012) / 0.29))) ** 0.5 * (i < len(outside))
        row = []
        for k in range(steps):
            a = 2 * math.pi * k / steps
            swell = r * (1 - depth * (1 - abs(math.sin(flutes * (a - 5 * y) / 2))) ** 1.5)
            row.append((swell * math.cos(a), y, -swell * math.sin(a)))
        rows.append(row + row[:1])
    part(scene, glaze, lattice(rows, True), name="vase")
    return scene


def saucepan():
    """Copper outside, steel inside, a cast handle with rivets."""
    scene = Gltf("polished copper, brushed steel, brass")
    copper, steel, brass = metal(scene, COPPER, 0.16), brushed(scene, roughness=0.3), metal(scene, BRASS, 0.22)
    wall = outline([(0, 0), (0.088, 0, 0.008), (0.09, 0.085), (0.0935, 0.0895, 0.001), (0.0915, 0.0905)])
    part(scene, copper, revolved(wall), name="outside")
    lining = outline([(0.0918, 0.0904), (0.088, 0.085, 0.004), (0.086, 0.003, 0.008), (0, 0.003)])
    part(scene, steel, revolved(lining), name="lining")
    grip = list(spline([(0.085, 0.064, 0), (0.105, 0.066, 0), (0.15, 0.086, 0), (0.21, 0.101, 0),
                        (0.262, 0.101, 0)], 10))
    widths = [r for (r,), _ in spline([(0.014,), (0.0105,), (0.0085,), (0.0105,), (0.0115,)], 10)]
    part(scene, brass, tube(grip, widths, 0.5), name="handle")
    edge = outline([(-0.005, 0), (0, 0, 0.001), (0, 0.004, 0.0015), (-0.005, 0.004)])
    plate = moulding(rectangle(0.05, 0.034, 0.012), edge, True)
    part(scene, brass, plate, name="plate", translation=[0.0875, 0.064, 0], rotation=turn((0, 0, 1), -90))
    rivet = revolved(flowing([(0.0046, 0), (0.004, 0.0018), (0.002, 0.003), (0, 0.0032)]))
    for z in (-0.018, 0.018):
        part(scene, copper, rivet, name="rivet", translation=[0.0912, 0.064, z], rotation=turn((0, 0, 1), -90))
    return scene
