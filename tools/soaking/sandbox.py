"""Runs the program on files in a folder of its own and states what it did wrong."""
import dataclasses
import hashlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time

SANITIZER = re.compile(r"ERROR: \w+Sanitizer: .*|.*runtime error: .*|==\d+==\s*(?:ABORTING|HINT).*|DEADLYSIGNAL")
FRAME = re.compile(r"#\d+ 0x\w+ in (\S+) \S*/(?:src|tools)/")
# What a message that a library wrote contains.
LIBRARY_TEXT = re.compile(r"json\.exception|filesystem error|std::|libpng|basic_string|vector::|map::at|bad_alloc"
                          r"|OpenImageIO|stoi|stod|terminate called|Assertion|TBB Warning", re.I)
SECRET = "not to be read by an asset"


@dataclasses.dataclass
class Finding:
    kind: str
    detail: str
    output: str = ""

    def signature(self):
        """The same for findings with the same cause: numbers, quoted names and paths are left out."""
        frame = FRAME.search(self.output) if self.kind == "sanitizer" else None
        text = re.sub(r"\S*/\S*|0x\w+|'[^']*'|\"[^\"]*\"|\d+|\[.*?\]", "", self.detail)
        return f"{self.kind} {frame.group(1) if frame else ''} {' '.join(text.split())}"[:160]


@dataclasses.dataclass
class Run:
    command: list
    code: int
    stdout: str
    stderr: str
    seconds: float     # of processor time
    memory: int        # MiB
    hung: bool


@dataclasses.dataclass
class Bounds:
    seconds: int       # of processor time for one picture
    memory: int        # MiB
    wall: int = 900    # seconds until a process that uses no processor time counts as hung
    file_size: int = 1 << 28


class Sandbox:
    """A folder with in/ (the assets), outside/ (which no asset may reach) and out/; used once."""

    def __init__(self, program, bounds, files):
        self.program, self.bounds = os.path.abspath(program), bounds
        self.folder = tempfile.mkdtemp(prefix="sightline-soak-")
        for name in ("in", "out", "outside", "temporary"):
            os.mkdir(os.path.join(self.folder, name))
        for name in ("secret.png", "secret.bin"):
            self.write(os.path.join("outside", name), SECRET.encode())
        for name, data in files.items():
            self.write(os.path.join("in", name), data)
        self.before = self.contents()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, data):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "wb") as file:
            file.write(data)

    def contents(self, top=".", without=("out", "undisturbed")):
        """The hash of each file below a folder by its path; folders have none."""
        found = {}
        for path, folders, names in os.walk(self.path(top)):
            place = os.path.relpath(path, self.path(top))
            if place == ".":
                folders[:] = [f for f in folders if f not in without]
            found[place + "/"] = ""
            for name in names:
                with open(os.path.join(path, name), "rb") as file:
                    found[os.path.normpath(os.path.join(place, name))] = hashlib.sha256(file.read()).hexdigest()
        return found

    def clear(self, name="out"):
        shutil.rmtree(self.path(name), ignore_errors=True)
        os.mkdir(self.path(name))

    def start(self, *arguments, **streams):
        environment = {"PATH": os.environ.get("PATH", ""), "HOME": self.path("temporary"),
                       "TMPDIR": self.path("temporary"), "ASAN_OPTIONS": "detect_leaks=0",
                       "UBSAN_OPTIONS": "print_stacktrace=1"}
        limits = ["prlimit", "--core=0", f"--fsize={self.bounds.file_size}", f"--cpu={10 * self.bounds.seconds}"]
        return subprocess.Popen([*limits, self.program, *arguments], cwd=self.folder, env=environment,
                                stdin=subprocess.DEVNULL, start_new_session=True, **streams)

    def run(self, *arguments):
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            process, hung = self.start(*arguments, stdout=out, stderr=err), threading.Event()

            def end():
                hung.set()
                os.killpg(process.pid, signal.SIGKILL)

            timer = threading.Timer(self.bounds.wall, end)
            timer.start()
            _, status, usage = os.wait4(process.pid, 0)
            timer.cancel()
            process.returncode = os.waitstatus_to_exitcode(status)
            texts = []
            for stream in (out, err):
                stream.seek(0)
                texts.append(stream.read(1 << 20).decode(errors="surrogateescape"))
            return Run(["sightline", *arguments], process.returncode, *texts, usage.ru_utime + usage.ru_stime,
                       usage.ru_maxrss >> 10, hung.is_set())

    def changes(self):
        """Paths outside the output folders that a run added, removed or changed."""
        after = self.contents()
        return sorted(n for n in {*self.before, *after} if self.before.get(n) != after.get(n))


def wait_for_group(group, seconds):
    """Whether all processes of a group end within this time; the rest is killed."""
    end = time.monotonic() + seconds
    while group_members(group):
        if time.monotonic() > end:
            os.killpg(group, signal.SIGKILL)
            return False
        time.sleep(0.02)
    return True


def group_members(group):
    """The running processes of a process group."""
    found = []
    for name in os.listdir("/proc"):
        if name.isdigit():
            try:
                with open(f"/proc/{name}/stat", encoding="ascii", errors="replace") as file:
                    state, _, its_group = file.read().rpartition(")")[2].split()[:3]
            except OSError:
                continue  # it has ended
            if int(its_group) == group and state not in "ZX":
                found.append(int(name))
    return found


def check_process(run, bounds):
    """How the process ended, and what it used."""
    output = run.stderr + run.stdout
    report = SANITIZER.search(output)
    if report:
        yield Finding("sanitizer", report.group().strip())
    elif run.hung:
        yield Finding("hang", f"did not end within {bounds.wall} s")
    elif run.code < 0 and run.code != -signal.SIGXCPU:
        yield Finding("crash", f"ended by {signal.Signals(-run.code).name}")
    elif run.code > 3 or run.code == 3 and run.command[1] != "batch":
        yield Finding("exit-code", f"exit code {run.code}")
    if run.seconds > bounds.seconds:
        yield Finding("time", f"took {run.seconds:.0f} s of processor time")
    if run.memory > bounds.memory:
        yield Finding("memory", f"used {run.memory} MiB")


def check_messages(run):
    """Errors are one line `sightline: FILE: reason`; all other lines are warnings."""
    if run.code not in (0, 1, 2) or SANITIZER.search(run.stderr):
        return
    lines = run.stderr.split("\n")
    errors = [line for line in lines if line.startswith("sightline: ")]
    others = [line for line in lines[:-1] if not line.startswith(("sightline: ", "warning: "))]
    if len(errors) != (run.code != 0):
        yield Finding("message", f"{len(errors)} lines of errors with exit code {run.code}")
    if lines[-1] or others:
        yield Finding("message", f"neither error nor warning: {(others or lines[-1:])[0][:200]}")
    if errors and not re.search(r"\bin/|--\w|\bout/", errors[0]):
        yield Finding("message", f"names no file: {errors[0][:200]}")
    raw = LIBRARY_TEXT.search(run.stderr)
    if raw:
        yield Finding("library-text", f"{raw.group()} in: {run.stderr[max(0, raw.start() - 100):raw.end() + 100]}")
    if re.search(r"[\x00-\x09\x0b-\x1f\x7f\udc80-\udcff]", run.stderr):
        yield Finding("message", "a control character or a byte that is not UTF-8")
    if SECRET in run.stderr + run.stdout:
        yield Finding("outside", "the text of a file outside the asset's folder is in the output")


def check_files(run, sandbox, outputs):
    """A run writes its outputs, all of them or none, and nothing else."""
    changed = sandbox.changes()
    if changed:
        yield Finding("files", f"changed outside the output folder: {changed[:5]}")
    found = [n for n in sandbox.contents("out", without=()) if not n.endswith("/")]
    wanted = [os.path.basename(o) for o in outputs] if run.code == 0 else []
    if run.code in (0, 1, 2) and sorted(found) != sorted(wanted):
        yield Finding("files", f"with exit code {run.code} the output folder has {sorted(found)}, not {sorted(wanted)}")


def check_run(run, sandbox, outputs):
    found = [*check_process(run, sandbox.bounds), *check_messages(run), *check_files(run, sandbox, outputs)]
    for finding in found:
        finding.output = f"$ {' '.join(run.command)}\n{run.stdout}{run.stderr}exit code {run.code}\n"
    return found
