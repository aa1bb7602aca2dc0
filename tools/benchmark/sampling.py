"""Rows that compare --error with the same number of samples everywhere, by rays and by FLIP.

Rays are counted, not timed, so the figures are the same on every machine with one instruction set.
"""
import json
import math
import os
import statistics

from runs import Run

SIZE = ("--size", "128x128", "--camera", "fit-sphere")
CONVERGED = ("--samples", "512", "--seed", "1")  # another seed: independent of what is measured
EVEN = (8, 16, 32, 64, 128)
ERRORS = (0.06, 0.045, 0.03)

# By light: what the program chooses for the file (its own lamps or the studio), and an environment
# with a sun, in which every pixel is noisy, so that even sampling is near the best there is.
OWN_LIGHT = ("DamagedHelmet.glb", "FlightHelmet.gltf", "TransmissionTest.gltf", "Duck.glb",
             "SheenTestGrid.gltf", "MetalRoughSpheresNoTextures.gltf", "LightsPunctualLamp.gltf",
             "EmissiveStrengthTest.gltf", "CesiumMan.glb", "retroufo.glb", "ClearCoatCarPaint.gltf",
             "DiffuseTransmissionPlant.gltf")
HDRI = OWN_LIGHT[:6]


def rays_at(flip, curve):
    """Rays of even sampling for this FLIP, from (rays, FLIP) pairs of rising rays, on a curve that
    is straight in logarithms between them and beyond."""
    logs = [(math.log(rays), math.log(value)) for rays, value in curve]
    pairs = list(zip(logs, logs[1:]))
    (x0, y0), (x1, y1) = next((p for p in pairs if p[1][1] <= math.log(flip)), pairs[-1])
    return math.exp(x0 + (math.log(flip) - y0) * (x1 - x0) / (y1 - y0))


class Asset:
    """Renders of one asset under one light."""

    def __init__(self, bench, file, light):
        self.bench, self.file, self.light = bench, file, light
        self.rays("converged.png", *CONVERGED)

    def rays(self, output, *quality):
        _, stats = self.bench.sightline(self.file, *SIZE, *self.light, *quality, output=output)
        return sum(stats["rays"].values())

    def point(self, *quality):
        """Rays and mean FLIP of one picture."""
        rays = self.rays("ours.png", *quality)
        text = Run([os.path.join(self.bench.bin, "sightline"), "diff", "--json",
                    self.bench.path("converged.png"), self.bench.path("ours.png")]).text
        return rays, json.loads(text)[0]["flip_mean"]


def measure(bench, file, light):
    """The rays of each --error, and those of even sampling at the same FLIP."""
    asset = Asset(bench, file, light)
    even = [asset.point("--samples", str(n)) for n in EVEN]
    found = [asset.point("--error", str(e)) for e in ERRORS]
    return [rays for rays, _ in found], [rays_at(flip, even) for _, flip in found]


def millions(rays):
    return ", ".join(f"{r * 1e-6:.2f}" for r in rays) + " M rays"


def rows_of(bench, row, names, title, light):
    """A row for each asset, whose ratio is the geometric mean over the errors, and their median."""
    found, ratios = [], []
    for file in filter(None, map(bench.asset, names)):
        ours, peer = measure(bench, file, light)
        ratios.append(statistics.geometric_mean(a / b for a, b in zip(ours, peer)))
        found.append(row(f"{os.path.basename(file)}, {title}, --error {', '.join(map(str, ERRORS))}",
                         millions(ours), "even sampling at equal FLIP", millions(peer), ratios[-1],
                         "≤ 1.1", ratios[-1] <= 1.1))
    if ratios:
        median = statistics.median(ratios)
        found.append(row(f"the median of these {len(ratios)} ratios", "–", "even sampling", "–",
                         median, "≤ 0.7", median <= 0.7))
    return found


def adaptive_rows(bench, row):
    return (rows_of(bench, row, OWN_LIGHT, "default light", ()) +
            rows_of(bench, row, HDRI, "1k HDRI", ("--env", bench.env)))
