"""Rows about many assets: use of the cores, and speed compared with the peers."""
import json
import os
import shutil
import subprocess
import tempfile
import time

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


def batch(bench, inputs, threads, *options):
    """Runs one batch; returns wall seconds, processor seconds and the journal."""
    out = fresh_folder(bench.path("batch"))
    before = os.times()
    start = time.perf_counter()
    done = subprocess.run([os.path.join(bench.bin, "sightline"), "batch", *inputs, "--out", out,
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


def blender_batch(bench, files, samples, threads):
    script = os.path.join(bench.root, "tools", "benchmark", "cycles.py")
    jobs = [{"asset": f, "output": bench.path("cycles.png"), "size": 512, "fov": 45.0,
             "samples": samples, "threads": threads, "sun": False, "env": bench.env} for f in files]
    with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
        json.dump(jobs, file)
        file.flush()
        return Run(["blender", "-b", "--factory-startup", "-P", script, "--", "@" + file.name],
                   BLENDER).seconds


def against_blender(bench, row, threads):
    if not blender_installed():
        return []
    files, found = twenty(bench), []
    for samples, target in ((1, 10), (16, 5)):
        options = ("--size", "512x512", "--samples", str(samples), "--env", bench.env,
                   "--camera", "fit-sphere")
        mine, theirs = map(Figure, in_turn(
            1, lambda: batch(bench, files, threads, *options)[0],
            lambda: blender_batch(bench, files, samples, threads)))
        ratio = theirs.median / mine.median
        found.append(row(f"{len(files)} assets, 512×512, 1k HDRI, {samples} per pixel: wall", mine,
                         "one Blender", theirs, ratio, f"≥ {target}", ratio >= target))
    return found


def against_f3d(bench, row, threads, display):
    files = twenty(bench)
    options = ("--size", "512x512", "--samples", "1", "--camera", "fit-sphere", "--env", bench.env)

    def f3d():
        start = time.perf_counter()
        for file in files:
            try:
                bench.f3d(file, display)
            except RuntimeError:
                pass  # assets that F3D cannot read are skipped
        return time.perf_counter() - start

    mine, theirs = map(Figure, in_turn(
        1, lambda: batch(bench, files, threads, *options)[0], f3d))
    ratio = theirs.median / mine.median
    return [row(f"{len(files)} assets, 512×512, 1k HDRI, 1 sample: wall", mine,
                "F3D without HDRI", theirs, ratio, "≥ 2", ratio >= 2)]
