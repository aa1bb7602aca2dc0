"""The cases of a soak: what is rendered, and what must be equal afterwards."""
import json
import os
import random
import signal
import time

from mutations import mutate, tamper
from sandbox import (SANITIZER, Finding, Sandbox, check_messages, check_process, check_run, group_members,
                     wait_for_group)

OPTIONS = (["--time", "0.5"], ["--time", "1e9", "--animation", "all"], ["--integrator", "appel"], ["--env", "studio"],
           ["--error", "0.2", "--max-samples", "8"], ["--intersector", "exact"], ["--aperture", "0.1"],
           ["--single-sided-shadows", "off"], ["--single-sided-shadows", "on"], ["--crop", "3,3,12,9"],
           ["--aov", "depth,normal,uv,object,cryptomatte,lights"], ["--camera", "front"], ["--camera", "0"],
           ["--variant", "0"], ["--background", "transparent"], ["--exr-layout", "tiled"], ["--depth", "30"],
           ["--allow-outside"], ["--missing-texture", "checker"])
EXTRA_OUTPUTS = (["--stats", "out/s.json"], ["--record-rays", "out/r.bin"])


def mutated(asset, subseeds):
    """The files of an asset after a mutation for each subseed, and what they did."""
    asset = asset.copy()
    done = [mutate(random.Random(subseed), asset) for subseed in subseeds]
    return asset.files(), done


def draw_subseeds(rng):
    return [rng.getrandbits(32) for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5)))]


class RenderCase:
    """One asset, rendered; by times also strictly, with another number of threads, and listed by `info`."""

    def __init__(self, rng, soak):
        self.soak = soak
        self.name, self.asset = soak.choose_seed(rng)
        self.subseeds = draw_subseeds(rng)
        drawn = rng.sample(soak.options, rng.choice((0, 0, 1, 2)))
        self.options = list({option[0]: option for option in drawn}.values())
        self.extra = [o for o in EXTRA_OUTPUTS if rng.random() < 0.1]
        self.samples, self.further = str(rng.choice((1, 1, 2, 4))), rng.getrandbits(32)

    def arguments(self, threads="2"):
        words = [word for option in self.options + self.extra for word in option]
        if "--error" not in words:
            words += ["--samples", self.samples]
        return ["render", "in/" + self.asset.name, "-o", "out/p.exr", "-o", "out/p.png", "--size", "16x16", "--quiet",
                "--threads", threads, *words]

    def outputs(self):
        return ["out/p.exr", "out/p.png", *(o[1] for o in self.extra)]

    def files(self):
        return mutated(self.asset, self.subseeds)[0]

    def story(self):
        return [self.name, *mutated(self.asset, self.subseeds)[1]]

    def smaller(self):
        """This case without one of its mutations, options or further outputs."""
        for members in ("subseeds", "options", "extra"):
            for i in range(len(getattr(self, members))):
                twin = object.__new__(RenderCase)
                twin.__dict__.update(self.__dict__)
                setattr(twin, members, getattr(self, members)[:i] + getattr(self, members)[i + 1:])
                yield twin

    def run(self):
        """Findings."""
        with Sandbox(self.soak.program, self.soak.bounds, self.files()) as sandbox:
            first = sandbox.run(*self.arguments())
            found = check_run(first, sandbox, self.outputs())
            self.soak.count(first)
            if found:
                return found
            pictures, chance = pictures_of(sandbox), random.Random(self.further)
            for part, share in ((self.run_again, 0.25), (self.run_strictly, 0.5), (self.list_contents, 0.15)):
                if chance.random() < share:
                    sandbox.clear()
                    found += part(sandbox, first, pictures)
            return found

    def run_again(self, sandbox, first, pictures):
        run = sandbox.run(*self.arguments("1"))
        self.soak.count(run)
        found = check_run(run, sandbox, self.outputs())
        if (run.code, run.stderr) != (first.code, first.stderr):
            found.append(Finding("repeat", "another exit code or message with one thread", first.stderr + run.stderr))
        elif pictures_of(sandbox) != pictures:
            found.append(Finding("repeat", "another picture with one thread", run.stderr))
        return found

    def run_strictly(self, sandbox, first, pictures):
        """What is refused leniently is refused strictly; what is not refused strictly is the same picture."""
        if not self.soak.has_strict:
            return []
        run = sandbox.run(*self.arguments(), "--strict")
        self.soak.count(run)
        found = check_run(run, sandbox, self.outputs())
        if run.code == 0 and first.code != 0:
            found.append(Finding("strict", "drawn with --strict, refused without", first.stderr + run.stderr))
        if run.code == first.code == 0 and pictures_of(sandbox)["p.png"] != pictures["p.png"]:
            found.append(Finding("strict", "another picture with --strict", first.stderr + run.stderr))
        return found

    def list_contents(self, sandbox, *_):
        run = sandbox.run("info", "in/" + self.asset.name)
        self.soak.count(run)
        return check_run(run, sandbox, [])


def pictures_of(sandbox):
    """The bytes of the pictures, whose metadata name the number of threads."""
    found = {}
    for name in ("p.exr", "p.png"):
        if os.path.exists(sandbox.path("out", name)):
            with open(sandbox.path("out", name), "rb") as file:
                found[name] = file.read().replace(b"--threads 1", b"--threads 2")
    return found


class KillCase:
    """Ends a command at random times until it is done, and compares what it wrote with an undisturbed run."""

    def __init__(self, rng, soak):
        self.soak, self.chance, self.log = soak, random.Random(rng.getrandbits(32)), []

    def finish(self, sandbox, command, first):
        """Findings about runs that were ended, and the last one, which was not."""
        found, begin = [], time.monotonic()
        for _ in range(self.chance.choice((1, 2, 3, 5))):
            with open(sandbox.path("..", os.path.basename(sandbox.folder) + ".log"), "w+b") as log:
                process = sandbox.start(*command, "--resume", stdout=log, stderr=log)
                time.sleep(self.chance.random() * first)
                self.end(process)
                if not wait_for_group(process.pid, self.soak.bounds.wall / 4):
                    found.append(Finding("hang", "a process outlived the run that was ended", " ".join(self.log)))
                process.wait()
                log.seek(0)
                output = log.read().decode(errors="surrogateescape")
            os.remove(log.name)
            if SANITIZER.search(output):
                found.append(Finding("sanitizer", SANITIZER.search(output).group().strip(), output))
        self.log.append(f"{time.monotonic() - begin:.1f} s")
        last = sandbox.run(*command, "--resume")
        self.soak.count(last)
        found += check_process(last, self.soak.bounds)
        return found, last

    def end(self, process):
        how = self.chance.choice(("kill", "kill", "kill-group", "worker", "SIGTERM", "SIGINT"))
        self.log.append(how)
        try:
            if how == "worker":
                members = [p for p in group_members(process.pid) if p != process.pid]
                if members:
                    os.kill(self.chance.choice(members), signal.SIGKILL)
            elif how == "kill-group":
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.send_signal(signal.SIGKILL if how == "kill" else getattr(signal, how))
        except ProcessLookupError:
            pass  # it has ended
        if how == "worker":
            time.sleep(self.chance.random())
            process.kill()

    def smaller(self):
        return []  # kills come at random instants


class BatchCase(KillCase):
    """A batch of assets, two of them whole."""

    def __init__(self, rng, soak):
        super().__init__(rng, soak)
        self.assets = [(soak.choose_seed(rng), draw_subseeds(rng) if i > 1 else []) for i in range(5)]
        self.strict = ["--strict"] if soak.has_strict and rng.random() < 0.3 else []

    def files(self):
        found = {}
        for i, ((_, asset), subseeds) in enumerate(self.assets):
            found.update({f"{i}/{name}": data for name, data in mutated(asset, subseeds)[0].items()})
        return found

    def story(self):
        return [f"{i}: {name}: {'; '.join(mutated(asset, subseeds)[1])}"
                for i, ((name, asset), subseeds) in enumerate(self.assets)] + self.log

    def command(self, out):
        return ["batch", "in", "--out", out, "--size", "24x24", "--samples", "4", "--jobs", "2", "--format", "exr,png",
                "--quiet", *self.strict]

    def run(self):
        with Sandbox(self.soak.program, self.soak.bounds, self.files()) as sandbox:
            begin = time.monotonic()
            first = sandbox.run(*self.command("undisturbed"))
            self.soak.count(first)
            found = list(check_process(first, self.soak.bounds))
            if not found:
                found, last = self.finish(sandbox, self.command("out"), time.monotonic() - begin)
                found += self.compare(sandbox, first, last)
            for finding in found:
                finding.output = finding.output or f"{' '.join(first.command)}\n{first.stdout}{first.stderr}"
            return found

    def compare(self, sandbox, first, last):
        if sandbox.changes():
            yield Finding("files", f"changed outside the output folder: {sandbox.changes()[:5]}")
        if first.code != last.code:
            yield Finding("resume", f"exit code {last.code}, undisturbed {first.code}", first.stderr + last.stderr)
        pictures = [{n: h for n, h in sandbox.contents(folder, without=(".sightline",)).items()
                     if n.endswith((".png", ".exr"))} for folder in ("undisturbed", "out")]
        if pictures[0] != pictures[1]:
            different = sorted({name for name, _ in set(pictures[0].items()) ^ set(pictures[1].items())})
            yield Finding("resume", f"pictures differ: {different[:4]}")
        outcomes = [self.outcomes(sandbox.path(folder, "journal.jsonl")) for folder in ("undisturbed", "out")]
        if outcomes[0] != outcomes[1]:
            yield Finding("resume", f"outcomes differ: {outcomes[0]} {outcomes[1]}")
        left = [n for n in sandbox.contents("out", without=()) if "/.sightline-" in "/" + n]
        if left:
            yield Finding("files", f"temporary files are left: {left[:5]}")

    @staticmethod
    def outcomes(journal):
        """The last verdict and message of each picture; none without a journal."""
        found = {}
        if not os.path.exists(journal):
            return found
        with open(journal, encoding="utf-8", errors="replace") as file:
            for line in file:
                try:
                    record = json.loads(line)
                except ValueError:
                    continue  # cut by a kill
                if isinstance(record, dict) and "verdict" in record:
                    found[str(record.get("name"))] = record["verdict"], record.get("message")
        return found


class DamageCase(BatchCase):
    """A batch is resumed after one of the files that it left was damaged, as by a power cut or a bad disk."""

    def finish(self, sandbox, command, first):
        self.soak.count(sandbox.run(*command))
        files = [n for n in sorted(sandbox.contents("out", without=())) if not n.endswith("/")]
        name = self.chance.choice([n for n in files if n == "journal.jsonl" or self.chance.random() < 0.3] or files)
        with open(sandbox.path("out", name), "rb") as file:
            data = file.read()
        sandbox.write(os.path.join("out", name), tamper(self.chance, data))
        self.log.append(f"damaged {name}")
        last = sandbox.run(*command, "--resume")
        self.soak.count(last)
        return list(check_process(last, self.soak.bounds)), last

    def compare(self, sandbox, first, last):
        if last.code == 1:  # refused: what is in the folder may be someone's own
            return check_messages(last)
        return [f for f in super().compare(sandbox, first, last) if not f.detail.startswith("outcomes")]


class ResumeCase(KillCase):
    """A picture whose tiles are kept, of an asset that may be mutated."""

    def __init__(self, rng, soak):
        super().__init__(rng, soak)
        self.name, self.asset = soak.choose_seed(rng)
        self.subseeds = draw_subseeds(rng) if rng.random() < 0.3 else []

    def files(self):
        return mutated(self.asset, self.subseeds)[0]

    def story(self):
        return [self.name, *mutated(self.asset, self.subseeds)[1], *self.log]

    def command(self):
        return ["render", "in/" + self.asset.name, "-o", "out/p.exr", "-o", "out/p.png", "--size", "128x96",
                "--samples", "8", "--threads", "2", "--quiet"]

    def run(self):
        with Sandbox(self.soak.program, self.soak.bounds, self.files()) as sandbox:
            begin = time.monotonic()
            first = sandbox.run(*self.command())
            self.soak.count(first)
            length, outputs = time.monotonic() - begin, ["out/p.exr", "out/p.png"]
            found, pictures = check_run(first, sandbox, outputs), pictures_of(sandbox)
            if found:
                return found
            sandbox.clear()
            found, last = self.finish(sandbox, self.command(), length)
            if last.code != first.code:
                found.append(Finding("resume", f"exit code {last.code}, undisturbed {first.code}",
                                     first.stderr + last.stderr))
            for name in ("p.partial.exr", "p.partial.png"):  # of an interrupted run
                if os.path.exists(sandbox.path("out", name)):
                    os.remove(sandbox.path("out", name))
            if last.code == first.code == 0 and pictures_of(sandbox)["p.png"] != pictures["p.png"]:
                found.append(Finding("resume", "another picture after a resume", last.stderr))
            return found + check_run(last, sandbox, outputs)
