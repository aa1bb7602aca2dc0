#!/usr/bin/env python3
"""`sightline batch --farm slurm` on a real Slurm cluster on this machine.

farm_test.py PROGRAM [unittest's arguments]
"""
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import batch_test

CLUSTER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "slurm_cluster")
PICTURES = ["--turntable", "6", "--samples", "16", "--size", "64x64", "--format", "exr"]


class FarmTest(batch_test.BatchTest):
    def journal(self, folder):
        with open(os.path.join(folder, "journal.jsonl"), encoding="utf-8") as file:
            return sorted(json.loads(line)["name"] for line in file)


class WithoutACluster(FarmTest):
    def test_a_dry_run_prints_the_scripts_and_writes_nothing(self):
        self.add("a.gltf")
        done = subprocess.run(self.command("--farm", "slurm", "--dry-run", "--memory", "500",
                                           "--farm-option=--partition=short"),
                              capture_output=True, text=True, check=True)
        for text in ("#SBATCH --partition=short", "#SBATCH --requeue", "#SBATCH --mem=", "farm-part",
                     "farm-merge"):
            self.assertIn(text, done.stdout)
        self.assertFalse(os.path.exists(self.out))

    def with_fake_slurm(self):
        fake = self.path("bin")
        os.mkdir(fake)
        with open(os.path.join(fake, "sbatch"), "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\necho \"$@\" >> {self.path('submitted')}\necho 7\n")
        os.chmod(os.path.join(fake, "sbatch"), 0o755)
        return dict(os.environ, PATH=fake + ":" + os.environ["PATH"])

    def test_elements_may_run_twice_and_missing_ones_are_submitted_again(self):
        for name in "abc":
            self.add(name + ".gltf")
        environment = self.with_fake_slurm()

        def run(*command, element=None, status=0):
            if element is not None:
                environment["SLURM_ARRAY_TASK_ID"] = str(element)
            done = subprocess.run(command, env=environment, capture_output=True, text=True)
            self.assertEqual(done.returncode, status, done.stderr)

        run(*self.command("--farm", "slurm", "--farm-task-seconds", "0.0001"))
        part = (batch_test.PROGRAM, "farm-part", "--out", self.out)
        merge = (batch_test.PROGRAM, "farm-merge", "--out", self.out)
        run(*part, element=0), run(*part, element=0), run(*part, element=2)
        run(*merge)  # element 1 is missing and submitted again
        with open(self.path("submitted"), encoding="utf-8") as file:
            arrays = [line.split()[1] for line in file if "--array" in line]
        self.assertEqual(arrays, ["--array=0-2", "--array=1"])
        run(*part, element=1), run(*merge)
        self.assertEqual(sorted(batch_test.records(self.out)), ["a", "b", "c"])
        self.assertEqual(self.journal(self.out), ["a", "b", "c"])
        self.batch(out=self.path("alone"))
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("alone")))
        self.batch("--resume")
        self.assertEqual([p.get("skipped") for p in batch_test.records(self.out).values()],
                         [True] * 3)

    def test_names_are_those_of_a_batch_and_stay_when_a_file_is_added(self):
        self.add("Box.gltf"), os.symlink("nowhere", self.path("assets", "dangling"))
        environment = dict(self.with_fake_slurm(), SLURM_ARRAY_TASK_ID="0")
        for added in ((), ("Box.glb", "x/Box.glb")):
            for name in added:
                self.add(name)
            subprocess.run(self.command("--farm", "slurm", "--resume"), env=environment, check=True,
                           capture_output=True)
            subprocess.run([batch_test.PROGRAM, "farm-part", "--out", self.out], env=environment, check=True)
            merged = subprocess.run([batch_test.PROGRAM, "farm-merge", "--out", self.out], env=environment,
                                    check=True, capture_output=True, text=True).stdout
            self.assertIn(", inputs passed over: 1", merged)
        names = ["Box", "Box.glb", "x/Box"]
        self.assertEqual(sorted(batch_test.records(self.out)), names)
        self.batch("--resume")
        self.assertEqual(sorted(n for n, p in batch_test.records(self.out).items() if p.get("skipped")), names)

    def test_a_large_picture_is_rendered_in_parts(self):
        self.add("a.gltf"), self.add("b.gltf", "broken")
        environment = self.with_fake_slurm()
        work = ["--size", "200x150", "--samples", "8", "--format", "png,exr"]
        subprocess.run(self.command(*work, "--farm", "slurm", "--farm-task-seconds", "0.004"),
                       env=environment, check=True, capture_output=True)
        groups = os.listdir(os.path.join(self.out, ".sightline", "farm", "groups"))
        self.assertGreater(len(groups), 2)
        for element in range(len(groups)):
            subprocess.run((batch_test.PROGRAM, "farm-part", "--out", self.out), check=True,
                           env=dict(environment, SLURM_ARRAY_TASK_ID=str(element)))
        self.assertEqual(batch_test.pictures(self.out), {})
        merge = subprocess.run((batch_test.PROGRAM, "farm-merge", "--out", self.out),
                               capture_output=True, text=True)
        self.assertEqual(merge.returncode, 3, merge.stderr)
        self.batch(*work, out=self.path("alone"), status=3)
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("alone")))
        self.assertEqual(os.listdir(os.path.join(self.out, ".sightline", "tiles")), [])
        self.batch(*work, "--resume", status=3)
        self.assertTrue(batch_test.records(self.out)["a"]["skipped"])


@unittest.skipUnless(shutil.which("slurmctld") and os.geteuid() == 0,
                     "Notice: no slurm-wlm, or not root")
class OnACluster(FarmTest):
    def setUp(self):
        super().setUp()
        self.cluster = tempfile.mkdtemp(prefix="sightline-slurm-")
        self.addCleanup(shutil.rmtree, self.cluster, ignore_errors=True)
        self.addCleanup(subprocess.run, [CLUSTER, "stop", self.cluster])
        subprocess.run([CLUSTER, "start", self.cluster], check=True)
        os.environ["SLURM_CONF"] = os.path.join(self.cluster, "slurm.conf")

    def tearDown(self):
        del os.environ["SLURM_CONF"]

    def running(self):
        return subprocess.run(["squeue", "-h", "-t", "R", "-n", "sightline", "-o", "%i"],
                              capture_output=True, text=True).stdout.split()

    def started(self):
        """The running elements that have opened their journals."""
        parts = os.path.join(self.out, ".sightline", "farm", "parts")
        return [element for element in self.running()
                if glob.glob(os.path.join(parts, element.split("_")[1] + ".*"))]

    def test_a_farm_makes_the_same_bits_although_an_element_is_cancelled(self):
        for name in ("a", "b", "c d"):
            self.add(name + ".gltf")
        self.batch(*PICTURES, out=self.path("alone"))
        farm = self.start(*PICTURES, "--threads", "1", "--farm", "slurm", "--wait",
                          "--farm-task-seconds", "1")
        self.wait_for(self.running)
        subprocess.run(["scancel", "-s", "KILL", self.running()[0]])
        self.assertEqual(farm.wait(250), 0)
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("alone")))
        self.assertEqual(self.journal(self.out), self.journal(self.path("alone")))

    def kill_node(self, node):
        """Simulates a power cut: kills the node's daemon and all of its processes."""
        with open(os.path.join(self.cluster, f"slurmd-{node}.pid"), encoding="ascii") as file:
            victims = [int(file.read())]
        for process in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{process}/environ", "rb") as file:
                    if f"SLURMD_NODENAME={node}".encode() in file.read().split(b"\0"):
                        victims.append(int(process))
                with open(f"/proc/{process}/cmdline", "rb") as file:
                    if file.read().startswith(b"slurmstepd") and batch_test.children(int(process)):
                        victims += [int(process)] if self.runs_on(int(process), node) else []
            except OSError:
                pass  # the process has ended
        for victim in victims:
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                pass

    def runs_on(self, stepd, node):
        for child in batch_test.children(stepd):
            with open(f"/proc/{child}/environ", "rb") as file:
                if f"SLURMD_NODENAME={node}".encode() in file.read().split(b"\0"):
                    return True
        return False

    @unittest.skipUnless(os.environ.get("CI") or os.environ.get("SIGHTLINE_SLOW"),
                         "Notice: takes two minutes; set SIGHTLINE_SLOW=1")
    def test_another_node_takes_over_from_a_killed_one(self):
        for name in ("a", "b", "c"):
            self.add(name + ".gltf")
        # Elements of some seconds; sanitizers are ten times slower.
        samples = "64" if "asan" in batch_test.PROGRAM or "fuzz" in batch_test.PROGRAM else "512"
        longer = [samples if option == "16" else option for option in PICTURES]
        self.batch(*longer, out=self.path("alone"))
        farm = self.start(*longer, "--threads", "1", "--farm", "slurm", "--wait",
                          "--farm-task-seconds", "10")
        self.wait_for(self.started)
        element = self.started()[0]
        self.kill_node(subprocess.run(["squeue", "-h", "-j", element, "-o", "%N"],
                                      capture_output=True, text=True).stdout.strip())
        self.assertEqual(farm.wait(280), 0)
        jobs = subprocess.run(["scontrol", "show", "jobs"], capture_output=True, text=True).stdout
        self.assertRegex(jobs, "Restarts=[1-9]")
        self.assertEqual(batch_test.pictures(self.out), batch_test.pictures(self.path("alone")))
        self.assertEqual(self.journal(self.out), self.journal(self.path("alone")))

    def test_a_broken_asset_ends_the_farm_with_status_3(self):
        self.add("a.gltf"), self.add("b.gltf", "broken")
        farm = self.start("--threads", "1", "--farm", "slurm", "--wait")
        self.assertEqual(farm.wait(120), 3)
        self.assertEqual(batch_test.records(self.out)["b"]["verdict"], "failed")


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
