#!/usr/bin/env python3
"""Promises of docs/safety.md that no other test holds: no network, no file that was not named.

safety_test.py PROGRAM [unittest's arguments]
"""
import ctypes
import json
import os
import platform
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from batch_test import triangle

PROGRAM = os.path.abspath(sys.argv.pop(1))
SMALL = ["--size", "16x16", "--samples", "1", "--quiet"]
# The number of the system call `socket`, and the constant that audit.h gives the architecture.
SOCKET = {"x86_64": (41, 0xC000003E), "aarch64": (198, 0xC00000B7)}.get(platform.machine())
KILL_PROCESS, ALLOW = 0x80000000, 0x7FFF0000
LOAD, JUMP_IF_EQUAL, RETURN = 0x20, 0x15, 0x06  # of BPF
PR_SET_NO_NEW_PRIVS, PR_SET_SECCOMP, SECCOMP_MODE_FILTER = 38, 22, 2


def forbid_sockets():
    """From now on, this process and its children end by SIGSYS when they open a socket."""
    number, architecture = SOCKET
    program = [(LOAD, 0, 0, 4), (JUMP_IF_EQUAL, 0, 3, architecture), (LOAD, 0, 0, 0),
               (JUMP_IF_EQUAL, 0, 1, number), (RETURN, 0, 0, KILL_PROCESS), (RETURN, 0, 0, ALLOW)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *line) for line in program))
    head = ctypes.create_string_buffer(struct.pack("HxxxxxxP", len(program), ctypes.addressof(code)))
    libc = ctypes.CDLL(None, use_errno=True)
    for arguments in ((PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), (PR_SET_SECCOMP, SECCOMP_MODE_FILTER, head, 0, 0)):
        if libc.prctl(*arguments) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


class Safety(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="sightline-safety-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def run_program(self, *arguments, program=PROGRAM, **how):
        return subprocess.run([program, *arguments], cwd=self.folder, capture_output=True, timeout=300, check=False,
                              **how)

    def textured(self, *uris):
        asset = triangle()
        asset["images"] = [{"uri": uri} for uri in uris]
        asset["textures"] = [{"source": 0}]
        asset["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        asset["meshes"][0]["primitives"][0]["material"] = 0
        return json.dumps(asset)


@unittest.skipUnless(SOCKET, "Notice: the system call's number is not known for this machine")
class Network(Safety):
    def test_a_process_that_opens_a_socket_is_ended(self):
        done = self.run_program("-c", "import socket; socket.socket()", program=sys.executable,
                                preexec_fn=forbid_sockets)
        self.assertEqual(done.returncode, -signal.SIGSYS)

    def test_no_command_opens_a_socket(self):
        self.write("in/a.gltf", json.dumps(triangle()))
        self.write("far.gltf", self.textured("http://127.0.0.1:9/a.png"))
        self.write("share.gltf", self.textured("//127.0.0.1/share/a.png"))
        commands = [["render", "in/a.gltf", "-o", "a.png", "-o", "a.exr", "--env", "studio", *SMALL],
                    ["render", "far.gltf", "-o", "far.png", *SMALL],
                    ["render", "share.gltf", "-o", "share.png", "--allow-outside", *SMALL],
                    ["info", "far.gltf"],
                    ["diff", "a.png", "a.png"],
                    ["batch", "in", "--out", "out", "--jobs", "2", *SMALL],
                    ["compare", "in/a.gltf", "--report", "report", "--methods", "exact", *SMALL],
                    ["atlas", "--families", "S1", "--rays", "20", "--report", "atlas", "--quiet"]]
        for command in commands:
            with self.subTest(" ".join(command)):
                done = self.run_program(*command, preexec_fn=forbid_sockets)
                self.assertIn(done.returncode, (0, 1), done.stderr)
                if command[1] not in ("far.gltf", "share.gltf"):
                    self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(os.path.exists(self.path("out/a.png")))  # a worker that ended by SIGSYS writes none


class Files(Safety):
    def age(self, name):
        """Sets the time of the last access long before that of the last change: reading will update it."""
        os.utime(self.path(name), (1e9, time.time()))

    def was_read(self, name):
        return os.stat(self.path(name)).st_atime > 1e9 + 1

    def test_a_render_reads_only_what_the_asset_names(self):
        texture = ("in/texture.png", "in/neighbour.png", "outside.png", "in/sub/texture.png")
        self.write("seed.gltf", json.dumps(triangle()))
        self.run_program("render", "seed.gltf", "-o", "seed.png", *SMALL)
        for name in texture:
            os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
            shutil.copy(self.path("seed.png"), self.path(name))
        self.write("in/a.gltf", self.textured("texture.png"))
        self.write("in/a.bin", "a buffer that is not named")
        self.write("in/b.gltf", json.dumps(triangle()))
        self.write("in/.hidden", "")
        files = [*texture, "in/a.gltf", "in/a.bin", "in/b.gltf", "in/.hidden"]
        for name in files:
            self.age(name)
        done = self.run_program("render", "in/a.gltf", "-o", "a.png", *SMALL)
        self.assertEqual(done.returncode, 0, done.stderr)
        if not self.was_read("in/a.gltf"):
            self.skipTest("Notice: this file system does not record accesses")
        self.assertEqual([n for n in files if self.was_read(n)], ["in/texture.png", "in/a.gltf"])

    def test_nothing_is_written_but_the_outputs(self):
        self.write("in/a.gltf", json.dumps(triangle()))
        os.makedirs(self.path("home"))
        environment = {"PATH": os.environ["PATH"], "HOME": self.path("home"), "TMPDIR": self.path("home"),
                       "XDG_CACHE_HOME": self.path("home"), "ASAN_OPTIONS": "detect_leaks=0"}
        done = self.run_program("render", "in/a.gltf", "-o", "a.png", *SMALL, env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = self.run_program("batch", "in", "--out", "out", *SMALL, env=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = [os.path.relpath(os.path.join(path, name), self.folder)
                 for path, _, names in os.walk(self.folder) for name in names if "/out" not in path]
        self.assertEqual(sorted(found), ["a.png", "in/a.gltf"])


if __name__ == "__main__":
    unittest.main()
