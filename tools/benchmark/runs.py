"""Runs programs in turn and measures their time and memory."""
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time


class Run:
    """One finished process: wall seconds, peak resident bytes, standard output and error."""

    def __init__(self, command, environment=None):
        with tempfile.TemporaryFile("w+") as out:
            start = time.perf_counter()
            process = subprocess.Popen(command, stdout=out, stderr=out, stdin=subprocess.DEVNULL,
                                       env={**os.environ, **(environment or {})})
            _, status, usage = os.wait4(process.pid, 0)
            self.seconds = time.perf_counter() - start
            process.returncode = os.waitstatus_to_exitcode(status)
            self.peak_bytes = usage.ru_maxrss * 1024
            out.seek(0)
            self.text = out.read()
        if process.returncode != 0:
            raise RuntimeError(f"{' '.join(command)} ended with {process.returncode}:\n{self.text}")


class Figure:
    """Measurements of one thing: their median, printed with the spread."""

    def __init__(self, values, unit="s", scale=1.0):
        self.values = [v * scale for v in values]
        self.median = statistics.median(self.values)
        self.unit = unit

    def __str__(self):
        return (f"{short(self.median)} {self.unit} "
                f"({short(min(self.values))}–{short(max(self.values))})")


def short(value):
    """Three significant digits, no exponent."""
    if value == 0:
        return "0"
    digits = 2
    while digits < 6 and abs(value) < 10 ** (2 - digits):
        digits += 1
    return f"{value:.{digits}f}" if abs(value) < 10 else f"{value:.3g}" if abs(value) < 1000 \
        else f"{value:.0f}"


def in_turn(runs, *measures):
    """Calls each measure once per round, after one round that is not counted."""
    collected = [[] for _ in measures]
    for turn in range(runs + 1):
        for values, measure in zip(collected, measures):
            value = measure()
            if turn > 0:
                values.append(value)
    return collected


def installed(name):
    """The program's path, or None with a notice."""
    path = shutil.which(name)
    if not path:
        print(f"Notice: {name} is not installed; its rows are skipped.", file=sys.stderr)
    return path


def blender_installed():
    """Whether Blender and the NumPy that its glTF importer needs are there; prints a notice if not."""
    if not installed("blender"):
        return False
    # Debian's Blender uses the system's Python.
    found = subprocess.run(["/usr/bin/python3", "-c", "import numpy"], stderr=subprocess.DEVNULL,
                           check=False).returncode == 0
    if not found:
        print("Notice: python3-numpy, which Blender needs, is not installed; its rows are skipped.",
              file=sys.stderr)
    return found
