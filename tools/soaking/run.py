"""Draws cases, runs several at a time, saves findings, and tells how it went."""
import collections
import concurrent.futures
import os
import random
import re
import shlex
import subprocess
import sys
import threading
import time

from cases import OPTIONS, BatchCase, DamageCase, RenderCase, ResumeCase

MOST_SAVED = 3  # findings of one signature
REPORT_EVERY = 30.0  # seconds


class Soak:
    """The cases of one seed. `reductions`: how many runs may be spent on making a finding
    smaller; `first`: the first finding ends the soak."""

    def __init__(self, program, seeds, seed, bounds, folder, reductions, first):
        self.program, self.seed, self.bounds, self.folder = program, seed, bounds, folder
        self.reductions, self.first = reductions, first
        self.seeds = seeds
        # Large assets take long, and invalid ones are refused before their mutations are met.
        self.weights = [(0.3 if "/invalid/" in name else 1) / (1 + asset.size() / 2e5) for name, asset in seeds]
        text = subprocess.run([program, "render", "--help"], capture_output=True, text=True, check=True).stdout
        self.has_strict = "--strict" in text
        self.options = [option for option in OPTIONS if option[0] in text]
        self.codes, self.kinds = collections.Counter(), collections.Counter()
        self.found = {}  # signature -> [first finding, number of cases]
        self.lock, self.next, self.begin = threading.Lock(), 0, time.monotonic()

    def choose_seed(self, rng):
        return rng.choices(self.seeds, self.weights)[0]

    def count(self, run):
        with self.lock:
            self.codes[f"{run.command[1]}, exit code {run.code}"] += 1

    def draw(self, number):
        rng = random.Random(f"{self.seed}:{number}")
        kind = rng.choices((RenderCase, BatchCase, ResumeCase, DamageCase), (30, 1, 1, 1))[0]
        return kind(rng, self)

    def run_case(self, number):
        case = self.draw(number)
        findings = case.run()
        with self.lock:
            self.kinds[type(case).__name__] += 1
        for finding in findings:
            with self.lock:
                entry = self.found.setdefault(finding.signature(), [finding, 0])
                entry[1] += 1
            if entry[1] <= MOST_SAVED:
                self.save(number, *reduced(case, finding, self.reductions))

    def save(self, number, case, finding):
        words = re.sub(r"[^a-z0-9]+", "-", finding.signature().lower()).strip("-")[:60].strip("-")
        folder = os.path.join(self.folder, f"{words}-{self.seed}-{number}")
        for name, data in case.files().items():
            path = os.path.join(folder, "in", name)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "wb") as file:
                file.write(data)
        command = case.arguments() if isinstance(case, RenderCase) else ["(see output.txt)"]
        lines = [f"{finding.kind}: {finding.detail}", f"case {number} of seed {self.seed}",
                 *case.story(), "", "sightline " + shlex.join(command)]
        with open(os.path.join(folder, "finding.txt"), "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write("\n".join(lines) + "\n")
        with open(os.path.join(folder, "output.txt"), "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(finding.output)

    def run(self, minutes, cases, jobs):
        """Starts cases until the time is over or that many are done."""
        end = self.begin + 60 * minutes if minutes else float("inf")
        shown = self.begin
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            waiting = set()
            while waiting or not self.is_over(end, cases):
                while len(waiting) < jobs and not self.is_over(end, cases):
                    waiting.add(pool.submit(self.run_case, self.next))
                    self.next += 1
                done, waiting = concurrent.futures.wait(waiting, 1, concurrent.futures.FIRST_COMPLETED)
                for future in done:
                    future.result()  # raises what the case raised
                if time.monotonic() > shown + REPORT_EVERY:
                    shown = time.monotonic()
                    self.report(end, cases)

    def is_over(self, end, cases):
        if self.first and self.found:
            return True
        return time.monotonic() > end if cases is None else self.next >= cases

    def report(self, end, cases):
        passed = time.monotonic() - self.begin
        left = passed / max(self.next, 1) * (cases - self.next) if cases is not None else end - time.monotonic()
        print(f"{self.next} cases, {sum(self.codes.values())} runs, {len(self.found)} kinds of findings, "
              f"{max(left, 0) / 60:.0f} min left", file=sys.stderr, flush=True)

    def summarize(self):
        """Prints what was run and found; returns the exit code."""
        print(f"{sum(self.kinds.values())} cases and {sum(self.codes.values())} runs "
              f"in {(time.monotonic() - self.begin) / 60:.1f} min, seed {self.seed}"
              f"{', with --strict' if self.has_strict else ''}:")
        for name, count in sorted(self.kinds.items()) + sorted(self.codes.items()):
            print(f"  {count:7} {name}")
        for signature, (finding, count) in sorted(self.found.items()):
            print(f"finding: {count} × {finding.kind}: {finding.detail[:160]!r}")
        print(f"findings are in {self.folder}" if self.found else "no findings")
        return 1 if self.found else 0


def reduced(case, finding, runs):
    """The case and its finding without the mutations and options that the finding does not need."""
    smaller = iter(case.smaller())
    while runs > 0 and (twin := next(smaller, None)):
        runs -= 1
        same = [f for f in twin.run() if f.signature() == finding.signature()]
        if same:  # what could not be left out before is tried again: it may have depended on this
            case, finding, smaller = twin, same[0], iter(twin.smaller())
    return case, finding
