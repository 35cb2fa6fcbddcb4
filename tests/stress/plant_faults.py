#!/usr/bin/env python3
"""Plants one-line faults, one at a time, in a copy of the sources and reports which tests catch them.

Usage: plant_faults.py --build DIR [--code] [--only TEXT] [--json FILE] [--rerun N]
  --build DIR   a complete build with tests; shader faults run its programs on a changed copy of the
                shaders (SCREE_SHADERS)
  --code        also the faults in C++ and in rules that both sides share; each needs a rebuild of
                what it touches, in a copy of the source tree: hours on two cores
  --only TEXT   only faults whose file or description contains TEXT
  --rerun N     first run the tests N times unchanged: an alarm without a fault is a failure (default 1)
Exit status: 0 if at least 95 % are caught and there was no false alarm, 1 if not, 2 for bad usage or
a fault whose text is no longer in its file.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
import faults  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
TESTS = re.compile(r"^(deferred|grains|occlusion|overlay|scene|shadows|frame|gpu|game)\.")
NEEDED_SHARE = 0.95
MIN_TIMEOUT_S = 120


def find_tests(build):
    """{name: command} of the tests that draw, without the slow tier, as CTest lists them."""
    listed = json.loads(subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, check=True,
                                       capture_output=True, text=True).stdout)
    found = {}
    for test in listed["tests"]:
        labels = [p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"]
        if TESTS.match(test["name"]) and not any("stress" in label for label in labels):
            found[test["name"]] = test["command"]
    return found


def run_test(command, environment, folder, timeout_s):
    """'' if it passes, else how it failed."""
    try:
        done = subprocess.run(command, cwd=folder, env={**os.environ, **environment}, timeout=timeout_s,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    except subprocess.TimeoutExpired:
        return "hung"
    if done.returncode == 0:
        return ""
    failed = re.findall(rb"^\[  FAILED  \] (\S+)", done.stdout, re.M)
    return failed[0].decode().rstrip(",") if failed else f"exit status {done.returncode}"


def ordered(tests, durations, path):
    """The part's own tests first, then the quick ones."""
    part = path.split("/")[1]
    return sorted(tests, key=lambda name: (not name.startswith(part + "."), durations[name]))


def stale(planted):
    return [(path, text) for path, text, _, _ in planted if text not in (ROOT / path).read_text()]


def change(tree, path, text, instead):
    """Applies one fault to the first place of its text; returns the original."""
    target = tree / path
    original = target.read_text()
    target.write_text(original.replace(text, instead, 1))
    return original


class Campaign:
    def __init__(self, build, work, rerun):
        self.build, self.work = pathlib.Path(build).resolve(), pathlib.Path(work)
        self.tests = find_tests(self.build)
        self.durations, self.false_alarms, self.rows = {}, [], []
        self.environment = {"SCREE_FAILURES": str(self.work / "failures")}
        self.environment["SCREE_SHADERS"] = str(self.work / "shaders")
        shutil.copytree(ROOT / "shaders", self.work / "shaders")
        for _ in range(rerun):
            self.baseline()

    def baseline(self):
        for name, command in self.tests.items():
            start = time.monotonic()
            alarm = run_test(command, self.environment, self.build, 3600)
            self.durations[name] = time.monotonic() - start
            print(f"{name}: {alarm or 'passes'} in {self.durations[name]:.1f} s", flush=True)
            if alarm:
                self.false_alarms.append((name, alarm))
        for name, _ in self.false_alarms:
            self.tests.pop(name, None)  # it would catch everything

    def first_alarm(self, path, tests, build, environment):
        for name in ordered(tests, self.durations, path):
            timeout_s = max(MIN_TIMEOUT_S, 5 * self.durations[name])
            alarm = run_test(tests[name], environment, build, timeout_s)
            if alarm:
                return f"{name}: {alarm}"
        return ""

    def note(self, fault, caught):
        path, text, instead, what = fault
        self.rows.append({"file": path, "text": text, "instead": instead, "what": what, "caught": caught})
        print(f"{'caught' if caught else 'MISSED'}  {path}: {what}  [{caught}]", flush=True)

    def shaders(self, planted):
        for fault in planted:
            path, text, instead, _ = fault
            original = change(self.work, path, text, instead)
            self.note(fault, self.first_alarm(path, self.tests, self.build, self.environment))
            (self.work / path).write_text(original)

    def code(self, planted):
        source, build = self.work / "source", self.work / "build"
        shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(".git", "build*", "captures", "__pycache__"))
        programs = sorted({pathlib.Path(command[0]).name for command in self.tests.values()})
        targets = [name for name in programs if name.startswith("test_")] + ["hourglass"]
        configure = ["cmake", "-S", str(source), "-B", str(build), "-G", "Ninja", "-DSCREE_TESTS=ON"]
        compile_all = ["cmake", "--build", str(build), "--target", *targets]
        for step in (configure, compile_all):
            subprocess.run(step, check=True, stdout=subprocess.DEVNULL)
        tests = {name: [str(build / pathlib.Path(command[0]).relative_to(self.build)), *command[1:]]
                 for name, command in self.tests.items() if str(command[0]).startswith(str(self.build))}
        environment = {"SCREE_FAILURES": str(self.work / "failures")}
        for fault in planted:
            path, text, instead, _ = fault
            original = change(source, path, text, instead)
            built = subprocess.run(compile_all, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            caught = "the compiler" if built.returncode else self.first_alarm(path, tests, build, environment)
            self.note(fault, caught)
            (source / path).write_text(original)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True)
    parser.add_argument("--code", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--json")
    parser.add_argument("--rerun", type=int, default=1)
    options = parser.parse_args()

    shader = [f for f in faults.SHADER if options.only in f[0] or options.only in f[3]]
    code = [f for f in faults.CODE if options.only in f[0] or options.only in f[3]] if options.code else []
    lost = stale(shader + code)
    for path, text in lost:
        print(f"{path}: no longer contains '{text}': change the fault in tests/stress/faults.py", file=sys.stderr)
    if lost or not shader + code:
        return 2
    with tempfile.TemporaryDirectory() as work:
        campaign = Campaign(options.build, work, max(1, options.rerun))
        campaign.shaders(shader)
        if code:
            campaign.code(code)
    caught = sum(1 for row in campaign.rows if row["caught"])
    share = caught / len(campaign.rows)
    print(f"{caught} of {len(campaign.rows)} faults caught ({100 * share:.1f} %, needed {100 * NEEDED_SHARE:g} %), "
          f"{len(campaign.false_alarms)} false alarms")
    for name, alarm in campaign.false_alarms:
        print(f"false alarm: {name}: {alarm}")
    if options.json:
        report = {"faults": campaign.rows, "false_alarms": campaign.false_alarms, "share": share}
        pathlib.Path(options.json).write_text(json.dumps(report, indent=2) + "\n")
    return 0 if share >= NEEDED_SHARE and not campaign.false_alarms else 1


if __name__ == "__main__":
    sys.exit(main())
