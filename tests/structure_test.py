#!/usr/bin/env python3
"""The rules of the source tree: includes, headers, sizes, names.

ARCHITECTURE.md gives the reasons. Every rule is also applied to a small tree that breaks it.
"""
import os
import re
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# The folders of src from the lowest to the highest: each may include itself and those before it.
LEVELS = ("core", "image", "scene", "exact", "intersect", "shade", "render", "output", "lab", "batch")

# The only source file that may include a package's headers.
PACKAGE_HOME = {
    r"embree[34]/": r"src/intersect/embree/embree_api\.h",
    r"OpenImageIO/": r"src/image/oiio_module\.cpp",
    r"png\.h": r"src/image/png\.cpp",
    r"zlib\.h": r"src/image/png\.cpp",
    r"(jpeglib|jerror)\.h": r"src/image/jpeg\.cpp",
    r"OpenEXR/": r"src/output/exr\.cpp",
    r"tiny_gltf\.h": r"src/scene/gltf/parse\.cpp",
    r"draco/": r"src/scene/gltf/draco\.cpp",
    r"meshoptimizer\.h": r"src/scene/gltf/meshopt\.cpp",
    r"(tbb|oneapi)/": r"src/core/parallel\.cpp",
    r"gmp(xx)?\.h": r"src/exact/dyadic\.h",
    r"mpfr\.h": r"src/exact/dyadic\.cpp",
    r"xxhash\.h": r"src/core/hash\.cpp",
    r"hwy/": r"src/.+kernel\.cpp",
    r"CGAL/": r"tests/engines/cgal_engine\.cpp",  # never in the program
}

# The module that is loaded at run time through the interface of another header.
WITHOUT_HEADER = ("src/image/oiio_module.cpp",)

MAX_FILE_LINES = 500
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
    return [f for f in files(root, "src", "tools", "tests", "examples") if f.endswith((".cpp", ".h"))]


def read(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read()


def level(path):
    """The level of the path's folder; tools and tests are above all others. None for a new folder."""
    top, folder = path.split("/")[:2]
    if top != "src":
        return len(LEVELS)
    return LEVELS.index(folder) if folder in LEVELS else None


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
        if len(users) > 1 and package != "hwy/":  # Highway is used by each kernel
            found.append(f"{package} has {len(users)} users: {', '.join(users)}")
    return found


def long_files(root):
    found = []
    for path in files(root, "src", "tools", "tests", "examples"):
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
    """Names of the types with external linkage."""
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
    """Types that share a name: the linker keeps the inline members of one of them for both."""
    homes = {}
    for path in sources(root):
        if path.startswith("src/"):
            for name in linked_types(without_text(read(root, path))):
                homes.setdefault(name, set()).add(path)
    return [f"{name} is a type in {', '.join(sorted(paths))}"
            for name, paths in sorted(homes.items()) if len(paths) > 1]


def top_level(code):
    """Pairs of each text that ends at a ; or { outside functions and types, and the mark that ends it."""
    open_blocks, head = [], 0
    for mark in re.finditer(r"[{};]", code):
        text, kind = code[head:mark.start()].strip(), mark.group()
        if kind != "}" and all(re.match(r"(inline )?namespace \w", block) for block in open_blocks):
            yield text, kind
        if kind == "{":
            open_blocks.append(text)
        elif kind == "}" and open_blocks:
            open_blocks.pop()
        head = mark.end()


def function_name(text):
    """The function that a declaration declares or a head begins, as `name` or `Type::name`, or None."""
    plain = text
    while re.search(r"<[^<>]*>", plain):
        plain = re.sub(r"<[^<>]*>", "", plain)
    named = re.match(r"[\w\s:&*~\[\]]*?((?:\w+::)*(?:operator\s*[^\s\w(]+|~?\w+))\s*\(", plain)
    skipped = r"(using|typedef|static|static_assert|extern|friend|HWY_\w+)\b"
    if not named or re.match(skipped, plain) or re.match(TYPE, plain):
        return None
    return "::".join(named.group(1).split("::")[-2:])


def implements(source, header):
    """Whether X.h is this X.cpp's or X_kernel.cpp's header, or that of the folder X/ it lies in."""
    stem = header[:-len(".h")]
    return source in (stem + ".cpp", stem + "_kernel.cpp") or os.path.dirname(source) == stem


def strayed_definitions(root):
    """Functions of a header that a source of another name defines, and sources without a header."""
    headers, found = {}, []
    code = {path: without_text(read(root, path)) for path in sources(root)
            if path.startswith("src/") and path not in WITHOUT_HEADER}
    for path in code:
        if path.endswith(".h"):
            for name in linked_types(code[path]):
                headers.setdefault(name + "::", set()).add(path)
            for text, mark in top_level(code[path]):
                if mark == ";" and function_name(text):
                    headers.setdefault(function_name(text), set()).add(path)
    for path in code:
        if path.endswith(".h"):
            continue
        if not any(implements(path, header) for header in code if header.endswith(".h")):
            found.append(f"{path} has no header of its name")
        for text, mark in top_level(code[path]):
            name = function_name(text) if mark == "{" else None
            homes = headers.get(name and re.sub(r"::.*", "::", name), ())
            if homes and not any(implements(path, header) for header in homes):
                found.append(f"{path} defines {name} of {', '.join(sorted(homes))}")
    return found


def tests_of(root):
    """The names of all tests: Suite.Name of GoogleTest, and test_name of Python."""
    names = set()
    for path in files(root, "tests"):
        text = read(root, path)
        names.update(".".join(pair) for pair in re.findall(r"^TEST(?:_[FP])?\((\w+),\s*(\w+)\)", text, re.M))
        names.update(re.findall(r"^\s*def (test_\w+)\(", text, re.M))
    return names


def unheld_promises(root):
    """Tests that docs/safety.md names but nobody wrote, and promises in its tables without a test."""
    page, known, found, promises = "docs/safety.md", tests_of(root), [], False
    for number, line in enumerate(read(root, page).splitlines(), 1):
        named = re.findall(r"`([A-Z]\w+\.[A-Z]\w+|test_\w+)`", line)
        found += [f"{page}:{number}: there is no test {name}" for name in named if name not in known]
        promises = line.startswith("|") and (promises or line.startswith("| promise |"))
        if promises and not named and not line.startswith(("| promise |", "|--")):
            found.append(f"{page}:{number}: no test holds this promise")
    return found


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

    def test_a_header_is_implemented_in_the_source_of_its_name(self):
        self.check(strayed_definitions)

    def test_every_promise_of_safety_is_held_by_a_test(self):
        self.check(unheld_promises)

    def test_the_tree_contains_no_path_of_a_machine(self):
        self.check(machine_paths)


class EachRuleFails(unittest.TestCase):
    def findings(self, rule, files):
        """The number of findings of a rule in a tree of these files, as texts by path."""
        with tempfile.TemporaryDirectory() as root:
            for name, content in files.items():
                os.makedirs(os.path.dirname(os.path.join(root, name)), exist_ok=True)
                with open(os.path.join(root, name), "w", encoding="utf-8") as file:
                    file.write(content)
            return len(rule(root))

    def broken(self, rule, path, text):
        others = ("src/core/math.h", "src/scene/scene.h", "src/exact/rational.h")
        return self.findings(rule, {**dict.fromkeys(others, ""), path: text})

    def test_on_an_upward_include(self):
        self.assertEqual(
            1, self.broken(upward_includes, "src/core/a.cpp", '#include "scene/scene.h"\n'))

    def test_on_an_include_of_the_next_level(self):
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
        text = "#include <tiny_gltf.h>\n"
        self.assertEqual(2, self.findings(strayed_packages, {"src/scene/gltf/parse.cpp": text,
                                                             "src/scene/gltf/other.cpp": text}))

    def test_on_a_long_file(self):
        self.assertEqual(1, self.broken(long_files, "src/core/a.h", "\n" * 501))

    def test_on_a_long_function(self):
        body = "int f(int a,\n      int b) {\n" + '    g("{", \'{\'); // {\n' * 60 + "}\n"
        self.assertEqual(1, self.broken(long_functions, "src/core/a.cpp",
                                        "namespace a {\n" + body + "}\n"))

    def of_one_name(self, before):
        text = f"namespace x {{\n{before}class Part : Whole {{\n int a; }};\n}}\n"
        return self.findings(shared_type_names, {"src/scene/a.h": text, "src/scene/b.cpp": text})

    def test_on_two_types_of_one_name(self):
        self.assertEqual(1, self.of_one_name("struct Other;\n"))

    def test_but_not_on_types_of_a_file_or_within_others(self):
        self.assertEqual(0, self.of_one_name("namespace {\n"))
        self.assertEqual(0, self.of_one_name("void f() {\n"))

    def strayed(self, files):
        return self.findings(strayed_definitions, {
            name: f"namespace x {{\n{text}}}\n" for name, text in files.items()})

    def test_on_a_source_without_a_header(self):
        self.assertEqual(1, self.strayed({"src/core/a.cpp": "int f() { return 1; }\n"}))

    def test_on_a_function_or_method_of_another_header(self):
        headers = {"src/core/a.h": "std::vector<int (*)()> f(int n = 1);\nstruct A {\n    int g();\n};\n",
                   "src/core/b.h": "int h();\n"}
        for stray in ("std::vector<int (*)()> f(int n) { return {}; }\n", "int A::g() { return 1; }\n"):
            self.assertEqual(1, self.strayed({**headers, "src/core/b.cpp": stray}))
            self.assertEqual(0, self.strayed({**headers, "src/core/a.cpp": stray}))
            self.assertEqual(0, self.strayed({**headers, "src/core/a/part.cpp": stray}))

    def test_but_not_on_a_local_function_of_that_name(self):
        self.assertEqual(0, self.strayed({
            "src/core/a.h": "int f();\n", "src/core/b.h": "",
            "src/core/b.cpp": "namespace {\nint f() { return 1; }\n}\nstatic int f() { return 2; }\n"}))

    def promised(self, rows):
        page = "`test_of_text`\n\n| promise | tests |\n|---|---|\n" + rows + "\n| limit | 3 |\n"
        return self.findings(unheld_promises, {
            "docs/safety.md": page, "tests/core/a_test.cpp": "TEST_F(Suite,\n       OfC) {\n}\n",
            "tests/cli/a_test.py": "class A:\n    def test_of_text(self):\n"})

    def test_on_a_promise_without_a_test_that_exists(self):
        self.assertEqual(0, self.promised("| a | `Suite.OfC` |\n| b | `Suite.OfC`, `test_of_text` |\n"))
        self.assertEqual(1, self.promised("| a | `Suite.OfD` |\n"))
        self.assertEqual(1, self.promised("| a | `Suite.OfC`, `test_of_texts` |\n"))
        self.assertEqual(1, self.promised("| a | `Suite.OfC` |\n| b | none |\n"))

    def test_on_a_machine_path(self):
        path = "/".join(["", "home", "me", "x"])
        self.assertEqual(1, self.broken(machine_paths, "docs/a.md", f"see {path}\n"))


if __name__ == "__main__":
    unittest.main()
