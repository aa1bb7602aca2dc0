"""Smooth surfaces, and patterns for textures.

A surface is positions, indices, normals and uvs, as Gltf.mesh takes them. Curves in the plane are lists of
(x, y, normal x, normal y); the normal is to the right of the direction of travel.
"""
import math


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a)) or 1
    return tuple(x / length for x in a)


def along(a, b, t):
    """The point a + t b."""
    return tuple(x + t * y for x, y in zip(a, b))


def between(a, b):
    return tuple(y - x for x, y in zip(a, b))


def outline(corners, closed=False, steps=6):
    """A polygon through corners (x, y) or (x, y, radius of its rounding)."""
    curve, count = [], len(corners)
    for i, (x, y, *radius) in enumerate(corners):
        arrival = unit(between(corners[i - 1][:2], (x, y))) if closed or i > 0 else None
        departure = (unit(between((x, y), corners[(i + 1) % count][:2]))
                     if closed or i + 1 < count else None)
        first, last = arrival or departure, departure or arrival
        bend = math.atan2(first[0] * last[1] - first[1] * last[0], dot(first, last))
        reach = radius[0] if radius else 0
        start = along((x, y), first, -reach * math.tan(abs(bend) / 2))
        side = math.copysign(reach, bend)
        centre = along(start, (first[1], -first[0]), -side)
        for k in range(steps + 1 if reach else 2 if bend else 1):
            angle = bend * k / (steps if reach else 1)
            c, s = math.cos(angle), math.sin(angle)
            normal = (first[0] * s + first[1] * c, first[1] * s - first[0] * c)
            curve.append((*along(centre, normal, side), *normal))
    return curve


def spline(points, steps=8):
    """Points of a Catmull-Rom curve through the points, of any dimension, and its directions."""
    ends = [along(points[0], between(points[1], points[0]), 1), *points,
            along(points[-1], between(points[-2], points[-1]), 1)]
    for i in range(len(points) - 1):
        a, b, c, d = ends[i:i + 4]
        for k in range(steps + (i == len(points) - 2)):
            t = k / steps
            weights = ((-t + 2 * t**2 - t**3) / 2, (2 - 5 * t**2 + 3 * t**3) / 2,
                       (t + 4 * t**2 - 3 * t**3) / 2, (t**3 - t**2) / 2)
            slopes = ((-1 + 4 * t - 3 * t**2) / 2, (-10 * t + 9 * t**2) / 2,
                      (1 + 8 * t - 9 * t**2) / 2, (3 * t**2 - 2 * t) / 2)
            yield (tuple(dot(weights, column) for column in zip(a, b, c, d)),
                   unit([dot(slopes, column) for column in zip(a, b, c, d)]))


def flowing(points, steps=8):
    """A smooth curve in the plane through the points."""
    return [(*point, way[1], -way[0]) for point, way in spline(points, steps)]


def circle(steps=96):
    """The plan of a surface of revolution: a point, seen from all sides."""
    turns = [2 * math.pi * k / steps for k in range(steps)]
    return [(0, 0, math.cos(a), math.sin(a)) for a in turns]


def rectangle(width, depth, radius, steps=8):
    w, d = width / 2, depth / 2
    return outline([(-w, -d, radius), (w, -d, radius), (w, d, radius), (-w, d, radius)], True, steps)


def facets(positions, row, rows):
    """The triangles of a lattice of points, `row` to a row, without those that have no area."""
    found = []
    for i in range(rows - 1):
        for k in range(row - 1):
            a, b = i * row + k, i * row + k + 1
            for triangle in ((a, b, b + row), (a, b + row, a + row)):
                if len({positions[corner] for corner in triangle}) == 3:
                    found += triangle
    return found


def lengths(points):
    """The length of a polygon up to each of its points."""
    total = [0.0]
    for a, b in zip(points, points[1:]):
        total.append(total[-1] + math.dist(a, b))
    return total


def moulding(plan, profile, capped=False):
    """What a profile leaves that is led around a closed plan, counter-clockwise seen from above: x of the
    profile is the distance from the plan, outwards, and y the height. Caps close its ends. uvs are lengths."""
    ring = [*plan, plan[0]]
    positions = [(x + r * nx, y, -(z + r * nz)) for r, y, _, _ in profile for x, z, nx, nz in ring]
    normals = [(across * nx, up, -across * nz) for _, _, across, up in profile for _, _, nx, nz in ring]
    indices = facets(positions, len(ring), len(profile))
    widest = max(r for r, _, _, _ in profile)
    us = lengths([(x + widest * nx, z + widest * nz) for x, z, nx, nz in ring])
    uvs = [(u, v) for v in lengths([p[:2] for p in profile]) for u in us]
    for (r, y, _, _), up in ((profile[0], -1), (profile[-1], 1)) if capped else ():
        rim = [(x + r * nx, y, -(z + r * nz)) for x, z, nx, nz in plan]
        start, last = len(positions), len(rim) - 1
        for i in range(len(rim) // 2 - 1):
            corners = (i, i + 1, last - i - 1, i, last - i - 1, last - i)
            indices += [start + c for c in (corners if up > 0 else reversed(corners))]
        positions += rim
        normals += [(0, up, 0)] * len(rim)
        uvs += [(x, z) for x, _, z in rim]
    return positions, indices, normals, uvs


def lattice(rows, closed=False):
    """A smooth surface through rows of points, from the bottom up, each counter-clockwise seen from above;
    closed rows begin and end with the same point."""
    count, last = len(rows[0]), len(rows) - 1

    def normal(i, k):
        if rows[i][0] == rows[i][-2]:  # a pole: as the ring beside it, seen along the axis
            i = 1 if i == 0 else last - 1
            around = [rows[i][j * (count - 1) // 3] for j in range(3)]
            return unit(cross(between(around[0], around[1]), between(around[0], around[2])))
        before, after = (k - 1, k + 1) if 0 < k < count - 1 else (max(k - 1, 0), min(k + 1, count - 1))
        if closed and k in (0, count - 1):
            before, after = count - 2, 1
        return unit(cross(between(rows[i][before], rows[i][after]),
                          between(rows[max(i - 1, 0)][k], rows[min(i + 1, last)][k])))

    positions = [tuple(point) for row in rows for point in row]
    normals = [normal(i, k) for i in range(len(rows)) for k in range(count)]
    uvs = [(k / (count - 1), i / last) for i in range(len(rows)) for k in range(count)]
    return positions, facets(positions, count, len(rows)), normals, uvs


def tube(path, radius, flat=1, steps=24, ends=True):
    """A tube of the radius (or radii) along a path of points and directions; `flat` is its thickness
    across its first normal. Its ends are round."""
    radii = radius if isinstance(radius, list) else [radius] * len(path)
    stations = [(point, way, r) for (point, way), r in zip(path, radii)]
    if ends:
        (first, way, r), (final, onward, s) = stations[0], stations[-1]
        arcs = [math.pi / 2 * k / 6 for k in range(6)]
        stations = ([(along(first, way, -r * math.cos(a)), way, r * math.sin(a)) for a in arcs] + stations +
                    [(along(final, onward, s * math.cos(a)), onward, s * math.sin(a)) for a in reversed(arcs)])
    helper = min(((1, 0, 0), (0, 1, 0), (0, 0, 1)), key=lambda e: abs(dot(e, stations[0][1])))
    side = unit(cross(helper, stations[0][1]))
    rows = []
    for point, way, r in stations:
        side = unit(along(side, way, -dot(side, way)))
        other = cross(way, side)
        rows.append([along(along(point, side, r * flat * math.cos(2 * math.pi * k / steps)), other,
                           r * math.sin(2 * math.pi * k / steps)) for k in range(steps)])
        rows[-1].append(rows[-1][0])
    return lattice(rows, True)


def inside_out(surface):
    positions, indices, normals, uvs = surface
    return positions, indices[::-1], [tuple(-n for n in normal) for normal in normals], uvs


def joined(*surfaces):
    positions, indices, normals, uvs = [], [], [], []
    for more, order, directions, places in surfaces:
        indices += [len(positions) + i for i in order]
        positions, normals, uvs = positions + more, normals + directions, uvs + places
    return positions, indices, normals, uvs


def cut_stone(planes):
    """The convex solid on the inner side of planes (outward unit normal, distance), with flat facets."""
    positions, indices, normals = [], [], []
    for normal, distance in planes:
        side = unit(cross(normal, (0.36, 0.48, 0.8)))
        other = cross(normal, side)
        size = 100 * max(abs(d) for _, d in planes)
        polygon = [along(along([distance * n for n in normal], side, size * a), other, size * b)
                   for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        for cutter, limit in planes:
            if cutter != normal:
                polygon = clipped(polygon, cutter, limit)
        start = len(positions)
        indices += [start + k for i in range(1, len(polygon) - 1) for k in (0, i, i + 1)]
        positions += polygon
        normals += [normal] * len(polygon)
    return positions, indices, normals, [(0, 0)] * len(positions)


def clipped(polygon, normal, limit):
    """The part of a convex polygon on the inner side of a plane."""
    kept = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        here, there = dot(a, normal) - limit, dot(b, normal) - limit
        if here <= 0:
            kept.append(a)
        if (here < 0 < there) or (there < 0 < here):
            kept.append(along(a, between(a, b), here / (here - there)))
    return kept


def straight(path_from, path_to):
    """The path of a straight tube, as spline gives that of a bent one."""
    way = unit([b - a for a, b in zip(path_from, path_to)])
    return [(path_from, way), (path_to, way)]


def placed(surface, place, degrees):
    """The surface, turned about z and moved."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    positions, indices, normals, uvs = surface

    def turned(p):
        return c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]
    return ([tuple(a + b for a, b in zip(turned(p), place)) for p in positions], indices,
            [turned(n) for n in normals], uvs)


def scaled_uvs(surface, size, swapped=False):
    """uvs in repeats of a texture that is `size` wide; swapped: turned by 90 degrees."""
    positions, indices, normals, uvs = surface
    return positions, indices, normals, [(v / size, u / size) if swapped else (u / size, v / size) for u, v in uvs]


def turn_after(p, q):
    """The rotation q, then p, as quaternions."""
    (px, py, pz, pw), (qx, qy, qz, qw) = p, q
    return [pw * qx + px * qw + py * qz - pz * qy, pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw, pw * qw - px * qx - py * qy - pz * qz]


def revolved(profile):
    """A profile led around the axis of height."""
    return moulding(circle(), profile)
