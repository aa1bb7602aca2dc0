#!/usr/bin/env python3
"""The rules of the tree: what may include what, and how long things may be.

ARCHITECTURE.md says why. Every rule is also tried on a small tree that breaks it.
"""
import os
import re
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# A folder may include itself and folders of lower levels; two folders of one level are strangers.
LEVELS = {"core": 0, "image": 1, "scene": 2, "exact": 3, "intersect": 4, "shade": 5, "render": 6,
          "output": 7, "lab": 8, "batch": 9}
TOOLS = 10

# Which source file may include a package's headers: one for each package.
PACKAGE_HOME = {
    r"embree[34]/": r"src/intersect/embree/embree_api\.h",
    r"OpenImageIO/": r"src/image/oiio_module\.cpp",
    r"OpenEXR/": r"src/output/exr\.cpp",
    r"tiny_gltf\.h": r"src/scene/gltf/parse\.cpp",
    r"draco/": r"src/scene/gltf/draco\.cpp",
    r"meshoptimizer\.h": r"src/scene/gltf/meshopt\.cpp",
    r"(tbb|oneapi)/": r"src/core/parallel\.cpp",
    r"gmp(xx)?\.h": r"src/exact/dyadic\.h",
    r"mpfr\.h": r"src/exact/dyadic\.cpp",
    r"xxhash\.h": r"src/core/hash\.cpp",
    r"hwy/": r"src/.+kernel\.cpp",
}

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
MACHINE_PATH = re.compile(r"(?<![\w.])/(?:home|root|work|Users)/\w")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.M)
TYPE = re.compile(r"\s*(template\s*<.*>\s*)?(inline\s+)?(namespace|struct|class|enum|union)\b", re.S)
TEXT = (".cpp", ".h", ".py", ".cmake", ".txt", ".md", ".json", ".gltf", "")
SKIPPED = {".git", "build", "__pycache__"}


def files(root, *folders):
    """Paths of all text files under the given folders, relative to root, in order."""
    for folder in folders:
        for path, names, leaves in os.walk(os.path.join(root, folder)):
            names[:] = sorted(n for n in names if n not in SKIPPED)
            for leaf in sorted(leaves):
                if leaf not in SKIPPED and os.path.splitext(leaf)[1] in TEXT:
                    yield os.path.relpath(os.path.join(path, leaf), root)


def sources(root):
    return [f for f in files(root, "src", "tools", "tests") if f.endswith((".cpp", ".h"))]


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read()


def level(path):
    parts = path.split("/")
    return LEVELS.get(parts[1]) if parts[0] == "src" else TOOLS


def upward_includes(root):
    found = []
    for path in sources(root):
        if level(path) is None:
            found.append(f"{path}: its folder has no level")
            continue
        for quote, name in INCLUDE.findall(read(root, path)):
            target = os.path.join("src", name)
            if quote == "<" or not os.path.exists(os.path.join(root, target)):
                continue
            same_folder = path.split("/")[:2] == target.split("/")[:2]
            if not same_folder and (level(target) is None or level(target) >= level(path)):
                found.append(f"{path} includes {name}")
    return found


def strayed_packages(root):
    found = [f"{path} includes CLI11, which is for tools/" for path in files(root, "src")
             if any(name.startswith("CLI/") for _, name in INCLUDE.findall(read(root, path)))]
    for package, home in PACKAGE_HOME.items():
        users = [path for path in files(root, "src", "tools")
                 if path.endswith((".cpp", ".h")) and not path.startswith("tools/benchmark/")
                 and any(re.match(package, name) for _, name in INCLUDE.findall(read(root, path)))]
        found += [f"{path} includes {package}" for path in users if not re.fullmatch(home, path)]
        if len(users) > 1 and package != "hwy/":  # a way of writing kernels, not a service
            found.append(f"{package} has {len(users)} users: {', '.join(users)}")
    return found


def long_files(root):
    found = []
    for path in files(root, "src", "tools", "tests"):
        if path.endswith((".cpp", ".h", ".py")) or path.startswith("tools/"):
            count = read(root, path).count("\n")
            if count > MAX_FILE_LINES:
                found.append(f"{path} has {count} lines")
    return found


def without_text(code):
    """The code with directives, comments and literals blanked, line breaks kept."""
    pattern = (r'^[ \t]*#(?:\\\n|[^\n])*|R"(\w*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"'
               r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'")
    return re.sub(pattern, lambda m: "\n" * m.group().count("\n"), code,
                  flags=re.S | re.M)


def long_functions(root):
    found = []
    for path in sources(root):
        code, open_blocks, head = without_text(read(root, path)), [], 0
        for mark in re.finditer(r"[{};]", code):
            here = mark.start()
            if mark.group() == "{":
                open_blocks.append((head, code[head:here]))
            elif mark.group() == "}" and open_blocks:
                begin, text = open_blocks.pop()
                begin += len(text) - len(text.lstrip())
                line = code.count("\n", 0, begin) + 1
                length = code.count("\n", begin, here) + 1
                is_type = re.match(TYPE, text)
                if "(" in text and not is_type and length > MAX_FUNCTION_LINES:
                    found.append(f"{path}:{line} has a function of {length} lines")
            head = here + 1
    return found


def linked_types(code):
    """Names of the types that other files' types of that name would be mixed up with."""
    open_blocks, head = [], 0
    for mark in re.finditer(r"[{};]", code):
        if mark.group() == "{":
            text = code[head:mark.start()].strip()
            named = re.fullmatch(r"(?:struct|class|union|enum(?: class)?) (\w+)( final)?( *:[^:].*)?",
                                 text, re.S)
            if named and all(re.match(r"namespace \w", block) for block in open_blocks):
                yield named.group(1)
            open_blocks.append(text)
        elif mark.group() == "}" and open_blocks:
            open_blocks.pop()
        head = mark.end()


def shared_type_names(root):
    """Two types of one name are one to the linker, which keeps one's inline members for both."""
    homes = {}
    for path in sources(root):
        if path.startswith("src/"):
            for name in linked_types(without_text(read(root, path))):
                homes.setdefault(name, set()).add(path)
    return [f"{name} is a type in {', '.join(sorted(paths))}"
            for name, paths in sorted(homes.items()) if len(paths) > 1]


def machine_paths(root):
    found = []
    for path in files(root, "."):
        for number, text in enumerate(read(root, path).splitlines(), 1):
            if MACHINE_PATH.search(text):
                found.append(f"{path}:{number}: {text.strip()[:80]}")
    return found


class TheProject(unittest.TestCase):
    def check(self, rule):
        self.assertEqual([], rule(ROOT))

    def test_folders_depend_downwards_only(self):
        self.check(upward_includes)

    def test_a_package_is_included_by_one_source_file(self):
        self.check(strayed_packages)

    def test_files_are_short(self):
        self.check(long_files)

    def test_functions_are_short(self):
        self.check(long_functions)

    def test_types_have_names_of_their_own(self):
        self.check(shared_type_names)

    def test_no_path_of_one_machine_stands_in_the_tree(self):
        self.check(machine_paths)


class EachRuleFails(unittest.TestCase):
    def broken(self, rule, path, text):
        with tempfile.TemporaryDirectory() as root:
            for name, content in (("src/core/math.h", ""), ("src/scene/scene.h", ""),
                                  ("src/exact/rational.h", ""), (path, text)):
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                with open(os.path.join(root, name), "w", encoding="utf-8") as file:
                    file.write(content)
            return len(rule(root))

    def test_on_an_upward_include(self):
        self.assertEqual(
            1, self.broken(upward_includes, "src/core/a.cpp", '#include "scene/scene.h"\n'))

    def test_on_an_include_of_a_sibling(self):
        self.assertEqual(
            1, self.broken(upward_includes, "src/scene/a.cpp", '#include "exact/rational.h"\n'))

    def test_on_a_folder_without_a_level(self):
        self.assertEqual(1, self.broken(upward_includes, "src/misc/a.cpp", ""))

    def test_but_not_on_a_downward_include(self):
        self.assertEqual(
            0, self.broken(upward_includes, "src/scene/a.cpp", '#include "core/math.h"\n'))

    def test_on_a_package_away_from_home(self):
        self.assertEqual(
            1, self.broken(strayed_packages, "src/core/a.h", "#include <embree4/rtcore.h>\n"))

    def test_on_a_second_user_of_a_package(self):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "src/scene/gltf"))
            for name in ("parse.cpp", "other.cpp"):
                with open(os.path.join(root, "src/scene/gltf", name), "w", encoding="utf-8") as file:
                    file.write("#include <tiny_gltf.h>\n")
            self.assertEqual(2, len(strayed_packages(root)))

    def test_on_a_long_file(self):
        self.assertEqual(1, self.broken(long_files, "src/core/a.h", "\n" * 401))

    def test_on_a_long_function(self):
        body = "int f(int a,\n      int b) {\n" + '    g("{", \'{\'); // {\n' * 60 + "}\n"
        self.assertEqual(1, self.broken(long_functions, "src/core/a.cpp",
                                        "namespace a {\n" + body + "}\n"))

    def of_one_name(self, before):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, "src/scene"))
            for name in ("a.h", "b.cpp"):
                with open(os.path.join(root, "src/scene", name), "w", encoding="utf-8") as file:
                    file.write(f"namespace x {{\n{before}class Part : Whole {{\n int a; }};\n}}\n")
            return len(shared_type_names(root))

    def test_on_two_types_of_one_name(self):
        self.assertEqual(1, self.of_one_name("struct Other;\n"))

    def test_but_not_on_types_of_a_file_or_within_others(self):
        self.assertEqual(0, self.of_one_name("namespace {\n"))
        self.assertEqual(0, self.of_one_name("void f() {\n"))

    def test_on_a_machine_path(self):
        path = "/".join(["", "home", "me", "x"])
        self.assertEqual(1, self.broken(machine_paths, "docs/a.md", f"see {path}\n"))


if __name__ == "__main__":
    unittest.main()
