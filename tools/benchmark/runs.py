"""Runs programs in turn and measures their time and memory."""
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time


# Starts a command and writes its wall seconds, peak KiB and status to a descriptor. A small process of
# its own does this, because what a program's peak is said to be includes that of the process that
# starts it.
WATCH = """
import os, sys, time
start = time.perf_counter()
process = os.posix_spawnp(sys.argv[2], sys.argv[2:], os.environ)
_, status, usage = os.wait4(process, 0)
seconds = time.perf_counter() - start
os.write(int(sys.argv[1]), f"{seconds} {usage.ru_maxrss} {os.waitstatus_to_exitcode(status)}".encode())
"""


class Run:
    """One finished process: wall seconds, peak resident bytes, standard output and error."""

    def __init__(self, command, environment=None):
        readable, writable = os.pipe()
        with tempfile.TemporaryFile("w+") as out, open(readable, encoding="ascii") as told:
            subprocess.run([sys.executable, "-ISc", WATCH, str(writable), *command], stdout=out, stderr=out,
                           stdin=subprocess.DEVNULL, env={**os.environ, **(environment or {})},
                           pass_fds=(writable,), check=False)
            os.close(writable)
            seconds, kibibytes, status = (told.read() or "0 0 -1").split()
            out.seek(0)
            self.text = out.read()
        self.seconds, self.peak_bytes = float(seconds), int(kibibytes) * 1024
        if int(status) != 0:
            raise RuntimeError(f"{' '.join(command)} ended with {status}:\n{self.text}")


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


# Blender finds its modules beside the first python3 on the path, which must be Debian's.
BLENDER = {"PATH": "/usr/bin:/bin"}


def installed(name, path=None):
    """The program's path, or None with a notice."""
    found = shutil.which(name, path=path)
    if not found:
        print(f"Notice: {name} is not installed; its rows are skipped.", file=sys.stderr)
    return found


def blender_installed():
    """Whether Blender and the NumPy that its glTF importer needs are there; prints a notice if not."""
    if not installed("blender", BLENDER["PATH"]):
        return False
    try:
        Run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr",
             "import numpy"], BLENDER)
    except RuntimeError:
        print("Notice: Blender cannot import numpy (python3-numpy); its rows are skipped.", file=sys.stderr)
        return False
    return True
