#!/usr/bin/python3
"""Authors all content from its recipes: textures, models, levels; every run gives the same bytes."""
import argparse
import concurrent.futures
import importlib
import pathlib
import sys
import time

CONTENT = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(CONTENT / "recipes"))
sys.dont_write_bytecode = True

import textures  # noqa: E402  (needs the path above)
from lib.check import Report, check_glb, check_png  # noqa: E402

SCENES = ("beast", "grains", "level1", "empty_room", "test_materials", "hopper", "wheel")
FOLDERS = ("textures", "models", "levels")

# Budgets: a level is drawn in software; a repository is cloned.
MAX_FILE_BYTES = 1_000_000
MAX_CONTENT_BYTES = 6_000_000
# The models have their own.
MAX_TRIANGLES = {"models/beast.glb": 3_000, "models/coffee_bean.glb": 400, "models/pebble.glb": 400, "models/bolt.glb": 400}
MAX_SCENE_TRIANGLES = 15_000


def make_group(name):
    return textures.GROUPS[name]()


def make_all(jobs, say):
    """{path below content: bytes} of everything."""
    images, out = {}, {}
    total = len(textures.GROUPS) + len(SCENES)
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        for k, (name, made) in enumerate(zip(textures.GROUPS, pool.map(make_group, textures.GROUPS)), 1):
            images.update(made)
            say("[%2d/%d] texture %s: %s" % (k, total, name, ", ".join("%s %d" % (n, len(b)) for n, b in made.items())))
    out.update(("textures/%s.png" % n, b) for n, b in images.items())
    for k, name in enumerate(SCENES, len(textures.GROUPS) + 1):
        made = importlib.import_module(name).make(images)
        out.update(made)
        say("[%2d/%d] scene %s: %s" % (k, total, name, ", ".join("%s %d" % (n, len(b)) for n, b in made.items())))
    return out


def faults_of(files, say):
    """Checks every file by itself, and the budgets."""
    faults = []
    for path, data in sorted(files.items()):
        if path.endswith(".png"):
            report = Report(path)
            check_png(data, "image", report)
        else:
            report = check_glb(data, path)
            say("%-28s %6d triangles %6d vertices %3d nodes, %d of %d bytes are images, %d open edges" %
                (path, report.triangles, report.vertices, report.nodes, report.image_bytes, len(data),
                 report.open_edges))
            limit = MAX_TRIANGLES.get(path, MAX_SCENE_TRIANGLES)
            if report.triangles > limit:
                report.fault("%d triangles, at most %d" % (report.triangles, limit))
        if len(data) >= MAX_FILE_BYTES:
            report.fault("%d bytes, less than %d are allowed" % (len(data), MAX_FILE_BYTES))
        faults += report.faults
    total = sum(map(len, files.values()))
    say("%d files, %d bytes" % (len(files), total))
    if total >= MAX_CONTENT_BYTES:
        faults.append("content: %d bytes, less than %d are allowed" % (total, MAX_CONTENT_BYTES))
    return faults


def differences(files):
    """What differs between the files on disk and those made."""
    found = []
    for path, data in sorted(files.items()):
        on_disk = CONTENT / path
        if not on_disk.is_file():
            found.append("%s: missing" % path)
        elif on_disk.read_bytes() != data:
            found.append("%s: differs from what the recipes make" % path)
    for folder in FOLDERS:
        for on_disk in sorted((CONTENT / folder).iterdir()):
            path = "%s/%s" % (folder, on_disk.name)
            if path not in files:
                found.append("%s: no recipe makes it" % path)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true",
                        help="write nothing; fail if a committed file differs from what the recipes make")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="processes for the textures (default 2)")
    parser.add_argument("--quiet", action="store_true", help="print only faults")
    args = parser.parse_args()
    if args.jobs < 1:
        parser.error("--jobs %d: at least 1" % args.jobs)
    say = (lambda text: None) if args.quiet else (lambda text: print(text, flush=True))
    start = time.monotonic()
    files = make_all(args.jobs, say)
    faults = faults_of(files, say)
    if args.check:
        faults += differences(files)
    elif not faults:
        for path, data in files.items():
            (CONTENT / path).parent.mkdir(exist_ok=True)
            (CONTENT / path).write_bytes(data)
    for fault in faults:
        print(fault, file=sys.stderr)
    say("%s in %.0f s" % ("%d faults" % len(faults) if faults else "checked" if args.check else "written",
                          time.monotonic() - start))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
