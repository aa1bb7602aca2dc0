#!/usr/bin/env python3
"""Faults that a batch survives: kills, full, read-only and vanishing disks, changing files, clocks.

batch_fault_test.py PROGRAM [unittest's arguments]
SIGHTLINE_KILLS and SIGHTLINE_ASSETS set the number of kills, at seeded random instants, and of assets.
"""
import glob
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import unittest

import batch_test

KILLS = int(os.environ.get("SIGHTLINE_KILLS", "6"))
ASSETS = int(os.environ.get("SIGHTLINE_ASSETS", "60"))
CORPUS = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))),
                      "shared", "corpus")
FAKETIME = glob.glob("/usr/lib/*/faketime/libfaketimeMT.so.1")
LONGER = ["--size", "64x64", "--samples", "160"]  # a picture takes a while
WORK = ["--format", "exr", "--turntable", "4", "--size", "64x64", "--samples", "32"]


def scaled(factor):
    """The triangle scaled in x: a different file and a different picture."""
    asset = batch_test.triangle()
    asset["nodes"][0]["scale"] = [factor, 1, 1]
    return asset


def can_mount():
    return subprocess.run(["unshare", "--mount", "--map-root-user", "mount", "-t", "tmpfs", "x", "/mnt"],
                          capture_output=True).returncode == 0


class FaultTest(batch_test.BatchTest):
    def setUp(self):
        super().setUp()
        for i in range(6):
            self.add(f"{i}.gltf", scaled(1 + i / 10))

    def verdicts(self, folder=None):
        return {n: p["verdict"] for n, p in batch_test.records(folder or self.out).items()}

    def journal(self):
        """Names in the order in which the pictures were finished."""
        try:
            with open(os.path.join(self.out, "journal.jsonl"), encoding="utf-8") as file:
                return [json.loads(line)["name"] for line in file if line.endswith("\n")]
        except OSError:
            return []


class Kills(FaultTest):
    def test_of_workers_lose_only_their_pictures(self):
        self.batch(*WORK, out=self.path("undisturbed"))
        process = self.start("--resume", *WORK)
        generator, killed = random.Random(3), 0
        while killed < KILLS:
            time.sleep(generator.random() * 0.05)
            if process.poll() is not None:
                process = self.start("--resume", *WORK, "--seed", str(killed))
            workers = batch_test.children(process.pid)
            try:
                os.kill(generator.choice(workers), signal.SIGKILL)
                killed += 1
            except (IndexError, ProcessLookupError):
                pass  # no worker, or it has ended
        process.wait(200)
        self.assertLessEqual(set(self.verdicts().values()), {"ok", "empty", "black", "killed"})
        self.batch("--resume", *WORK)
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("undisturbed")))

    def test_of_the_batch_lose_nothing(self):
        begin = time.monotonic()
        self.batch(*WORK, out=self.path("undisturbed"))
        length = time.monotonic() - begin
        generator = random.Random(5)
        for _ in range(KILLS):
            process = self.start("--resume", *WORK)
            time.sleep(generator.random() * length * 0.5)
            process.kill()
            process.wait()
        self.batch("--resume", *WORK)
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("undisturbed")))


class Disks(FaultTest):
    """Each test has its own mount namespace."""

    def script(self, text):
        if not can_mount():
            self.skipTest("Notice: mounting is not permitted")
        os.makedirs(self.out, exist_ok=True)
        batch = " ".join(f"'{a}'" for a in self.command("--format", "exr,png", "--size", "128x128"))
        done = subprocess.run(["unshare", "--mount", "--map-root-user", "bash", "-c", text],
                              env=dict(os.environ, OUT=self.out, BATCH=batch, COPY=self.path("copy")),
                              cwd=self.folder, capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def test_that_is_full_ends_the_batch_which_can_be_resumed(self):
        message = self.script("mount -t tmpfs -o size=300k x $OUT && { eval $BATCH; (($? == 1)); } && "
                              "mount -o remount,size=64m $OUT && eval $BATCH --resume && "
                              "cp -r $OUT $COPY")
        self.assertRegex(message, "disk is full|No space left")
        self.batch("--format", "exr,png", "--size", "128x128", out=self.path("undisturbed"))
        self.assertEqual(batch_test.pictures(self.path("copy")),
                         batch_test.pictures(self.path("undisturbed")))

    def test_that_is_read_only_ends_the_batch_at_once(self):
        message = self.script("mount -t tmpfs -o ro x $OUT && { eval $BATCH; (($? == 1)); }")
        self.assertIn("Read-only file system", message)

    def test_that_becomes_read_only_ends_the_batch(self):
        # Root may write everywhere, so the batch runs as another user.
        other_user = ["setpriv", "--reuid=65534", "--clear-groups"] if os.geteuid() == 0 else []
        os.makedirs(self.out)
        os.chmod(self.folder, 0o755), os.chmod(self.out, 0o777)
        process = subprocess.Popen(other_user + self.command("--jobs", "1", *LONGER), text=True,
                                   cwd=self.folder, stderr=subprocess.PIPE)
        self.wait_for(self.journal)
        os.chmod(self.out, 0o555)
        self.assertIn("cannot be written", process.communicate(timeout=200)[1])
        self.assertEqual(process.returncode, 1)

    def test_that_vanishes_ends_the_batch(self):
        process = self.start("--jobs", "1", *LONGER)
        self.wait_for(self.journal)
        os.rename(self.out, self.path("elsewhere"))
        self.assertEqual(process.wait(200), 1)
        self.assertIn("gone", process.stderr.read())
        self.assertFalse(os.path.exists(os.path.join(self.out, "index.html")))


class Inputs(FaultTest):
    def test_that_change_during_a_batch_are_rendered_again_by_the_next(self):
        process = self.start("--jobs", "1", *LONGER)
        self.wait_for(self.journal)
        for name in ("0", "1", "5"):  # finished, perhaps in progress, not started
            self.add(name + ".gltf", scaled(3))
        process.wait(200)
        self.batch("--resume", *LONGER)
        self.batch(*LONGER, out=self.path("undisturbed"))
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("undisturbed")))

    def test_that_were_missing_are_rendered_once_they_exist(self):
        asset = batch_test.triangle()
        asset["images"] = [{"uri": "late.png"}]
        asset["textures"] = [{"source": 0}]
        asset["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        asset["accessors"].append(dict(asset["accessors"][0], type="VEC2", max=[1, 1], min=[0, 0]))
        asset["meshes"][0]["primitives"][0].update(
            material=0, attributes={"POSITION": 0, "TEXCOORD_0": 1})
        self.add("0.gltf", asset)
        self.batch()
        with open(os.path.join(self.out, "journal.jsonl"), encoding="utf-8") as file:
            faults = {line["name"]: line.get("faults", []) for line in map(json.loads, file)}
        self.assertEqual([fault["key"] for fault in faults["0"]], ["missing-texture"])
        shutil.copy(os.path.join(self.out, "1.png"), self.path("assets", "late.png"))
        self.batch("--resume")
        self.assertEqual([n for n, p in batch_test.records(self.out).items() if p.get("skipped")],
                         ["1", "2", "3", "4", "5"])

    def test_may_have_names_that_are_not_utf8(self):
        name = b"\xff\xfe'\\ n\xc3.gltf"
        with open(os.path.join(os.fsencode(self.path("assets")), name), "w", encoding="utf-8") as file:
            json.dump(scaled(3), file)
        self.batch()
        self.assertIn(os.fsdecode(name[:-4] + b"png"), batch_test.pictures(self.out))
        self.batch("--resume")
        sheet = batch_test.records(self.out)
        self.assertTrue(all(p["skipped"] for p in sheet.values()))
        odd, = [p for n, p in sheet.items() if len(n) > 1]
        self.assertEqual(odd["files"][0]["link"], "%FF%FE%27%5C%20n%C3.png")
        os.mkdir(self.path("alone"))
        subprocess.run(["bash", "-c", batch_test.PROGRAM + odd["command"].removeprefix("sightline")],
                       check=True, cwd=self.path("alone"), capture_output=True)
        self.assertEqual(*[batch_test.pictures(self.path(f))[os.fsdecode(name[:-4] + b"png")]
                           for f in ("out", "alone")])

    @unittest.skipUnless(os.path.isdir(CORPUS), "Notice: no corpus of sample assets")
    def test_of_which_a_third_is_broken_do_not_stop_the_others(self):
        broken = sorted(f for f in glob.glob(CORPUS + "/invalid/**", recursive=True)
                        if f.endswith((".gltf", ".glb")))
        count = ASSETS // 3
        random.Random(1).shuffle(broken)
        for i in range(count):
            name = f"x{i}" + os.path.splitext(broken[i % len(broken)])[1]
            shutil.copy(broken[i % len(broken)], self.path("assets", name))
        for i in range(6, ASSETS - count):
            self.add(f"{i}.gltf", scaled(1 + i / ASSETS))
        # Sanitizers map more than any limit.
        sanitized = "asan" in batch_test.PROGRAM or "fuzz" in batch_test.PROGRAM
        memory = [] if sanitized else ["--memory", "4000"]
        done = subprocess.run(self.command("--timeout", "60", *memory), cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 3, done.stderr)
        verdicts = self.verdicts()
        self.assertEqual(len(verdicts), ASSETS)
        self.assertEqual({v for n, v in verdicts.items() if not n.startswith("x")}, {"ok"})
        self.assertIn("failed", [v for n, v in verdicts.items() if n.startswith("x")])
        self.assertLessEqual(set(verdicts.values()),  # no crash, no hang
                             {"ok", "drawn-with-faults", "empty", "black", "failed"})


class Clocks(FaultTest):
    @unittest.skipUnless(FAKETIME, "Notice: no libfaketime")
    def test_that_jump_back_an_hour_do_no_harm(self):
        stamp = self.path("stamp")
        with open(stamp, "w", encoding="utf-8") as file:
            file.write("+0")
        environment = dict(os.environ, LD_PRELOAD=FAKETIME[0], FAKETIME_TIMESTAMP_FILE=stamp,
                           FAKETIME_NO_CACHE="1", FAKETIME_DONT_FAKE_MONOTONIC="1")
        process = subprocess.Popen(self.command(*WORK, "--timeout", "60", "--log", self.path("log")),
                                   env=environment, cwd=self.folder)
        self.wait_for(self.journal)
        with open(stamp, "w", encoding="utf-8") as file:
            file.write("-3600")
        self.assertEqual(process.wait(200), 0)
        with open(self.path("log"), encoding="utf-8") as file:
            times = [json.loads(line)["time"] for line in file]
        self.assertLess(times[-1], times[0])  # the clock did jump
        self.assertTrue(all(0 <= p["seconds"] < 60 for p in batch_test.records(self.out).values()))
        self.batch("--resume", *WORK)
        self.assertTrue(all(p["skipped"] for p in batch_test.records(self.out).values()))


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
