#!/usr/bin/env python3
"""Keeps the tree as it is meant to be: who may include whom, which files exist, how they begin.

Usage: check.py [ROOT]; prints one line a fault, exit status 1 if there is any. Standard library only.
"""
import pathlib
import re
import subprocess
import sys

TOP_LEVEL = {"CMakeLists.txt", "engine", "modules", "shaders", "game", "tests", "content", "README.md"}
TOP_LEVEL_OPTIONAL = {"LICENSE"}
# A part of the engine includes itself and parts of lower rank.
ENGINE_RANK = {"core": 0, "ecs": 1, "platform": 1, "gpu": 2, "frame": 3, "assets": 3, "app": 4}
CPP = {".h", ".cpp"}
GLSL = {".glsl", ".vert", ".frag", ".comp", ".geom", ".tesc", ".tese"}
COMMENTED = CPP | GLSL | {".py", ".sh", ".cmake"}
MAX_LINES = 400
MAX_TEST_LINES = 650
MAX_BYTES = 2 << 20
# Joined here, so that this file does not contain them.
UNFINISHED = re.compile("|".join([r"\bTO" r"DO\b", r"\bFIX" r"ME\b", r"\bXX" r"X\b", r"\bHA" r"CK\b"]))
UNFINISHED_IN_CODE = re.compile(r"\b(st" r"ub|place" r"holder|not (?:yet )?implemen" r"ted)s?\b|GTEST_SK" r"IP\(\)\s*;", re.I)
CODE_FOLDERS = {"engine", "modules", "shaders", "game", "tests"}
MACHINE_PATH = re.compile(r"(?<![\w.$}])/(wor" r"k|home|roo" r"t|Users)/\w")
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(["<])([^">]+)[">]', re.M)
DECLARATION = re.compile(r"^\s*scree_(engine|module)\(([^)]*)\)", re.M)


class Tree:
    """The files of a repository: {path: bytes}."""

    def __init__(self, contents):
        self.files = sorted(contents)
        self.sizes = {path: len(content) for path, content in contents.items()}
        self.texts = {}
        for path, content in contents.items():
            try:
                self.texts[path] = content.decode("utf-8")
            except UnicodeDecodeError:
                pass  # a picture or a model
        self.parts = declared_parts(self.texts.get("CMakeLists.txt", ""))

    def of(self, *suffixes):
        return [path for path in self.files if pathlib.PurePath(path).suffix in suffixes and path in self.texts]

    def line(self, path, offset):
        return self.texts[path].count("\n", 0, offset) + 1


def read_folder(root):
    """Contents of the files under `root`: in a git work tree those tracked or new, but not ignored."""
    root = pathlib.Path(root)
    if (root / ".git").exists():
        listed = subprocess.run(
            ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            check=True, capture_output=True, text=True).stdout.split("\0")
        paths = [path for path in listed if path and (root / path).is_file()]
    else:
        skip = re.compile(r"^(\.git|build|build-[^/]*|captures)(/|$)|(^|/)__pycache__/")
        paths = [path for path in
                 (p.relative_to(root).as_posix() for p in root.rglob("*") if p.is_file())
                 if not skip.search(path)]
    return {path: (root / path).read_bytes() for path in paths}


def declared_parts(cmake):
    """{name: {"kind": "engine" or "module", "needs": set, "shaders": bool}} from CMakeLists.txt."""
    parts = {}
    for kind, body in DECLARATION.findall(cmake):
        words = body.split()
        part = {"kind": kind, "needs": set(), "shaders": "NO_SHADERS" not in words}
        group = None
        for word in words[1:]:
            if word in ("NEEDS", "LIBS", "NO_SHADERS"):
                group = word
            elif group == "NEEDS":
                part["needs"].add(word)
        parts[words[0]] = part
    return parts


def needed(parts, name):
    """What a part needs, directly or through others; a module needs every part of the engine."""
    found, queue = set(), [name]
    while queue:
        part = parts.get(queue.pop(), {"kind": "engine", "needs": set()})
        needs = set(part["needs"])
        if part["kind"] == "module":
            needs |= {other for other, about in parts.items() if about["kind"] == "engine"}
        queue += needs - found
        found |= needs
    return found


def check_top_level(tree):
    present = {path.split("/")[0] for path in tree.files}
    for name in sorted(TOP_LEVEL - present):
        yield name, 0, "missing at the top level"
    for name in sorted(present - TOP_LEVEL - TOP_LEVEL_OPTIONAL):
        if not name.startswith("."):
            yield name, 0, "does not belong at the top level"


def check_parts(tree):
    files = set(tree.files)
    folders = {tuple(path.split("/")[:2]) for path in tree.files if path.count("/") >= 2}
    for name, part in tree.parts.items():
        if part["kind"] == "engine":
            if name not in ENGINE_RANK:
                yield "CMakeLists.txt", 0, f"engine part '{name}' has no place in the order of parts"
            continue
        required = [f"modules/{name}/{name}.h", f"modules/{name}/{name}.cpp", f"modules/{name}/README.md",
                    f"tests/{name}/unit.cpp", f"tests/{name}/gpu.cpp"]
        for path in required:
            if path not in files:
                yield path, 0, f"module {name} must have it"
        if part["shaders"] and ("shaders", name) not in folders:
            yield f"shaders/{name}", 0, f"module {name} has no shaders: say NO_SHADERS"
        if name in needed(tree.parts, name):
            yield "CMakeLists.txt", 0, f"module {name} needs itself through others"
    for top, kind in (("engine", "engine"), ("modules", "module")):
        for folder in sorted(name for parent, name in folders if parent == top):
            if folder != "cmake" and tree.parts.get(folder, {}).get("kind") != kind:
                yield f"{top}/{folder}", 0, "not declared in CMakeLists.txt"
    for folder in sorted(name for parent, name in folders if parent == "shaders"):
        if folder not in ("shared", "lib") and tree.parts.get(folder, {}).get("kind") != "module":
            yield f"shaders/{folder}", 0, "no module has this name"


def refuse_include(tree, path, target):
    """Why the file at `path` must not include `target`, or None."""
    here, there = path.split("/"), target.split("/")
    if here[0] == "shaders":
        if there[0] == "shaders":
            there = there[1:]
        elif here[1] == "shared" and target == "engine/core/math.h":
            return None  # GLM for the C++ side, through shared/prelude.h
        allowed = {"shared": {"shared"}, "lib": {"shared", "lib"}}.get(here[1], {here[1], "lib", "shared"})
        return None if there[0] in allowed else f"shaders/{here[1]} includes only {', '.join(sorted(allowed))}"
    if here[0] == "tests" and pathlib.PurePath(path).suffix in GLSL:
        return None  # a bench's shaders use those of any module
    if there[0] not in ("engine", "modules", "game", "tests", "shaders"):
        return "includes are rooted: engine/..., modules/..., game/..., tests/..., shaders/..."
    if there[0] == "shaders" and there[1] != "shared":
        return "C++ includes only shaders/shared"
    if here[0] == "tests" or there[0] == "shaders":
        return None
    if there[0] == "tests":
        return "only tests include tests"
    if here[0] == "engine":
        if there[0] != "engine":
            return f"engine must not include {there[0]}"
        if here[1] == there[1]:
            return None
        if ENGINE_RANK.get(there[1], 99) >= ENGINE_RANK.get(here[1], -1):
            return f"engine/{here[1]} must not include engine/{there[1]}: {order_text()}"
        if there[1] not in needed(tree.parts, here[1]):
            return f"engine/{here[1]} does not need {there[1]} in CMakeLists.txt"
        return None
    if here[0] == "modules":
        if there[0] == "game":
            return "a module must not include the game"
        if there[0] == "modules" and here[1] != there[1]:
            if there[1] not in tree.parts.get(here[1], {"needs": set()})["needs"]:
                return f"module {here[1]} does not need {there[1]} in CMakeLists.txt"
            if there[2:] != [there[1] + ".h"]:
                return f"of another module only its public header: modules/{there[1]}/{there[1]}.h"
        return None
    if here[0] == "game":
        if there[:2] == ["engine", "gpu"]:
            return "the game must not include engine/gpu"
        if there[0] == "modules" and there[2:] != [there[1] + ".h"]:
            return f"of a module only its public header: modules/{there[1]}/{there[1]}.h"
    return None


def order_text():
    ranks = sorted(set(ENGINE_RANK.values()))
    names = ["|".join(n for n, r in ENGINE_RANK.items() if r == rank) for rank in ranks]
    return " <- ".join(names)


def check_includes(tree):
    files = set(tree.files)
    for path in tree.of(*CPP, *GLSL):
        for match in INCLUDE.finditer(tree.texts[path]):
            mark, target = match.groups()
            line = tree.line(path, match.start())
            if mark == "<":
                if target.split("/")[0] in TOP_LEVEL:
                    yield path, line, f"<{target}>: own headers are included in quotes"
                continue
            reason = refuse_include(tree, path, target)
            if reason is None:
                glsl = pathlib.PurePath(path).suffix in GLSL
                in_shaders = (path.startswith("shaders/") or glsl) and not target.startswith(("shaders/", "engine/"))
                resolved = f"shaders/{target}" if in_shaders else target
                reason = None if resolved in files else "no such file"
            if reason:
                yield path, line, f'"{target}": {reason}'


def check_openings(tree):
    for path in tree.files:
        name = pathlib.PurePath(path)
        if path not in tree.texts or not (name.suffix in COMMENTED or name.name == "CMakeLists.txt"):
            continue
        lines = tree.texts[path].split("\n")
        if lines[0].startswith("#!"):
            lines = lines[1:]
        first = lines[0] if lines else ""
        mark = re.match(r'//|"""|#(?!\s*(include|pragma|version|if|define))', first)
        if not mark or len(re.findall(r"\w+", first)) < 3:
            yield path, 1, "must open with a sentence that says what lives in it"


def check_texts(tree):
    for path, text in tree.texts.items():
        code = path.split("/")[0] in CODE_FOLDERS
        for pattern, what in ((UNFINISHED, "unfinished"), (UNFINISHED_IN_CODE, "unfinished"),
                              (MACHINE_PATH, "a path of one machine"), (re.compile("\r"), "a carriage return")):
            if pattern is UNFINISHED_IN_CODE and not code:
                continue
            match = pattern.search(text)
            if match:
                yield path, tree.line(path, match.start()), f"{what}: {match.group(0)!r}"
    for path in tree.of(".h"):
        repeated = "ncluded several times" in tree.texts[path][:500]
        if not path.startswith("shaders/") and not repeated and "#pragma once" not in tree.texts[path]:
            yield path, 1, "a header needs #pragma once"


def check_sizes(tree):
    for path in tree.files:
        size = tree.sizes[path]
        if size > MAX_BYTES:
            yield path, 0, f"{size} bytes, at most {MAX_BYTES}"
    for path in tree.of(*CPP, *GLSL, ".py", ".sh", ".cmake"):
        limit = MAX_TEST_LINES if path.startswith("tests/") else MAX_LINES
        lines = tree.texts[path].count("\n")
        if lines > limit:
            yield path, limit, f"{lines} lines, at most {limit}: give each purpose its own file"


CHECKS = {"top": check_top_level, "parts": check_parts, "include": check_includes, "opening": check_openings,
          "text": check_texts, "size": check_sizes}


def faults(contents):
    """[(rule, path, line, message)] of a tree {path: bytes}; line 0: the file as a whole."""
    tree = Tree(contents)
    return [(rule, *fault) for rule, check in CHECKS.items() for fault in check(tree)]


def main(arguments):
    root = arguments[0] if arguments else pathlib.Path(__file__).resolve().parents[2]
    found = faults(read_folder(root))
    for rule, path, line, message in found:
        print(f"{path}:{line}: [{rule}] {message}")
    print(f"{len(found)} faults", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
