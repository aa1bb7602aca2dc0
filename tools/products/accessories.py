"""Things to wear and to play with."""
import math

from gltf_writer import Gltf, turn
from products.materials import GOLD, STEEL, brushed, coated, extended, metal, part
from products.patterns import grain, normal_map
from products.shapes import (circle, cut_stone, flowing, inside_out, joined, lattice, moulding, outline,
                             rectangle, revolved, scaled_uvs, spline, straight, tube)


def brilliant():
    """The planes of a round brilliant cut whose girdle has the radius 1 and lies at the height 0."""
    planes = [((0, 1, 0), 0.302)]

    def add(count, first, degrees, through, up):
        """Facets in a circle, at an angle to the table, through a point (radius, height)."""
        tilt = math.radians(degrees)
        for k in range(count):
            a = 2 * math.pi * (k + first) / count
            normal = (math.sin(tilt) * math.cos(a), up * math.cos(tilt), math.sin(tilt) * math.sin(a))
            planes.append((normal, math.sin(tilt) * through[0] + up * math.cos(tilt) * through[1]))

    add(8, 0, 34.5, (1, 0), 1)
    add(8, 0.5, 21, (0.53, 0.302), 1)
    add(16, 0.5, 40.5, (0.985, 0), 1)
    add(8, 0, 40.75, (1, -0.03), -1)
    add(16, 0.5, 42, (0.985, -0.03), -1)
    add(32, 0.5, 90, (0.985, 0), 1)
    return planes


def ring():
    """A gold band that carries a stone in six claws."""
    scene = Gltf("a cut stone: dispersion; polished gold")
    gold = metal(scene, GOLD, 0.06)
    diamond = extended(scene, {"roughness": 0}, transmission={"transmissionFactor": 1}, ior={"ior": 2.42},
                       volume={"thicknessFactor": 0.004}, dispersion={"dispersion": 0.36})
    r, w = 0.0088, 0.00125
    band = outline([(r, -w, 0.0005), (r + 0.0016, -w, 0.0009), (r + 0.0016, w, 0.0009), (r, w, 0.0005)], True, 8)
    centre = r + 0.0016
    part(scene, gold, moulding(circle(192), band + band[:1]), name="band", translation=[0, centre, 0],
         rotation=turn((1, 0, 0), 90))
    size, girdle = 0.0036, 2 * centre + 0.0031
    stone = cut_stone([(normal, size * d) for normal, d in brilliant()])
    part(scene, diamond, stone, name="stone", translation=[0, girdle, 0], rotation=turn((0, 1, 0), 11))
    claws = []
    for k in range(6):
        a = math.pi * (k + 0.5) / 3
        path = [(x * math.cos(a), y, x * math.sin(a)) for x, y in
                ((0.0006, -0.0036), (0.0019, -0.0022), (0.00345, -0.0002), (0.0036, 0.0005), (0.0031, 0.0009))]
        claws.append(tube(list(spline(path, 8)), 0.00036, steps=16))
    part(scene, gold, joined(*claws), name="claws", translation=[0, girdle, 0])
    basket = outline([(0.00205, -0.002), (0.0024, -0.0021, 0.0002), (0.00275, -0.0015, 0.0002), (0.0024, -0.0015)])
    part(scene, gold, revolved(basket), name="basket", translation=[0, girdle, 0])
    return scene


# The body of the car, from tail to nose: place along it, half the width, height of the bottom and of the top.
CAR = [(-0.108, 0, 0.028, 0.028), (-0.104, 0.014, 0.019, 0.040), (-0.085, 0.026, 0.0135, 0.052),
       (-0.05, 0.0345, 0.011, 0.061), (0.0, 0.0365, 0.010, 0.060), (0.05, 0.034, 0.011, 0.052),
       (0.085, 0.027, 0.0135, 0.043), (0.104, 0.015, 0.019, 0.035), (0.108, 0, 0.0265, 0.0265)]


def car_section(station, angle, offset=0.0):
    """A point of the body's surface, moved outwards: angle 0 at the right, a quarter turn on top."""
    x, width, low, high = station
    c, s = math.cos(angle), math.sin(angle)
    shape = [math.copysign(abs(v) ** 0.8, v) for v in (c, s)]
    y = (low + high) / 2 + ((high - low) / 2 + offset) * shape[1]
    return x, y, -(width + offset) * shape[0]


def toy_car():
    """A racing car for children, painted in red under a clear coat."""
    scene = Gltf("car paint: a clear coat over colour; rubber, chrome")
    paint = coated(scene, (0.7, 0.014, 0.012), 0.5, 0.02)
    white = coated(scene, (0.85, 0.85, 0.83), 0.5, 0.02)
    rubber = scene.material((0.014, 0.014, 0.015), roughness=0.62)
    chrome = metal(scene, STEEL, 0.05)
    glass = coated(scene, (0.006, 0.007, 0.009), 0.2, 0)
    stations = [point for point, _ in spline(CAR, 10)]
    turns = [2 * math.pi * k / 64 for k in range(65)]
    body = [[car_section(station, a) for a in turns] for station in stations]
    part(scene, paint, lattice([row[:-1] + row[:1] for row in body], True), name="body")
    stripe = [[car_section(s, math.pi / 2 + b * 0.16 , 0.0003) for b in (-1, -0.5, 0, 0.5, 1)]
              for s in stations[2:-2]]
    part(scene, white, lattice(stripe), name="stripe")
    part(scene, glass, revolved(flowing([(0.0, -0.012), (0.02, -0.012), (0.0255, -0.002), (0.022, 0.012),
                                         (0.012, 0.0195), (0, 0.0215)])), name="canopy",
         translation=[-0.018, 0.0555, 0], scale=[1.5, 0.8, 0.62])
    tyre = outline([(0.010, -0.0085), (0.0165, -0.0085, 0.003), (0.0215, -0.006, 0.004), (0.0215, 0.006, 0.004),
                    (0.0165, 0.0085, 0.003), (0.010, 0.0085)])
    hub = outline([(0.0135, 0.0062), (0.0128, 0.0092, 0.0012), (0.0105, 0.0092, 0.0008), (0.0085, 0.0072, 0.001),
                   (0.005, 0.0075, 0.001), (0.0042, 0.0105, 0.002), (0, 0.011)])
    for x in (-0.062, 0.062):
        part(scene, chrome, tube(straight((x, 0.0215, -0.05), (x, 0.0215, 0.05)), 0.0026), name="axle")
        for side in (1, -1):
            place = [x, 0.0215, side * 0.0455]
            axis = turn((1, 0, 0), 90 * side)
            part(scene, rubber, revolved(tyre), name="tyre", translation=place, rotation=axis)
            part(scene, chrome, revolved(hub), name="hub", translation=place, rotation=axis)
    for side in (1, -1):
        part(scene, chrome, revolved(outline([(0, -0.004), (0.0058, -0.004), (0.0062, 0.003, 0.0015), (0, 0.0036)])),
             name="lamp", translation=[0.0925, 0.034, side * 0.0165], rotation=turn((0, 0, 1), -78))
    return scene


def perfume():
    """A heavy bottle, its content and a gold cap."""
    scene = Gltf("thick glass around a tinted liquid")
    glass = scene.glass(1.5)
    outer = outline([(-0.0115, 0), (0, 0, 0.004), (0, 0.082, 0.006), (-0.0115, 0.082)], steps=8)
    inner = outline([(-0.0118, 0.014), (-0.0075, 0.014, 0.004), (-0.0075, 0.0755, 0.004), (-0.0118, 0.0755)])
    plan = rectangle(0.066, 0.032, 0.012, 12)
    shell = joined(moulding(plan, outer, True), inside_out(moulding(plan, inner, True)))
    part(scene, glass, shell, name="bottle")
    liquid = scene.glass(1.36, (0.93, 0.5, 0.46), 0.022)
    wet = outline([(-0.0118, 0.0137), (-0.0072, 0.0137, 0.004), (-0.0072, 0.064), (-0.0118, 0.064)])
    part(scene, liquid, moulding(plan, wet, True), name="perfume")
    gold = metal(scene, GOLD, 0.12)
    neck = outline([(0, 0.082), (0.0105, 0.082), (0.0105, 0.0835, 0.0005), (0.0088, 0.0838), (0.0088, 0.088),
                    (0, 0.088)])
    part(scene, gold, revolved(neck), name="collar")
    cap = outline([(-0.004, 0.0872), (0, 0.0872, 0.001), (0, 0.115, 0.0018), (-0.004, 0.115)], steps=8)
    part(scene, gold, moulding(rectangle(0.026, 0.024, 0.0045), cap, True), name="cap")
    tube_of_spray = tube(straight((0, 0.082, 0), (0.004, 0.017, 0)), 0.0009, steps=12)
    part(scene, scene.material((0.8, 0.8, 0.8), roughness=0.3), tube_of_spray, name="dip tube")
    return scene


def headphones():
    """A band, two yokes, two cups with cushions."""
    scene = Gltf("soft black, leather, brushed metal")
    shell = scene.material((0.022, 0.022, 0.024), roughness=0.48)
    map_of_grain = scene.texture(normal_map(grain, 64, 1.1))
    hide = extended(scene, {"color": (0.34, 0.17, 0.08), "roughness": 0.5, "normalTexture": {
        "index": map_of_grain, "scale": 0.4}})
    steel = brushed(scene)
    arc = [(0.082 * math.cos(a), 0.115 + 0.094 * math.sin(a), 0) for a in
           (math.pi * (0.03 + 0.94 * k / 24) for k in range(25))]
    part(scene, steel, tube(list(spline(arc, 3)), 0.0085, 0.2), name="spring")
    pad = [(0.079 * math.cos(a), 0.1145 + 0.091 * math.sin(a), 0) for a in
           (math.pi * (0.24 + 0.52 * k / 16) for k in range(17))]
    padding = tube(list(spline(pad, 3)), 0.014, 0.42)
    part(scene, hide, (*padding[:3], [(u * 2, v * 8) for u, v in padding[3]]), name="padding")
    cup_shell = outline([(0.02, -0.002), (0.036, -0.002, 0.002), (0.037, 0.008, 0.003), (0.031, 0.0185, 0.007),
                         (0.0215, 0.0205, 0.0008), (0.0205, 0.0195)])
    disc = outline([(0.0208, 0.0188), (0.0203, 0.0202, 0.0006), (0, 0.0208)])
    soft = flowing([(0.016, -0.003), (0.0155, -0.012), (0.021, -0.0205), (0.031, -0.02), (0.0385, -0.0115),
                    (0.0365, -0.0005), (0.03, -0.0005)])
    drape = outline([(0, -0.006), (0.019, -0.006)])
    for side in (1, -1):
        place, axis = [0.078 * side, 0.07, 0], turn((0, 0, 1), -90 * side)
        members = {"translation": place, "rotation": axis, "scale": [1.14, 1, 1]}
        part(scene, shell, revolved(cup_shell), name="cup", **members)
        part(scene, steel, revolved(disc), name="disc", **members)
        part(scene, hide, scaled_uvs(revolved(soft), 0.04), name="cushion", **members)
        part(scene, shell, revolved(drape), name="cloth", **members)
        yoke = [(side * 0.086, 0.118, 0), (side * 0.0935, 0.108, 0), (side * 0.095, 0.09, 0), (side * 0.09, 0.076, 0)]
        part(scene, shell, tube(list(spline(yoke, 8)), 0.0062, 0.55), name="yoke")
    return scene
