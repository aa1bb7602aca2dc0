"""Rows about many assets: use of the cores, and speed compared with the peers."""
import json
import os
import shutil
import subprocess
import tempfile
import time

import inputs
from runs import BLENDER, Figure, Run, blender_installed, in_turn

SMALL = 1_000_000  # bytes of an asset that is one file


def self_contained(path):
    """Whether a glTF file refers to no other file."""
    if path.endswith(".glb"):
        return True
    with open(path, encoding="utf-8", errors="replace") as file:
        try:
            document = json.load(file)
        except ValueError:
            return False
    uris = [part.get("uri", "data:") for kind in ("buffers", "images")
            for part in document.get(kind, [])]
    return all(uri.startswith("data:") for uri in uris)


def assets(corpus, smallest=True):
    found = []
    for folder, _, names in os.walk(os.path.join(corpus, "valid")):
        found += [os.path.join(folder, n) for n in names if n.endswith((".glb", ".gltf"))]
    if smallest:
        found = [f for f in found if os.path.getsize(f) <= SMALL and self_contained(f)]
    return sorted(found, key=lambda f: (os.path.getsize(f), f))


def fresh_folder(path):
    shutil.rmtree(path, ignore_errors=True)
    os.makedirs(path)
    return path


def journal(folder):
    with open(os.path.join(folder, "journal.jsonl"), encoding="utf-8") as file:
        return [json.loads(line) for line in file]


def batch(bench, files, threads, *options):
    """Runs one batch; returns wall seconds, processor seconds and the journal."""
    out = fresh_folder(bench.path("batch"))
    before = os.times()
    start = time.perf_counter()
    done = subprocess.run([os.path.join(bench.bin, "sightline"), "batch", *files, "--out", out,
                           "--quiet", "--threads", str(threads), "--name", "{asset}.{ext}", *options],
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    wall = time.perf_counter() - start
    if done.returncode not in (0, 3):
        raise RuntimeError("the batch failed")
    after = os.times()
    cpu = (after.children_user - before.children_user
           + after.children_system - before.children_system)
    return wall, cpu, journal(out)


def copies(bench, count):
    folder = fresh_folder(bench.path("small"))
    originals = assets(bench.corpus)
    for i in range(count):
        original = originals[i % len(originals)]
        shutil.copy(original, os.path.join(folder, f"{i:04}" + os.path.splitext(original)[1]))
    return folder


def many_small(bench, row, threads, count=1000):
    folder = copies(bench, count)
    wall, cpu, outcomes = batch(bench, [folder], threads, "--size", "256x256", "--samples", "16")
    busy = cpu / (wall * threads)
    overhead = (wall * threads - sum(o["seconds"] for o in outcomes)) / len(outcomes) * 1000
    quarter = len(outcomes) // 4
    early, late = (max(o["memory"] for o in part) * 1e-6
                   for part in (outcomes[:quarter], outcomes[-quarter:]))
    title = f"{len(outcomes)} small assets, 256×256, 16 samples"
    return [row(f"{title}: processor time", f"{cpu:.1f} s", f"{threads} cores", f"{wall:.1f} s",
                busy, "≥ 0.9", busy >= 0.9),
            row(f"{title}: overhead per asset", f"{overhead:.2f} ms", "aim",
                "5 ms", overhead / 5, "≤ 1", overhead <= 5),
            row(f"{title}: memory of a worker, last quarter", f"{late:.0f} MB", "first quarter",
                f"{early:.0f} MB", late / early, "≤ 1.05", late <= 1.05 * early)]


def twenty(bench):
    """Twenty assets that the peers can read as well."""
    wanted = [f for f in assets(bench.corpus, smallest=False)
              if "Draco" not in f and "KTX" not in f and "Basis" not in f and "Meshopt" not in f]
    return wanted[::max(1, len(wanted) // 20)][:20]


def twenty_large(bench):
    """Twenty assets of meshes of the corpus, whose images are JPEGs of about 4096 × 4096 pixels, no two alike."""
    originals = [f for f in assets(bench.corpus, smallest=False)
                 if f.endswith(".glb") and inputs.read_glb(f)[0].get("images")]
    found = []
    for i in range(20 if originals else 0):
        path = bench.path(f"large_{i:02}.glb")
        if not os.path.exists(path):
            inputs.large_textures(os.path.join(bench.bin, "enlarge_image"), originals[i % len(originals)],
                                  path, 4096 - 16 * (i // len(originals)))
        found.append(path)
    return found


def blender_batch(bench, files, size, samples, threads):
    script = os.path.join(bench.root, "tools", "benchmark", "cycles.py")
    jobs = [{"asset": f, "output": bench.path("cycles.png"), "size": size, "fov": 45.0,
             "samples": samples, "threads": threads, "sun": False, "env": bench.env} for f in files]
    with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
        json.dump(jobs, file)
        file.flush()
        return Run(["blender", "-b", "--factory-startup", "-P", script, "--", "@" + file.name],
                   BLENDER).seconds


def f3d_batch(bench, files, size, display):
    start = time.perf_counter()
    for file in files:
        try:
            bench.f3d(file, display, size)
        except RuntimeError:
            pass  # assets that F3D cannot read are skipped
    return time.perf_counter() - start


def against(bench, row, threads, files, size, samples, peer, target, peer_run):
    """A row for one batch and a peer that draws the same files; `samples` in words."""
    options = ("--size", f"{size}x{size}", "--samples", samples.split()[0], "--env", bench.env, "--camera", "fit-sphere")
    mine, theirs = map(Figure, in_turn(1, lambda: batch(bench, files, threads, *options)[0], peer_run))
    ratio = theirs.median / mine.median
    what = "assets" if size == 512 else "large assets"
    return row(f"{len(files)} {what}, {size}×{size}, 1k HDRI, {samples}: wall", mine, peer, theirs, ratio,
               f"≥ {target}", ratio >= target)


def against_blender(bench, row, threads):
    if not blender_installed():
        return []
    return [against(bench, row, threads, files, size, f"{samples} per pixel", "one Blender", target,
                    lambda files=files, size=size, samples=samples:
                        blender_batch(bench, files, size, samples, threads))
            for files, size, samples, target in ((twenty(bench), 512, 1, 10), (twenty(bench), 512, 16, 5),
                                                 (twenty_large(bench), 256, 1, 10))]


def against_f3d(bench, row, threads, display):
    return [against(bench, row, threads, files, size, "1 sample", "F3D without HDRI", target,
                    lambda files=files, size=size: f3d_batch(bench, files, size, display))
            for files, size, target in ((twenty(bench), 512, 2), (twenty_large(bench), 256, 3))]
