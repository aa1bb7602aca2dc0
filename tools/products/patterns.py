"""Patterns for textures: rows of pixels, the same on every machine."""
import math

from products.shapes import unit


def noise(x, y):
    """A repeatable number in [0, 1) for a pair of integers."""
    mixed = (x * 73856093 ^ y * 19349663) & 0xFFFFFFFF
    mixed = (mixed ^ mixed >> 15) * 0x2C1B3C6D & 0xFFFFFFFF
    return (mixed ^ mixed >> 12) % 4096 / 4096


def smooth_noise(x, y, period):
    """Noise between whole numbers, which repeats after `period` of them in both directions."""
    def ease(t):
        return t * t * (3 - 2 * t)

    i, j = math.floor(x), math.floor(y)
    a, b = ease(x - i), ease(y - j)
    corners = [[noise((i + m) % period, (j + n) % period) for m in (0, 1)] for n in (0, 1)]
    low, high = (row[0] * (1 - a) + row[1] * a for row in corners)
    return low * (1 - b) + high * b


def normal_map(height, size, strength):
    """The pixels of a normal map of a height over the unit square, which repeats."""
    heights = [[height((x + 0.5) / size, (y + 0.5) / size) for x in range(size)] for y in range(size)]

    def pixel(x, y):
        slopes = (heights[y][(x + 1) % size] - heights[y][x - 1],
                  heights[y - 1][x] - heights[(y + 1) % size][x])
        normal = unit([-strength * s for s in slopes] + [1])
        return tuple(round(127.5 + 127.5 * n) for n in normal)

    return [[pixel(x, y) for x in range(size)] for y in range(size)]


def oak(size=128):
    """Grain along x."""
    def pixel(x, y):
        bend = smooth_noise(4 * x, 8 * y, 8)
        ring = 0.5 + 0.5 * math.sin(2 * math.pi * (7 * y + 1.2 * bend))
        fibre = smooth_noise(6 * x, 64 * y, 64)
        pore = smooth_noise(16 * x, 128 * y, 128) > 0.86
        shade = 0.8 + 0.13 * ring + 0.14 * fibre - 0.16 * pore
        return tuple(min(255, round(c * shade)) for c in (196, 146, 92))
    return [[pixel(x / size, y / size) for x in range(size)] for y in range(size)]


def grain(x, y):
    """The height of leather: cells with creases between them."""
    cells, nearest = 12, [9.0, 9.0]
    i, j = math.floor(cells * x), math.floor(cells * y)
    for m in range(i - 1, i + 2):
        for n in range(j - 1, j + 2):
            a, b = m % cells, n % cells
            nearest.append(math.hypot(m + 0.15 + 0.7 * noise(a, b) - cells * x,
                                      n + 0.15 + 0.7 * noise(a + 50, b) - cells * y))
    first, second = sorted(nearest)[:2]
    return min(1, 3 * (second - first))


def weave(x, y):
    """The height of a cloth of crossing threads."""
    a, b = 16 * x, 16 * y
    if (math.floor(a) + math.floor(b)) % 2:
        a, b = b, a
    return math.sin(math.pi * (a % 1)) * (0.7 + 0.3 * math.sin(math.pi * (b % 1)))
