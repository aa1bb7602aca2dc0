"""Rows about loading: what the pictures of an asset share, and what a picture does not need."""
import glob
import json
import os
import shutil

import inputs
from runs import Figure, Run, in_turn

CESIUM_MAN = "CesiumMan.glb"
TEXTURED = "DamagedHelmet.glb"


def large_textures(bench, side=4096):
    """A copy of DamagedHelmet whose five images, of which four are read, are JPEGs of side × side
    pixels; None if it is not in the corpus."""
    asset, path = bench.asset(TEXTURED), bench.path(f"textures_{side}.glb")
    if asset and not os.path.exists(path):
        inputs.large_textures(os.path.join(bench.bin, "enlarge_image"), asset, path, side)
    return asset and path


def sequence(bench, scene, *options):
    """One command for several pictures: the process, and the statistics of each picture."""
    name = bench.path("sequence_{frame:03}")
    for old in glob.glob(bench.path("sequence_*")):
        os.remove(old)
    run = Run([os.path.join(bench.bin, "sightline"), "render", scene, "-o", name + ".png", "--stats",
               name + ".json", "--quiet", "--threads", "2", *options])
    statistics = []
    for path in sorted(glob.glob(bench.path("sequence_*.json"))):
        with open(path, encoding="utf-8") as file:
            statistics.append(json.load(file))
    return run, statistics


def shared(bench, row, title, target, scene, stages, *options):
    """A row for several pictures of one asset: wall time over one load and the `stages` of each."""
    runs = [sequence(bench, scene, *options) for _ in range(bench.count + 1)][1:]
    mine = Figure([run.seconds for run, _ in runs])
    least = Figure([all_stats[0]["seconds"]["load"]
                    + sum(stats["seconds"][stage] for stats in all_stats for stage in stages)
                    for _, all_stats in runs])
    ratio = Figure([a / b for a, b in zip(mine.values, least.values)]).median
    return row(title, mine, f"one load and all of {', '.join(stages)}", least, ratio, f"≤ {target}",
               ratio <= target)


def pictures_of_one_asset(bench, row):
    found, large, man = [], large_textures(bench), bench.asset(CESIUM_MAN)
    size = ("--size", "256x256")
    if large:
        found.append(shared(bench, row, "36 views, four 4K textures, 256×256, 16 samples: wall", 1.25, large,
                            ["render"], "--turntable", "36", "--samples", "16", *size))
    for samples in ("16", "1") if man else ():
        found.append(shared(bench, row, f"48 frames of CesiumMan, 256×256, {samples} per pixel: wall", 1.4, man,
                            ["pose", "build", "render"], "--frames", "0..47", "--samples", samples, *size))
    return found


def one_picture(bench, row):
    large, found = large_textures(bench), []
    for samples in (1, 16) if large else ():
        options = ("--size", "256x256", "--samples", str(samples), "--camera", "fit")
        runs = in_turn(bench.count, lambda: bench.sightline(large, *options),
                       lambda: bench.sightline(large, *options, "--full-textures"))
        walls = [Figure([run.seconds for run, _ in side]) for side in runs]
        peaks = [Figure([stats["peak_memory_bytes"] for _, stats in side], "MB", 1e-6) for side in runs]
        for what, (ours, peer) in (("wall", walls), ("peak memory", peaks)):
            found.append(row(f"four 4K textures, 256×256, {samples} per pixel: {what}", ours,
                             "with --full-textures", peer, ours.median / peer.median, "–", True))
    return found


def decoding(bench, row):
    """The load stage against djpeg of the images that are read, at the scale that is needed, to nowhere, two at
    a time."""
    large = large_textures(bench)
    if not large:
        return []
    if not shutil.which("djpeg"):
        print("Notice: djpeg is not installed (apt install libjpeg-turbo-progs); its row is left out")
        return []
    document, binary = inputs.read_glb(large)
    names = []
    for i in (0, 1, 2, 4):  # the fourth is occlusion, which is not read
        view = document["bufferViews"][document["images"][i]["bufferView"]]
        start = view.get("byteOffset", 0)
        names.append(inputs.write(bench.path(f"texture_{i}.jpg"), binary[start:start + view["byteLength"]]))
    # With one sample, a quarter of each side is wanted.
    peer = 'printf "%s\\n" "$@" | xargs -n 1 -P 2 djpeg -scale 1/4 -outfile /dev/null'
    shell = ["sh", "-c", peer, "sh", *names]
    options = ("--size", "256x256", "--samples", "1", "--camera", "fit")
    mine, least = map(Figure, in_turn(
        bench.count, lambda: bench.sightline(large, *options)[1]["seconds"]["load"], lambda: Run(shell).seconds))
    ratio = mine.median / least.median
    return [row("four 4K textures, 256×256, 1 per pixel: load", mine, "djpeg -scale 1/4, two at a time", least,
                ratio, "≤ 2", ratio <= 2)]


def geometry(bench, row):
    waves = inputs.waves(bench.path("waves.glb"), 1000)

    read = ["sh", "-c", 'cat "$0" >/dev/null', waves]

    def ours():
        seconds = bench.sightline(waves, "--size", "64x64", "--samples", "1")[1]["seconds"]
        return seconds["load"] + seconds["build"]

    mine, least = map(Figure, in_turn(
        bench.count, ours, lambda: Run(read).seconds + bench.bare(waves)["build"]))
    ratio = mine.median / least.median
    return [row("2 M triangles in a GLB: load and build", mine, "cat and rtcCommitScene", least, ratio,
                "≤ 1.5", ratio <= 1.5)]


def rows_of(bench, row):
    return pictures_of_one_asset(bench, row) + one_picture(bench, row) + decoding(bench, row) + geometry(bench, row)
