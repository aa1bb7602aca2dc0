"""Things for a room."""
import math

from gltf_writer import Gltf, turn
from products.materials import BRASS, brushed, coated, extended, metal, part
from products.patterns import grain, normal_map, oak, weave
from products.shapes import (flowing, lattice, moulding, outline, placed, rectangle, revolved,
                             scaled_uvs, spline, straight, tube, turn_after, unit)


def desk_lamp():
    """A lamp that bows: arm, shade and bulb turn about the joint."""
    scene = Gltf("brushed metal: anisotropy; an emissive bulb; an animation")
    steel = brushed(scene, (0.62, 0.61, 0.59), 0.36)
    dark = coated(scene, (0.012, 0.012, 0.013), 0.4, 0.12)
    base = outline([(0, 0), (0.085, 0, 0.002), (0.088, 0.004, 0.002), (0.088, 0.016, 0.004), (0.03, 0.0215, 0.004),
                    (0.012, 0.026, 0.006), (0.0095, 0.045, 0.003), (0, 0.045)])
    part(scene, steel, revolved(base), name="base")
    joint, reach = (-0.1, 0.3, 0), (0.2, 0.12, 0)
    part(scene, steel, tube(straight((0, 0.04, 0), joint), 0.0055), name="lower arm")
    hub = outline([(0, -0.012), (0.0155, -0.012, 0.002), (0.0155, 0.012, 0.002), (0, 0.012)])
    part(scene, dark, revolved(hub), name="joint", translation=joint, rotation=turn((1, 0, 0), 90))
    enamel = coated(scene, (0.012, 0.1, 0.07), 0.5, 0.03)
    white = scene.material((0.85, 0.85, 0.83), roughness=0.5)
    bulb = extended(scene, {"color": (0, 0, 0), "emissiveFactor": [1, 0.82, 0.55]},
                    emissive_strength={"emissiveStrength": 5})
    outside = outline([(0, 0.036), (0.014, 0.036, 0.003), (0.0185, 0.028, 0.004), (0.021, -0.004, 0.02),
                       (0.078, -0.083, 0.0006), (0.0768, -0.083)][::-1])
    inside = outline([(0, 0.002), (0.0195, -0.004, 0.004), (0.0768, -0.083)])
    glow = flowing([(0, -0.094), (0.018, -0.088), (0.0275, -0.066), (0.021, -0.04), (0.0125, -0.02),
                    (0.0125, 0.0)])
    moving = []
    for name, material, surface in (
            ("upper arm", steel, tube(straight((0, 0, 0), reach), 0.0055)),
            ("shade", enamel, placed(revolved(outside), reach, 32)),
            ("lining", white, placed(revolved(inside), reach, 32)),
            ("bulb", bulb, placed(revolved(glow), reach, 32))):
        moving.append(len(scene.document["nodes"]))
        part(scene, material, surface, name=name, translation=joint)
    times = [k / 12 for k in range(25)]
    swing = [turn((0, 0, 1), -14 + 14 * math.cos(math.pi * t)) for t in times]
    scene.rotate("bow", moving, times, swing)
    return scene


def chair():
    """Round legs, a hollow seat, a bent back."""
    scene = Gltf("procedural wood under a thin lacquer")
    wood = coated(scene, (1, 1, 1), 0.55, 0.25, texture=scene.texture(oak()))
    seat = moulding(rectangle(0.4, 0.38, 0.1), outline(
        [(-0.03, 0.432), (-0.004, 0.436, 0.012), (0.012, 0.45, 0.008), (0.008, 0.462, 0.008), (-0.03, 0.462)]), True)
    part(scene, wood, scaled_uvs(seat, 0.35), name="seat")
    leg = scaled_uvs(revolved(outline([(0, 0), (0.0115, 0, 0.003), (0.0185, 0.3, 0.5), (0.015, 0.452), (0, 0.452)])),
                     0.3, True)
    for x in (-1, 1):
        for z in (-1, 1):
            # Feet stand further out than the corners of the seat.
            part(scene, wood, leg, name="leg", translation=[0.195 * x, 0, 0.185 * z],
                 rotation=turn_after(turn((0, 0, 1), 7 * x), turn((1, 0, 0), -7 * z)))
        path = list(spline([(0.145 * x, 0.44, -0.15), (0.158 * x, 0.6, -0.185), (0.172 * x, 0.8, -0.24)], 12))
        post = tube(path, [0.0145 - 0.003 * k / 24 for k in range(25)])
        part(scene, wood, scaled_uvs(post, 0.6, True), name="post")
    rail = bent_board(0.4, 0.115, 0.015, 0.055)
    part(scene, wood, scaled_uvs(rail, 0.4), name="rail", translation=[0, 0.705, -0.222],
         rotation=turn((1, 0, 0), -13))
    part(scene, wood, scaled_uvs(bent_board(0.318, 0.045, 0.012, 0.03), 0.4), name="lower rail",
         translation=[0, 0.57, -0.184], rotation=turn((1, 0, 0), -12))
    return scene


def bent_board(width, height, thickness, hollow):
    """A board that is bent backwards between its ends, with round edges."""
    steps, t, e = 24, thickness / 2, thickness / 2.2
    across = [width * (k / steps - 0.5) for k in range(steps + 1)]
    front = [(x, hollow * (1 - (2 * x / width) ** 2) - t, 0) for x in across]
    back = [(x, z + 2 * t, 0) for x, z, _ in reversed(front)]
    corners = [(*front[0][:2], e), *front[1:-1], (*front[-1][:2], e), (*back[0][:2], e), *back[1:-1],
               (*back[-1][:2], e)]
    plan = outline(corners, True, 4)
    edge = outline([(-0.8 * e, -height / 2), (0, -height / 2, 0.8 * e), (0, height / 2, 0.8 * e), (-0.8 * e, height / 2)])
    return moulding(smoothed(plan), edge, True)


def smoothed(plan):
    """The plan with one normal, the mean, where it has two at a shallow corner."""
    result = []
    for x, z, nx, nz in plan:
        if result and math.dist(result[-1][:2], (x, z)) < 1e-9:
            result[-1] = (x, z, *unit([result[-1][2] + nx, result[-1][3] + nz]))
        else:
            result.append((x, z, nx, nz))
    return result


def pouf():
    """A seat of black leather: twelve panels with seams and a button."""
    scene = Gltf("black leather: a normal map of grain")
    map_of_grain = scene.texture(normal_map(grain, 128, 1.1))
    leather = extended(scene, {"color": (0.016, 0.0145, 0.0135), "roughness": 0.42, "normalTexture": {
        "index": map_of_grain, "scale": 0.6}}, ior={"ior": 1.5})
    profile = [(r, y) for r, y, _, _ in flowing(
        [(0, 0.012), (0.2, 0.004), (0.24, 0.014), (0.275, 0.06), (0.29, 0.15), (0.278, 0.24), (0.24, 0.292),
         (0.17, 0.318), (0.08, 0.322), (0.02, 0.31), (0.0, 0.306)], 10)]
    rows, panels, steps = [], 12, 288
    for r, y in profile:
        row = []
        for k in range(steps):
            a = 2 * math.pi * k / steps
            bulge = 1 - 0.045 * (1 - abs(math.sin(panels * a / 2))) ** 3 * min(1, r / 0.1)
            row.append((r * bulge * math.cos(a), y - 0.1 * (1 - bulge) * (y > 0.25), -r * bulge * math.sin(a)))
        rows.append(row + row[:1])
    positions, indices, normals, uvs = lattice(rows, True)
    uvs = [(u * 24, v * 14) for u, v in uvs]
    part(scene, leather, (positions, indices, normals, uvs), name="panels")
    button = revolved(outline([(0.021, 0.3), (0.021, 0.312, 0.004), (0, 0.318)]))
    part(scene, leather, scaled_uvs(button, 0.08), name="button")
    foot = metal(scene, BRASS, 0.25)
    ring = revolved(outline([(0, 0), (0.17, 0, 0.002), (0.17, 0.016), (0, 0.016)]))
    part(scene, foot, ring, name="foot")
    return scene


def cushion():
    """Velvet with piping around its edge."""
    scene = Gltf("cloth: sheen, and a normal map of its weave")
    weft = scene.texture(normal_map(weave, 128, 0.5))
    bump = {"index": weft, "scale": 0.5}
    teal = {"color": (0.012, 0.105, 0.12), "roughness": 0.9}
    velvet = extended(scene, {**teal, "normalTexture": bump}, sheen={
        "sheenColorFactor": [0.22, 0.6, 0.62], "sheenRoughnessFactor": 0.32})
    cord = extended(scene, {"color": (0.55, 0.36, 0.12), "roughness": 0.75}, sheen={
        "sheenColorFactor": [0.6, 0.45, 0.25], "sheenRoughnessFactor": 0.4})
    n, half = 72, 0.225

    def edge(s):
        """Between -1 and 1, closer near the ends."""
        return math.sin(math.pi * s / 2)

    def point(u, v, side):
        x, y = edge(u), edge(v)
        hollow = 0.1 * (1 - x * x) * y * y, 0.1 * (1 - y * y) * x * x
        fill = max(0, (1 - x * x) * (1 - y * y)) ** 0.5
        radius, angle = math.hypot(x, y), math.atan2(y, x)
        fold = 0.012 * math.sin(16 * angle) * math.exp(-((radius - 0.85) / 0.25) ** 2) * fill
        tuft = 0.05 * math.exp(-(radius / 0.14) ** 2)
        return half * x * (1 - hollow[1]), half * y * (1 - hollow[0]), side * (0.105 * fill + fold - tuft)

    span = [2 * k / n - 1 for k in range(n + 1)]
    for side in (1, -1):
        rows = [[point(side * u, v, side) for u in span] for v in span]
        positions, indices, normals, uvs = lattice(rows)
        part(scene, velvet, (positions, indices, normals, [(12 * u, 12 * v) for u, v in uvs]), name="cover",
             translation=[0, half, 0], rotation=turn((1, 0, 0), -14))
    button = revolved(flowing([(0.018, -0.004), (0.0185, 0.002), (0.013, 0.0065), (0, 0.008)]))
    part(scene, cord, button, name="button", translation=[0, half + 0.054 * math.sin(math.radians(14)),
                                                          0.054 * math.cos(math.radians(14))],
         rotation=turn((1, 0, 0), 76))
    border = ([point(u, -1, 1) for u in span[::4]] + [point(1, v, 1) for v in span[4::4]] +
              [point(-u, 1, 1) for u in span[4::4]] + [point(-1, -v, 1) for v in span[4::4]])
    part(scene, cord, tube(list(spline(border, 4)), 0.0042, steps=16), name="piping", translation=[0, half, 0],
         rotation=turn((1, 0, 0), -14))
    return scene
