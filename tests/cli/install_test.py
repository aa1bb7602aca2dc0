#!/usr/bin/env python3
"""The installed files: the program with its module, the manual page, the shells' completions.

install_test.py PROGRAM BUILD-FOLDER [unittest's arguments]
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM = BUILD = None
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def run(*command, **how):
    return subprocess.run(command, capture_output=True, text=True, check=True, **how).stdout


def help_of(*command):
    return run(PROGRAM, *command, "--help")


def commands():
    return re.findall(r"^  (\w+)  ", help_of().partition("Subcommands:")[2], re.M)


def options(command):
    names = []
    for line in help_of(command).splitlines():
        if match := re.match(r"  (-\S+)", line):
            names += match.group(1).split(",")
    return names


class Manual(unittest.TestCase):
    def test_lists_every_option_of_every_command(self):
        text = run(PROGRAM, "manual", "man").replace("\\-", "-")
        for command in commands():
            section = text.partition(f".SS sightline {command}\n")[2].partition(".SS")[0]
            for name in filter(lambda n: n.startswith("--"), options(command)):
                self.assertRegex(section, re.escape(name) + r"(?![\w-])", command)

    @unittest.skipUnless(shutil.which("groff"), "Notice: no groff")
    def test_groff_formats_it_without_a_warning(self):
        done = subprocess.run(["groff", "-Kutf8", "-Tutf8", "-man", "-ww", "-z"], text=True, capture_output=True,
                              input=run(PROGRAM, "manual", "man"))
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class Bash(unittest.TestCase):
    """Completes in a real bash."""

    def completions(self, *words, folder=None):
        # Bash splits a line at =, too.
        line = [part for word in words for part in re.split("(=)", word)]
        script = ("source /dev/stdin; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); _sightline; "
                  "printf '%s\\n' \"${COMPREPLY[@]}\"")
        return run("bash", "-c", script, "bash", *line, cwd=folder,
                   input=run(PROGRAM, "manual", "bash")).split("\n")[:-1]

    def test_completes_the_commands(self):
        self.assertEqual(set(commands()) | {"--help", "--version"}, set(self.completions("sightline", "")))
        self.assertEqual(["batch"], self.completions("sightline", "ba"))

    def test_completes_exactly_the_options_of_a_command(self):
        for command in commands():
            self.assertEqual(sorted(options(command)), sorted(self.completions("sightline", command, "-")))

    def test_completes_the_choices_of_an_option(self):
        words = ["pbr-neutral", "aces", "agx", "none"]
        self.assertEqual(words, self.completions("sightline", "render", "--tone-map", ""))
        self.assertEqual(words, self.completions("sightline", "render", "--tone-map="))
        self.assertEqual(["aces", "agx"], self.completions("sightline", "render", "--tone-map=a"))

    def test_completes_files_as_arguments_and_values(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "two words.glb"), "w", encoding="utf-8"):
                pass
            for before in ((), ("-o",), ("--quiet",)):
                self.assertEqual(["two words.glb"],
                                 self.completions("sightline", "render", *before, "t", folder=folder))
            self.assertEqual([""], self.completions("sightline", "render", "--size", "", folder=folder))


class Zsh(unittest.TestCase):
    def test_lists_every_option(self):
        text = run(PROGRAM, "manual", "zsh")
        for command in commands():
            section = text.partition(f"        {command})\n")[2].partition(" ;;\n")[0]
            self.assertEqual(sorted(options(command)),
                             sorted(re.findall(r"'\*(--?[\w-]+)[=+]?\[", section)))

    @unittest.skipUnless(shutil.which("zsh"), "Notice: no zsh")
    def test_zsh_parses_it(self):
        run("zsh", "-n", "/dev/stdin", input=run(PROGRAM, "manual", "zsh"))


class Installed(unittest.TestCase):
    def setUp(self):
        if not os.path.exists(os.path.join(BUILD, "manual", "sightline.1.gz")):
            self.skipTest("Notice: only part of the tree is built")
        self.folder = tempfile.mkdtemp(prefix="sightline-install-")
        self.addCleanup(shutil.rmtree, self.folder)

    def test_the_program_finds_its_module_in_any_prefix(self):
        prefix, picture = os.path.join(self.folder, "pre fix"), os.path.join(self.folder, "a.png")
        run("cmake", "--install", BUILD, "--prefix", prefix)
        run(os.path.join(prefix, "bin", "sightline"), "render", "--size", "8x8", "--quiet",
            os.path.join(ROOT, "scenes", "whitted.gltf"), "-o", picture)
        with open(picture, "rb") as file:
            self.assertEqual(b"\x89PNG", file.read(4))

    @unittest.skipUnless(shutil.which("dpkg-shlibdeps") and shutil.which("file"),
                         "Notice: no dpkg-dev or no file")
    def test_the_package_depends_on_the_libraries_of_the_module(self):
        run("cpack", "-G", "DEB", "-B", self.folder, cwd=BUILD)
        package, = [f for f in os.listdir(self.folder) if f.endswith(".deb")]
        path = os.path.join(self.folder, package)
        depends = run("dpkg-deb", "--field", path, "Depends")
        for library in ("libopenimageio", "libembree", "libtbb", "libc6"):
            self.assertIn(library, depends)
        self.assertEqual(run("dpkg-deb", "--field", path, "Recommends"),
                         "ffmpeg, python3-matplotlib\n")
        listing = run("dpkg-deb", "--contents", path)
        for name in ("bin/sightline", "lib/sightline/sightline_oiio.so", "libexec/sightline/charts",
                     "libexec/sightline/charting/looks.json",
                     "share/man/man1/sightline.1.gz",
                     "share/bash-completion/completions/sightline",
                     "share/zsh/vendor-completions/_sightline", "share/doc/sightline/copyright"):
            self.assertIn(f" ./usr/{name}\n", listing)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    BUILD = os.path.dirname(os.path.dirname(PROGRAM))
    unittest.main()
