#!/usr/bin/env python3
"""`sightline render` makes films of turntables and animations by the ffmpeg program.

films_test.py PROGRAM [unittest's arguments]

Where ffmpeg is not installed, only what needs none of it is tested.
"""
import base64
import json
import os
import shutil
import signal
import struct
import subprocess
import sys
import unittest

import batch_test

FFMPEG = shutil.which("ffmpeg")
SMALL = ["--size", "32x24", "--samples", "1"]
ENDINGS = ["mp4", "webm", "gif", "webp"]
ENCODERS = " V..... libx264 \n V..... libvpx-vp9 \n V..... gif \n V..... libwebp_anim \n"


def moving_triangle():
    """A triangle that moves by one unit in one second."""
    asset = batch_test.triangle()
    data = base64.b64decode(asset["buffers"][0]["uri"].partition(",")[2])
    data += struct.pack("<8f", 0, 1, 0, 0, 0, 1, 0, 0)
    asset["buffers"][0] = {"byteLength": len(data), "uri": "data:application/octet-stream;base64,"
                           + base64.b64encode(data).decode()}
    asset["bufferViews"].append({"buffer": 0, "byteOffset": 36, "byteLength": 32})
    asset["accessors"] += [{"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR",
                            "min": [0], "max": [1]},
                           {"bufferView": 1, "byteOffset": 8, "componentType": 5126, "count": 2,
                            "type": "VEC3"}]
    asset["animations"] = [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                            "samplers": [{"input": 1, "output": 2}]}]
    asset["materials"] = [{"doubleSided": True}]
    asset["meshes"][0]["primitives"][0]["material"] = 0
    return asset


def ffprobe(path, field):
    """A field of the film's only stream; its frames are decoded to be counted."""
    done = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=" + field,
                           "-of", "csv=p=0", path], capture_output=True, text=True, check=True)
    return done.stdout.strip().strip(",")


def damage(path):
    """Changes one byte in the middle of the file."""
    with open(path, "r+b") as file:
        file.seek(os.path.getsize(path) // 2)
        byte = file.read(1)[0]
        file.seek(-1, os.SEEK_CUR)
        file.write(bytes([byte ^ 0x55]))


def webp_chunks(data):
    """The chunks of a WebP file: name and content."""
    at = 12
    while at < len(data):
        size = struct.unpack("<I", data[at + 4:at + 8])[0]
        yield data[at:at + 4], data[at + 8:at + 8 + size]
        at += 8 + size + size % 2


class FilmTest(batch_test.BatchTest):
    def setUp(self):
        super().setUp()
        self.scene = self.add("a.gltf", moving_triangle())
        self.work = self.path("work")
        os.makedirs(self.work)

    def render(self, *arguments, status=0, path=None):
        """Stderr of a render in the folder `work`, with `path` as the only place of programs."""
        environment = dict(os.environ, **({"PATH": path} if path is not None else {}))
        done = subprocess.run([batch_test.PROGRAM, "render", self.scene, *arguments], cwd=self.work,
                              capture_output=True, text=True, timeout=250, env=environment)
        self.assertEqual(done.returncode, status, done.stderr)
        self.stdout = done.stdout
        return done.stderr

    def fake_ffmpeg(self, script):
        """A folder with a program of that name: a shell script, after it has listed encoders."""
        folder = self.path("bin")
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "ffmpeg"), "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\ncase "$*" in *-encoders*) printf "{ENCODERS}"; exit 0;; esac\n{script}\n')
        os.chmod(os.path.join(folder, "ffmpeg"), 0o755)
        return folder + ":/usr/bin:/bin"

    def files(self):
        return sorted(os.path.relpath(os.path.join(path, name), self.work)
                      for path, _, names in os.walk(self.work) for name in names)

    def read(self, name):
        with open(os.path.join(self.work, name), "rb") as file:
            return file.read()


class Refusals(FilmTest):
    """Before anything is rendered, in one line, without ffmpeg."""

    LONG = ["--size", "1024x1024", "--samples", "100000"]

    def refused(self, *arguments, status=2, path="/nonexistent"):
        message = self.render(*arguments, *([] if "--size" in arguments else self.LONG), status=status,
                              path=path)
        self.assertEqual(message.count("\n"), 1, message)
        self.assertEqual(self.files(), [])
        self.assertEqual(os.listdir(self.work), [])
        return message

    def test_a_film_needs_the_program(self):
        message = self.refused("-o", "a.mp4", "--turntable", "9", status=1)
        self.assertIn("apt install ffmpeg", message)

    def test_a_film_needs_an_encoder_that_the_program_has(self):
        path = self.fake_ffmpeg("exit 1").replace("libx264", "")
        script = os.path.join(self.path("bin"), "ffmpeg")
        with open(script, encoding="utf-8") as file:
            text = file.read()
        with open(script, "w", encoding="utf-8") as file:
            file.write(text.replace("libx264", "libx265"))
        message = self.refused("-o", "a.mp4", "--turntable", "9", status=1, path=path)
        self.assertIn("a.mp4: this ffmpeg cannot write H.264", message)

    def test_a_film_needs_several_frames(self):
        for name in ("a.mp4", "a.webm", "a.gif"):
            self.assertIn("needs --turntable N or --frames FIRST..LAST", self.refused("-o", name))

    def test_h264_needs_even_sizes(self):
        message = self.refused("-o", "a.mp4", "--turntable", "9", "--size", "1023x512")
        self.assertIn("use 1024x512", message)
        message = self.refused("-o", "a.mp4", "--turntable", "9", "--size", "1024", "--crop", "0,0,4,3")
        self.assertIn("have 4x3; use 4x4", message)

    def test_h264_has_no_transparency(self):
        message = self.refused("-o", "a.mp4", "--turntable", "9", "--background", "transparent")
        self.assertIn("cannot hold transparency; use .webm, .webp or .gif", message)

    def test_a_film_has_one_name_for_all_its_frames_and_one_for_each_view(self):
        self.assertIn("leave {frame} out", self.refused("-o", "a_{frame}.mp4", "--turntable", "9"))
        self.assertIn("as in 'a_{view}.mp4'",
                      self.refused("-o", "a.mp4", "--turntable", "9", "--views", "front,top"))
        self.assertIn("given as output twice",
                      self.refused("-o", "a.mp4", "-o", "./a.mp4", "--turntable", "9"))

    def test_gif_has_a_highest_rate(self):
        self.assertIn("at most 50 frames per second",
                      self.refused("-o", "a.gif", "--turntable", "9", "--fps", "60"))

    def test_a_film_needs_its_folder(self):
        message = self.refused("-o", "no/a.mp4", "--turntable", "9", status=1,
                               path=self.fake_ffmpeg("exit 1"))
        self.assertIn("the folder no does not exist", message)

    def test_resume_is_for_films_alone(self):
        self.assertIn("--resume continues one picture, or films alone",
                      self.refused("-o", "a.mp4", "-o", "{frame}.png", "--turntable", "9", "--resume"))


class Faults(FilmTest):
    """Of ffmpeg, which is a script here."""

    def test_a_full_disk_leaves_no_film_and_keeps_the_frames(self):
        with open(os.path.join(self.work, "a.mp4"), "w", encoding="utf-8") as file:
            file.write("an earlier film")
        path = self.fake_ffmpeg('for last; do :; done; echo half > "${last#file:}"; cat > /dev/null\n'
                                'echo first >&2; echo "av_write: No space left on device" >&2; exit 1')
        message = self.render("-o", "a.mp4", "--turntable", "3", *SMALL, "--quiet", status=1, path=path)
        self.assertEqual(message, "sightline: a.mp4: ffmpeg ended with exit status 1: av_write: No space left "
                                  "on device; 3 of 3 frames are kept in a.mp4.frames; --resume continues from "
                                  "them\n")
        self.assertEqual(self.read("a.mp4"), b"an earlier film")
        self.assertEqual(len(os.listdir(os.path.join(self.work, "a.mp4.frames"))), 3)

    def test_a_crash_is_told(self):
        path = self.fake_ffmpeg("kill -SEGV $$")
        message = self.render("-o", "a.mp4", "--turntable", "3", *SMALL, "--quiet", status=1, path=path)
        self.assertIn("a.mp4: ffmpeg ended with signal 11", message)

    def test_an_interrupt_ends_the_program_and_keeps_the_frames(self):
        path = self.fake_ffmpeg('echo $$ > "$(dirname "$0")/pid"; exec sleep 100')
        process = subprocess.Popen([batch_test.PROGRAM, "render", self.scene, "-o", "a.mp4", "--turntable", "3",
                                    *SMALL, "--quiet"], cwd=self.work, stderr=subprocess.PIPE, text=True,
                                   env=dict(os.environ, PATH=path))
        self.addCleanup(process.kill)
        self.wait_for(lambda: os.path.exists(self.path("bin", "pid")))
        process.send_signal(signal.SIGINT)
        message = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 1, message)
        self.assertEqual(message, f"sightline: {self.scene}: interrupted; 3 of 3 frames are kept in a.mp4.frames; "
                                  "--resume continues from them\n")
        self.assertEqual(len(self.files()), 3, self.files())
        with open(self.path("bin", "pid"), encoding="utf-8") as file:
            self.assertFalse(batch_test.is_running(int(file.read())))


@unittest.skipUnless(FFMPEG, "ffmpeg is not installed")
class Films(FilmTest):
    def count_frames(self, name):
        if name.endswith(".webp"):
            return sum(kind == b"ANMF" for kind, _ in webp_chunks(self.read(name)))
        return int(ffprobe(os.path.join(self.work, name), "nb_read_frames"))

    def first_pixel(self, name):
        """Red, green, blue and alpha of the first pixel of the first frame."""
        decoder = ["-c:v", "libvpx-vp9"] if name.endswith(".webm") else []
        done = subprocess.run([FFMPEG, "-v", "error", *decoder, "-i", os.path.join(self.work, name), "-frames:v",
                               "1", "-pix_fmt", "rgba", "-f", "rawvideo", "-"], capture_output=True, check=True)
        return tuple(done.stdout[:4])

    def test_a_turntable_is_one_film_in_each_format(self):
        outputs = [word for ending in ENDINGS for word in ("-o", "a." + ending)]
        message = self.render(*outputs, "--turntable", "5@20", "--fps", "10", *SMALL)
        self.assertEqual(self.files(), sorted("a." + ending for ending in ENDINGS))
        self.assertEqual(os.listdir(self.work), os.listdir(self.work))
        self.assertEqual(self.stdout, "".join(f"a.{ending}\n" for ending in ENDINGS))
        self.assertRegex(message, r"\n5 frames, 0.50 s of film; ")
        for ending in ENDINGS:
            self.assertEqual(self.count_frames("a." + ending), 5, ending)
        self.assertEqual(ffprobe(os.path.join(self.work, "a.mp4"), "width,height,pix_fmt,r_frame_rate"),
                         "32,24,yuv420p,10/1")

    def test_the_same_command_makes_the_same_bytes(self):
        for ending in ENDINGS:
            found = []
            for threads in ("1", "2", "2"):
                self.render("-o", "a." + ending, "--turntable", "3", *SMALL, "--threads", threads)
                found.append(self.read("a." + ending))
            self.assertEqual(found[0], found[1], ending)
            self.assertEqual(found[1], found[2], ending)

    def test_frames_of_an_animation_are_a_film_and_pictures(self):
        self.render("-o", "a.gif", "-o", "{frame:02}.png", "--frames", "0..3", "--fps", "4", *SMALL)
        self.assertEqual(self.files(), ["00.png", "01.png", "02.png", "03.png", "a.gif"])
        self.assertEqual(self.count_frames("a.gif"), 4)
        self.assertEqual(len({self.read(f"0{i}.png") for i in range(4)}), 4)
        self.render("-o", "alone.png", "--time", "0.5", "--frame-for", "0..3@4", *SMALL)
        self.assertEqual(self.read("alone.png"), self.read("02.png"))

    def test_each_view_has_a_film(self):
        self.render("-o", "{view}.webp", "--frames", "0..2", "--views", "front,back", *SMALL)
        self.assertEqual(self.files(), ["back.webp", "front.webp"])
        self.assertNotEqual(self.read("back.webp"), self.read("front.webp"))
        front = self.read("front.webp")
        self.render("-o", "alone.webp", "--frames", "0..2", "--camera", "front", *SMALL)
        self.assertEqual(self.read("alone.webp"), front)

    def test_a_webp_of_each_frame_is_a_picture(self):
        self.render("-o", "{frame}.webp", "--turntable", "2", *SMALL, path="/nonexistent")
        self.assertEqual(self.files(), ["0.webp", "1.webp"])

    def test_odd_sizes_and_transparency_are_kept_where_the_format_has_them(self):
        for ending in ("webm", "gif", "webp"):
            name = "a." + ending
            self.render("-o", name, "--turntable", "3", "--size", "33x21", "--samples", "1", "--background",
                        "transparent")
            if ending == "webp":
                header = next(data for kind, data in webp_chunks(self.read(name)) if kind == b"VP8X")
                self.assertTrue(header[0] & 0x10, "no alpha")
                self.assertEqual(struct.unpack("<HBHB", header[4:])[::2], (32, 20))
                continue
            self.assertEqual(ffprobe(os.path.join(self.work, name), "width,height"), "33,21")
            self.assertEqual(self.first_pixel(name)[3], 0, name)
            self.render("-o", name, "--turntable", "3", "--size", "33x21", "--samples", "1")
            self.assertEqual(self.first_pixel(name)[3], 255, name)

    def test_colours_are_those_of_the_pictures(self):
        for ending in ("mp4", "webm", "gif"):
            self.render("-o", "a." + ending, "--turntable", "2", "--background", "#C04020", *SMALL)
            for found, expected in zip(self.first_pixel("a." + ending), (0xC0, 0x40, 0x20)):
                # Luma and chroma of 8 bits hold a colour to within two code values.
                self.assertAlmostEqual(found, expected, delta=2, msg=ending)

    def test_names_may_hold_what_ffmpeg_takes_for_patterns(self):
        for name in ("a%03d.mp4", "a:b.gif", "-a.webp", "a b's.webm"):
            self.render("--output=" + name, "--turntable", "2", *SMALL)
            self.assertEqual(self.files(), [name])
            os.remove(os.path.join(self.work, name))

    def test_resume_makes_the_same_film_after_a_kill(self):
        command = ["-o", "a.mp4", "--turntable", "12", "--size", "128", "--samples", "64"]
        self.render(*command)
        whole = self.read("a.mp4")
        os.remove(os.path.join(self.work, "a.mp4"))
        for send in (signal.SIGKILL, signal.SIGINT):
            process = subprocess.Popen([batch_test.PROGRAM, "render", self.scene, *command, "--quiet"],
                                       cwd=self.work, stderr=subprocess.PIPE, text=True)
            self.addCleanup(process.kill)
            self.wait_for(lambda: len(self.files()) >= 2)
            process.send_signal(send)
            message = process.communicate(timeout=60)[1]
            self.assertNotEqual(process.returncode, 0)
            if send == signal.SIGINT:
                self.assertRegex(message, r"interrupted; \d+ of 12 frames are kept in a.mp4.frames; --resume")
            self.assertTrue(all(name.startswith("a.mp4.frames/") for name in self.files()), self.files())
            kept = self.files()
            self.render(*command, "--resume")
            self.assertEqual(self.files(), ["a.mp4"], kept)
            self.assertEqual(self.read("a.mp4"), whole)
            os.remove(os.path.join(self.work, "a.mp4"))

    def keep_frames(self, *arguments):
        """Lets ffmpeg fail after all frames; then the kept frames are all the first."""
        self.render(*arguments, "--quiet", status=1, path=self.fake_ffmpeg("exit 1"))
        folder = os.path.join(self.work, "a.gif.frames")
        names = sorted(os.listdir(folder))
        for name in names[1:]:
            shutil.copyfile(os.path.join(folder, names[0]), os.path.join(folder, name))

    def test_resume_uses_kept_frames_of_this_film_alone(self):
        command = ["-o", "a.gif", "--turntable", "4@30", *SMALL]
        self.render(*command)
        whole = self.read("a.gif")
        # Another film, of which the frames are alike: what was kept was used.
        self.keep_frames(*command)
        self.render(*command, "--resume")
        self.assertNotEqual(self.read("a.gif"), whole)
        self.assertEqual(self.files(), ["a.gif"])
        # Other options, another file, or no --resume: it was not.
        for change in (["--seed", "1"], []):
            self.keep_frames(*command)
            self.render(*command, *change, *(["--resume"] if change else []))
            found = self.read("a.gif")
            self.render(*command, *change)
            self.assertEqual(self.read("a.gif"), found)
        self.keep_frames(*command)
        asset = moving_triangle()
        asset["nodes"][0]["scale"] = [2, 1, 1]
        self.add("a.gltf", asset)
        self.render(*command, "--resume")
        found = self.read("a.gif")
        self.render(*command)
        self.assertEqual(self.read("a.gif"), found)

    def test_damaged_frames_are_rendered_again(self):
        command = ["-o", "a.gif", "--turntable", "4", *SMALL]
        self.render(*command)
        whole = self.read("a.gif")
        self.render(*command, "--quiet", status=1, path=self.fake_ffmpeg("exit 1"))
        folder = os.path.join(self.work, "a.gif.frames")
        names = sorted(os.listdir(folder))
        os.truncate(os.path.join(folder, names[0]), 0)
        damage(os.path.join(folder, names[1]))
        with open(os.path.join(folder, names[2]), "w", encoding="utf-8") as file:
            file.write("no picture")
        message = self.render(*command, "--resume", "--quiet")
        lines = message.splitlines()
        self.assertEqual(len(lines), 3, message)
        for name, line in zip(names, lines):
            self.assertRegex(line, rf"^note: a\.gif\.frames/{name}: .*: this kept frame is damaged and is rendered again$")
        self.assertEqual(self.read("a.gif"), whole)
        self.assertEqual(self.files(), ["a.gif"])


@unittest.skipUnless(FFMPEG, "ffmpeg is not installed")
class BatchFilms(FilmTest):
    def test_films_are_those_of_render(self):
        self.add("b/c.gltf", moving_triangle())
        self.batch("--frames", "0..3", "--fps", "4", "--format", "gif,mp4", "--views", "front,30/20")
        self.assertEqual(sorted(batch_test.pictures(self.out)),
                         sorted(f"{asset}_{view}.{ending}" for asset in ("a", "b/c")
                                for view in ("front", "az030_el20") for ending in ("gif", "mp4")))
        self.render("-o", "a.gif", "-o", "a.mp4", "--frames", "0..3", "--fps", "4", "--camera", "30/20",
                    *batch_test.QUICK)
        for ending in ("gif", "mp4"):
            self.assertEqual(batch_test.pictures(self.out)["a_az030_el20." + ending], self.read("a." + ending))
        record = batch_test.records(self.out)["a_front"]
        self.assertEqual(record["verdict"], "ok")
        self.assertFalse(os.path.exists(os.path.join(self.out, ".sightline", "frames", "a_front.frames")))
        self.batch("--resume", "--frames", "0..3", "--fps", "4", "--format", "gif,mp4", "--views", "front,30/20")
        self.assertTrue(all(r.get("skipped") for r in batch_test.records(self.out).values()))

    def test_a_turntable_has_a_view_of_its_own(self):
        self.batch("--turntable", "3@20", "--format", "webm")
        self.render("-o", "a.webm", "--turntable", "3@20", *batch_test.QUICK)
        self.assertEqual(batch_test.pictures(self.out), {"a.webm": self.read("a.webm")})

    def test_what_ffmpeg_cannot_write_fails_one_film_and_keeps_its_frames(self):
        arguments = ["--turntable", "3", "--format", "mp4"]
        done = subprocess.run(self.command(*arguments), capture_output=True, text=True, cwd=self.folder, timeout=250,
                              env=dict(os.environ, PATH=self.fake_ffmpeg("echo no space >&2; exit 1")))
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertRegex(done.stderr, r"failed: a: .*ffmpeg ended with exit status 1: no space")
        self.assertEqual(batch_test.pictures(self.out), {})
        kept = os.path.join(self.out, ".sightline", "frames", "a.frames")
        self.assertEqual(len(os.listdir(kept)), 3)
        self.batch("--resume", *arguments)
        self.assertEqual(list(batch_test.pictures(self.out)), ["a.mp4"])
        self.assertFalse(os.path.exists(kept))

    def test_damaged_frames_are_rendered_again(self):
        arguments = ["--turntable", "3", "--format", "gif"]
        self.batch(*arguments)
        whole = batch_test.pictures(self.out)
        shutil.rmtree(self.out)
        subprocess.run(self.command(*arguments), capture_output=True, cwd=self.folder, timeout=250, check=False,
                       env=dict(os.environ, PATH=self.fake_ffmpeg("exit 1")))
        kept = os.path.join(self.out, ".sightline", "frames", "a.frames")
        damage(os.path.join(kept, sorted(os.listdir(kept))[1]))
        self.batch("--resume", *arguments)
        self.assertEqual(batch_test.pictures(self.out), whole)
        record = batch_test.records(self.out)["a"]
        self.assertEqual(record["verdict"], "ok")
        self.assertRegex("\n".join(record["warnings"]), r"000001-\w+\.png: .*: this kept frame is damaged and is rendered")

    def test_a_webp_is_a_film_where_all_frames_have_one_name(self):
        self.batch("--turntable", "3@20", "--format", "webp", "--name", "{asset}")
        self.render("-o", "a.webp", "--turntable", "3@20", *batch_test.QUICK)
        self.assertEqual(batch_test.pictures(self.out), {"a.webp": self.read("a.webp")})
        shutil.rmtree(self.out)
        self.batch("--turntable", "2", "--format", "webp")
        self.assertEqual(sorted(batch_test.pictures(self.out)), ["a_0000.webp", "a_0001.webp"])

    def test_what_cannot_be_is_refused_before_anything_is_rendered(self):
        for arguments, reason in ((["--format", "mp4"], "a film needs --turntable N"),
                                  (["--format", "mp4,png", "--turntable", "3"], "two runs"),
                                  (["--format", "mp4", "--turntable", "3", "--size", "25x24"], "use 26x24"),
                                  (["--format", "mp4", "--turntable", "3", "--background", "transparent"],
                                   "cannot hold transparency")):
            self.assertIn(reason, self.batch(*arguments, status=2))
        self.assertFalse(os.path.exists(self.out))


if __name__ == "__main__":
    batch_test.PROGRAM = os.path.abspath(sys.argv.pop(1))
    if not FFMPEG:
        print("ffmpeg is not installed: films are not made in this test.")
    unittest.main()
