#!/usr/bin/env python3
"""Blender's Cycles with the preload library and without it: the same pictures but for roundings, at 3, 5, 9 and 33 time steps,
with time and peak memory of both side by side. Exit code 77: Blender is not installed."""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
BLENDER = ("blender", "-b", "--factory-startup", "--python-exit-code", "3", "-P")

# Roundings move a hit by a bit; where a path then takes another turn (an edge, a veil's coin toss) its pixel differs by more.
# How many do is measured: Embree with SSE4.2 (without fused additions) against Embree as it is.
MAX_TIMES_EMBREES_OWN = 2
MAX_MEAN_CHANGE = 1e-3


def run(command, environment, log):
    """Seconds and peak bytes of a run that must succeed."""
    start = time.monotonic()
    with open(log, "wb") as output:
        process = subprocess.Popen([str(word) for word in command], stdout=output, stderr=subprocess.STDOUT,
                                   env={**os.environ, **environment})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {process.returncode}:\n{log.read_text()[-3000:]}")
    return time.monotonic() - start, usage.ru_maxrss * 1024


def render(folder, name, options, motion_steps, environment):
    picture = folder / f"{name}-{motion_steps}.exr"
    command = [*BLENDER, FOLDER / "scene.py", "--", motion_steps, options.size, options.samples, picture]
    return picture, *run(command, environment, folder / "log.txt")


def compare(folder, first, second):
    log = folder / "compare.txt"
    run([*BLENDER, FOLDER / "compare.py", "--", first, second], {}, log)
    line = next(line for line in log.read_text().splitlines() if line.startswith("DIFFERENCE "))
    return json.loads(line.split(" ", 1)[1])


def problems_of(difference, embrees_own, statistics):
    if difference["distinct"] < 1000:
        yield "the native picture shows next to nothing"
    if statistics["meshes_taken_over"] == 0 or statistics["rays"] == 0:
        yield "nothing was taken over"
    if difference["above_1e-2"] > MAX_TIMES_EMBREES_OWN * embrees_own["above_1e-2"]:
        yield "more pixels differ than roundings explain"
    if difference["mean_relative"] > MAX_MEAN_CHANGE:
        yield "one picture is brighter"


def counts(difference):
    return f"{difference['any']}, {difference['above_1e-4']}, {difference['above_1e-2']} of {difference['pixels']}"


def try_motion_steps(options, folder, motion_steps):
    """Renders, compares, prints a line; the problems found."""
    file = folder / "statistics.json"
    environment = {"LD_PRELOAD": str(options.library.resolve()), "STBVH_PRELOAD_STATISTICS": str(file)}
    if options.all:
        environment["STBVH_PRELOAD_ALL"] = "1"
    other_isa = {"LD_PRELOAD": str(options.embree_isa.resolve()), "EMBREE_ISA": "sse4.2"}
    native, native_seconds, native_bytes = render(folder, "native", options, motion_steps, {})
    control, _, _ = render(folder, "sse", options, motion_steps, other_isa)
    ours, seconds, peak_bytes = render(folder, "stbvh", options, motion_steps, environment)
    embrees_own = compare(folder, native, control)
    difference = compare(folder, native, ours)
    statistics = json.loads(file.read_text())
    print(f"{2 ** motion_steps + 1:5}  {native_seconds:<5.1f} {native_bytes / 1e6:<6.0f} {seconds:<5.1f} "
          f"{peak_bytes / 1e6:<6.0f} {statistics['meshes_taken_over']:<7} {counts(difference):<28} "
          f"{counts(embrees_own)}", flush=True)
    return list(problems_of(difference, embrees_own, statistics))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--library", type=Path, required=True, help="libstbvh_preload.so")
    parser.add_argument("--embree-isa", type=Path, required=True, help="libembree_isa.so, built from embree_isa.c")
    parser.add_argument("--motion-steps", type=int, nargs="+", default=[1, 2, 3, 5], help="n gives 2^n + 1 time steps")
    parser.add_argument("--size", type=int, default=480, help="width of the pictures")
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--all", action="store_true", help="take over all triangle meshes")
    options = parser.parse_args()
    if shutil.which("blender") is None:
        print("blender is not installed")
        return 77
    failed = False
    print("       native       stbvh                pixels that differ: at all, by 1e-4, by 1e-2\n"
          "steps  s     MB     s     MB     meshes  stbvh from native            Embree's SSE4.2 from its best")
    with tempfile.TemporaryDirectory() as name:
        for motion_steps in options.motion_steps:
            for problem in try_motion_steps(options, Path(name), motion_steps):
                print(f"       FAILED: {problem}")
                failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
