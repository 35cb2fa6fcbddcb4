#!/usr/bin/env python3
"""Plants violations in a small clean tree: check.py must name each, and nothing in the clean tree."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check  # noqa: E402

SENTENCE = "// What lives in this file.\n"
HEADER = SENTENCE + "#pragma once\n"
CLEAN = {
    "CMakeLists.txt": "# A tree for the test.\nscree_engine(core)\nscree_engine(ecs NEEDS core)\n"
                      "scree_engine(platform NEEDS core LIBS glfw)\nscree_engine(gpu NEEDS core)\n"
                      "scree_engine(assets NEEDS core ecs\n  LIBS ecs_like)\nscree_engine(app NEEDS assets gpu)\n"
                      "scree_module(scene NO_SHADERS)\nscree_module(sand NEEDS scene)\nscree_module(fog)\n",
    "README.md": "# Test\n",
    "content/level.gltf": "{}\n",
    ".gitignore": "build/\n",
    "engine/core/log.h": HEADER,
    "engine/ecs/world.h": HEADER + '#include <vector>\n\n#include "engine/core/log.h"\n',
    "engine/platform/input.h": HEADER,
    "engine/gpu/gl.h": HEADER + '#include "engine/core/log.h"\n',
    "engine/assets/mesh.h": HEADER + '#include "engine/ecs/world.h"\n#include "shaders/shared/view.h"\n',
    "engine/app/app.h": HEADER + '#include "engine/gpu/gl.h"\n#include "engine/ecs/world.h"\n',
    "shaders/shared/view.h": SENTENCE + '#include "engine/core/math.h"\n',
    "engine/core/math.h": HEADER,
    "shaders/shared/brdf.h": SENTENCE + '#include "shared/view.h"\n',
    "shaders/lib/light.glsl": SENTENCE + '#include "shared/brdf.h"\n',
    "shaders/sand/sand.frag": SENTENCE + '#include "lib/light.glsl"\n#include "sand/own.glsl"\n',
    "shaders/sand/own.glsl": SENTENCE,
    "shaders/fog/fog.frag": SENTENCE,
    "modules/scene/scene.h": HEADER + '#include "engine/app/app.h"\n',
    "modules/scene/detail.h": HEADER,
    "modules/scene/scene.cpp": SENTENCE + '#include "modules/scene/detail.h"\n',
    "modules/sand/sand.h": HEADER + '#include "modules/scene/scene.h"\n#include "engine/gpu/gl.h"\n',
    "game/main.cpp": SENTENCE + '#include "modules/sand/sand.h"\n#include "engine/app/app.h"\n',
    "tests/run.sh": "#!/bin/sh\n# Runs the tests of it.\n",
    "tests/tool.py": "#!/usr/bin/env python3\n\"\"\"A tool of the tests.\"\"\"\n",
}
for module in ("scene", "sand", "fog"):
    for path in (f"modules/{module}/{module}.cpp", f"tests/{module}/unit.cpp", f"tests/{module}/gpu.cpp"):
        CLEAN.setdefault(path, SENTENCE)
    CLEAN.setdefault(f"modules/{module}/{module}.h", HEADER)
    CLEAN[f"modules/{module}/README.md"] = f"# {module}\n"


def include(target):
    return f'#include "{target}"\n'


# (rule, file, what is appended to it, or (True, whole content), or None: file removed)
PLANTED = [
    ("top", "notes.txt", (True, "hello\n")),
    ("top", "docs/a.md", (True, "# a\n")),
    ("top", "README.md", None),
    ("parts", "modules/sand/README.md", None),
    ("parts", "modules/sand/sand.h", None),
    ("parts", "tests/fog/gpu.cpp", None),
    ("parts", "tests/scene/unit.cpp", None),
    ("parts", "shaders/fog/fog.frag", None),
    ("parts", "modules/rain/rain.h", (True, HEADER)),
    ("parts", "engine/net/net.h", (True, HEADER)),
    ("parts", "shaders/rain/a.frag", (True, SENTENCE)),
    ("parts", "CMakeLists.txt", "scree_engine(net NEEDS core)\n"),
    ("parts", "CMakeLists.txt", "scree_module(scene NO_SHADERS NEEDS sand)\n"),
    ("include", "engine/core/log.h", include("engine/ecs/world.h")),
    ("include", "engine/core/log.h", '#  include  "engine/app/app.h"\n'),
    ("include", "engine/ecs/world.h", include("engine/platform/input.h")),
    ("include", "engine/platform/input.h", include("engine/gpu/gl.h")),
    ("include", "engine/gpu/gl.h", include("engine/platform/input.h")),  # lower, but CMake does not say so
    ("include", "engine/assets/mesh.h", include("engine/gpu/gl.h")),
    ("include", "engine/app/app.h", include("modules/scene/scene.h")),
    ("include", "engine/app/app.h", include("tests/scene/unit.cpp")),
    ("include", "engine/app/app.h", include("game/main.cpp")),
    ("include", "engine/app/app.h", include("app.h")),
    ("include", "engine/app/app.h", include("../gpu/gl.h")),
    ("include", "engine/app/app.h", include("engine/app/missing.h")),
    ("include", "engine/app/app.h", "#include <engine/gpu/gl.h>\n"),
    ("include", "engine/app/app.h", include("shaders/lib/light.glsl")),
    ("include", "modules/fog/fog.h", include("modules/scene/scene.h")),
    ("include", "modules/sand/sand.cpp", include("modules/scene/detail.h")),
    ("include", "modules/sand/sand.cpp", include("game/main.cpp")),
    ("include", "modules/sand/sand.cpp", include("tests/sand/unit.cpp")),
    ("include", "game/main.cpp", include("engine/gpu/gl.h")),
    ("include", "game/main.cpp", include("modules/scene/detail.h")),
    ("include", "shaders/sand/sand.frag", include("fog/fog.frag")),
    ("include", "shaders/lib/light.glsl", include("sand/own.glsl")),
    ("include", "shaders/shared/brdf.h", include("lib/light.glsl")),
    ("include", "shaders/shared/brdf.h", include("engine/gpu/gl.h")),
    ("include", "shaders/sand/own.glsl", include("shared/missing.h")),
    ("opening", "engine/gpu/gl.h", (True, "#pragma once\n// What lives in this file.\n")),
    ("opening", "modules/sand/sand.cpp", (True, "\n" + SENTENCE)),
    ("opening", "modules/sand/sand.cpp", (True, "// sand\n")),
    ("opening", "tests/tool.py", (True, "#!/usr/bin/env python3\nimport sys\n")),
    ("opening", "CMakeLists.txt", (True, CLEAN["CMakeLists.txt"].split("\n", 1)[1])),
    ("opening", "shaders/fog/fog.frag", (True, "")),
    ("text", "game/main.cpp", "// TO" "DO: later\n"),
    ("text", "README.md", "FIX" "ME\n"),
    ("text", "modules/sand/sand.cpp", "// a place" "holder\n"),
    ("text", "modules/sand/sand.cpp", "int st" "ub;\n"),
    ("text", "tests/sand/unit.cpp", "GTEST_SK" "IP();\n"),
    ("text", "README.md", "see /ho" "me/me/file\n"),
    ("text", "README.md", "line\r\n"),
    ("text", "engine/gpu/gl.h", (True, SENTENCE)),
    ("size", "modules/sand/sand.cpp", "//\n" * 401),
    ("size", "tests/sand/unit.cpp", "//\n" * 651),
    ("size", "content/big.bin", (True, "x" * (2 << 20) + "x")),
]


class Layout(unittest.TestCase):
    def plant(self, files):
        return check.faults({path: text.encode() for path, text in files.items()})

    def test_clean_tree_has_no_fault(self):
        self.assertEqual(self.plant(CLEAN), [])

    def test_every_planted_violation_is_named(self):
        for rule, path, change in PLANTED:
            files = dict(CLEAN)
            if change is None:
                del files[path]
            elif isinstance(change, tuple):
                files[path] = change[1]
            else:
                files[path] = files[path] + change
            with self.subTest(rule=rule, path=path, change=str(change)[:60]):
                found = self.plant(files)
                self.assertIn(rule, {fault[0] for fault in found})
                top = path.split("/")[0]
                self.assertTrue(any(fault[0] == rule and fault[1].startswith(top) for fault in found), found)

    def test_line_numbers(self):
        files = dict(CLEAN)
        files["engine/ecs/world.h"] += "\n" + include("engine/app/app.h")
        faults = self.plant(files)
        self.assertEqual([(f[1], f[2]) for f in faults], [("engine/ecs/world.h", 7)])

    def test_ignored_files_are_left_out(self):
        for git in (False, True) if shutil.which("git") else (False,):
            with tempfile.TemporaryDirectory() as folder:
                for path, text in {".gitignore": "build/\n", "build/a.txt": "", "new.txt": "", "x/b.txt": ""}.items():
                    target = pathlib.Path(folder) / path
                    target.parent.mkdir(exist_ok=True)
                    target.write_text(text)
                if git:
                    subprocess.run(["git", "init", "-q", folder], check=True)
                self.assertEqual(sorted(check.read_folder(folder)), [".gitignore", "new.txt", "x/b.txt"])


if __name__ == "__main__":
    unittest.main()
