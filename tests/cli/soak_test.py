#!/usr/bin/env python3
"""tools/soak finds nothing in the program on the project's own scenes, and finds every planted fault.

soak_test.py PROGRAM [unittest's arguments]
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SOAK = os.path.join(ROOT, "tools", "soak")
# Stands for the program: refuses one asset in three, and writes empty files for the others.
SOUND = """
[[ $* == *--help* ]] && { echo --time; exit; }
set -o pipefail
size=$(cat in/a.gl* | wc -c) || kill -KILL $$  # a kill may meet the pipe's processes
refused=$((size % 3 == 0))
end() {
    ((refused)) && { echo "sightline: $input: accessors[0]: is bad" >&2; exit 1; }
    [[ $command == render ]] && while (($#)); do [[ $1 == out/* ]] && : > "$1"; shift; done
    exit 0
}
command=$1 input=$2 all=$*
"""
# What it does wrong before it ends, by the kind of finding.
FAULTS = {
    "crash": "kill -SEGV $$",
    "exit-code": "((refused)) && exit 7",
    "sanitizer": "echo 'a.cpp:1:2: runtime error: signed integer overflow' >&2",
    "message: two lines": "((refused)) && echo 'sightline: in/a.glb: is bad' >&2",
    "message: no file": "((refused)) && { echo 'sightline: bad' >&2; exit 1; }",
    "message: chatter": "echo loading >&2",
    "message: control": r"printf 'warning: \033[2J\n' >&2",
    "message: no newline": "((refused)) || printf 'warning: in/a.glb: odd' >&2",
    "library-text": "echo 'warning: in/a.glb: std::bad_alloc' >&2",
    "files: beside": "touch left",
    "files: input": "echo >> $input",
    "files: temporary": "touch $TMPDIR/left",
    "files: more": "touch out/q",
    "files: in spite of an error": "((refused)) && touch out/p.png",
    "files: missing": "((refused)) || exit 0",
    "outside": 'echo "warning: in/a.glb: $(cat outside/secret.bin)" >&2',
    "time": "for ((i = 0; i < 1000000; ++i)); do :; done",
    "memory": f"{sys.executable} -c 'len(bytes([1]) * 300_000_000)'",
    "repeat: code": '[[ $all == *"threads 1"* ]] && refused=1',
    "repeat: picture": '[[ $all == *"threads 1"* ]] && ((!refused)) && { touch out/p.exr; echo > out/p.png; exit 0; }',
    "resume": "refused=0; [[ $all == *--resume* ]] && { touch out/p.exr; echo > out/p.png; exit 0; }",
}
# Bounds and cases for faults that the first cases with usual bounds would not show.
OPTIONS = {"time": ("--seconds", "1"), "memory": ("--memory", "200"), "resume": ("--case", "7")}


class SoakTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-soak-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def soak(self, *arguments, program=PROGRAM):
        done = subprocess.run([sys.executable, SOAK, "--own", "--program", program, "--findings",
                               os.path.join(self.folder, "findings"), *arguments],
                              capture_output=True, text=True, timeout=600, check=False)
        return done.returncode, done.stdout + done.stderr

    def findings(self):
        """The text of each finding."""
        found, top = [], os.path.join(self.folder, "findings")
        for name in os.listdir(top) if os.path.isdir(top) else []:
            with open(os.path.join(top, name, "finding.txt"), encoding="utf-8") as file:
                found.append(file.read())
        return found


class Soak(SoakTest):
    def test_the_program_withstands_it(self):
        code, text = self.soak("--cases", "44", "--seed", "3")
        self.assertEqual((code, self.findings()), (0, []), text)
        runs = {name: int(count) for count, name in re.findall(r"^ +(\d+) (.+)$", text, re.M)}
        self.assertEqual(sum(count for name, count in runs.items() if name.endswith("Case")), 44)
        # Mutations leave some assets whole and damage others.
        self.assertGreater(runs["render, exit code 0"], 5)
        self.assertGreater(runs["render, exit code 1"], 5)


class SoakFinds(SoakTest):
    """What it is given is a shell script but for the last test."""

    def plant(self, text):
        """A program with this text."""
        path = os.path.join(self.folder, "planted")
        with open(path, "w", encoding="utf-8") as file:
            file.write("#!/bin/bash\n" + text)
        os.chmod(path, 0o755)
        return path

    def test_a_sound_program_passes(self):
        program = self.plant(SOUND + 'end "$@"\n')
        for cases in (("--cases", "6"), ("--case", "7")):
            code, text = self.soak(*cases, "--seed", "1", program=program)
            self.assertEqual((code, self.findings()), (0, []), text)

    def test_each_planted_fault_is_found_and_saved(self):
        for name, fault in FAULTS.items():
            with self.subTest(name):
                shutil.rmtree(os.path.join(self.folder, "findings"), ignore_errors=True)
                program = self.plant(f'{SOUND}{fault}\nend "$@"\n')
                options = OPTIONS.get(name, ())
                if "--case" not in options:
                    options = ("--cases", "30", *options)
                code, text = self.soak(*options, "--seed", "1", "--first", "--reductions", "2", program=program)
                kind = name.partition(":")[0]
                self.assertEqual(code, 1, text)
                self.assertIn(f"× {kind}: ", text)
                self.assertTrue([f for f in self.findings() if f.startswith(kind + ": ")], text)

    def test_a_finding_can_be_repeated_and_needs_all_of_its_mutations(self):
        program = self.plant(f'{SOUND}((refused)) && exit 7\nend "$@"\n')
        self.soak("--cases", "30", "--seed", "1", "--first", program=program)
        first = self.findings()
        number = re.search(r"case (\d+) of seed 1", first[0]).group(1)
        shutil.rmtree(os.path.join(self.folder, "findings"))
        self.soak("--case", number, "--seed", "1", program=program)
        self.assertIn(self.findings()[0], first)
        files = os.listdir(os.path.join(self.folder, "findings"))
        asset = os.path.join(self.folder, "findings", files[0], "in")
        self.assertEqual(sum(os.path.getsize(os.path.join(asset, n)) for n in os.listdir(asset)) % 3, 0)

    def test_a_crash_of_the_program_itself_is_found(self):
        program = self.plant(f'"{PROGRAM}" "$@"; code=$?; [[ $* == *in/* ]] && kill -SEGV $$; exit $code\n')
        code, text = self.soak("--case", "0", "--seed", "1", "--reductions", "0", program=program)
        self.assertEqual(code, 1)
        self.assertIn("× crash: 'ended by SIGSEGV'", text)


if __name__ == "__main__":
    unittest.main()
