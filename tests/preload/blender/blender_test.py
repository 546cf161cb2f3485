#!/usr/bin/env python3
"""Blender's Cycles with the preload library and without it: the same pictures but for roundings. One frame of deforming
meshes and instances at 3, 5, 9 and 33 time steps; three frames by one process with persistent data; shadows through
moving transparent things. --figures prints time and peak memory of both instead. Exit code 77: Blender is not installed,
and no Python with the module bpy is named."""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent

# Roundings move a hit by a bit; where a path then takes another turn (an edge, a veil's coin toss) its pixel differs by more.
# How many do is measured: Embree with SSE4.2 (without fused additions) against Embree as it is.
MAX_TIMES_EMBREES_OWN = 2
MAX_MEAN_CHANGE = 1e-3


class Case:
    """A scene of scene.py with n motion steps, which are 2^n + 1 time steps, and the frames to render."""

    def __init__(self, scene, motion_steps, first=2, last=2):
        self.scene, self.motion_steps, self.first, self.last = scene, motion_steps, first, last

    def pictures(self, prefix):
        return [Path(f"{prefix}{frame:04}.exr") for frame in range(self.first, self.last + 1)]


CASES = {
    "3-steps": Case("objects", 1),
    "5-steps": Case("objects", 2),
    "9-steps": Case("objects", 3),
    "33-steps": Case("objects", 5),
    "three-frames": Case("objects", 2, 1, 3),
    "transparent-shadows": Case("shadows", 3),
}


def run(command, environment, log):
    """Peak bytes of a run that must succeed, and what it said."""
    with open(log, "wb") as output:
        process = subprocess.Popen([str(word) for word in command], stdout=output, stderr=subprocess.STDOUT,
                                   env={**os.environ, **environment})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    text = log.read_text(errors="replace")
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {process.returncode}:\n{text[-3000:]}")
    return usage.ru_maxrss * 1024, text


def values_after(word, text):
    return [json.loads(line.split(" ", 1)[1]) for line in text.splitlines() if line.startswith(word + " ")]


def blender(options):
    """What runs a script."""
    if options.python:
        return [options.python]
    return ["blender", "-b", "--factory-startup", "--python-exit-code", "3", "-P"]


def compare(options, folder, pairs):
    """How far the pictures of each pair are apart."""
    names = [name for pair in pairs for name in pair]
    _, text = run([*blender(options), FOLDER / "compare.py", "--", *names], {}, folder / "compare.txt")
    return values_after("DIFFERENCE", text)


class Renders:
    """Renders a case natively, with another instruction set of Embree's, and with the library."""

    def __init__(self, options, folder, name):
        self.options, self.folder, self.name, self.case = options, folder, name, CASES[name]
        self.statistics_file = folder / "statistics.json"
        all_triangles = {"STBVH_PRELOAD_ALL": "1"} if options.all else {}
        self.environments = {
            "native": {},
            "sse": {"LD_PRELOAD": str(options.embree_isa.resolve()), "EMBREE_ISA": "sse4.2"},
            "stbvh": {"LD_PRELOAD": str(options.library.resolve()), **all_triangles},
        }

    def render(self, side, counted=True):
        """The pictures, the seconds of rendering (with the building of trees, without Blender's start), the peak bytes."""
        prefix = self.folder / f"{side}-{self.name}-"
        environment = dict(self.environments[side])
        if side == "stbvh" and counted:
            environment["STBVH_PRELOAD_STATISTICS"] = str(self.statistics_file)
        case = self.case
        command = [*blender(self.options), FOLDER / "scene.py", "--", case.scene, f"{case.first}-{case.last}", case.motion_steps,
                   self.options.size, self.options.samples, prefix]
        peak_bytes, text = run(command, environment, self.folder / "log.txt")
        seconds, = values_after("RENDER_SECONDS", text)
        return case.pictures(prefix), seconds, peak_bytes

    def statistics(self):
        return json.loads(self.statistics_file.read_text())


def problems_of_pair(difference, embrees_own):
    if difference["distinct"] < 1000:
        yield "the native picture shows next to nothing"
    if difference["above_1e-2"] > MAX_TIMES_EMBREES_OWN * embrees_own["above_1e-2"]:
        yield "more pixels differ than roundings explain"
    if difference["mean_relative"] > MAX_MEAN_CHANGE:
        yield "one picture is brighter"


def problems_of_case(name, counts, differences, steps_between_frames):
    """Whether the test has tested what it is for; `counts`: the statistics of the library."""
    if 0 in (counts["meshes_taken_over"], counts["rays"], counts["filtered_hits"]):
        yield "nothing was taken over, or no filter was asked"
    if set(counts["meshes_left_native"]) - {"one time step"}:
        yield f"moving meshes were left to Embree: {counts['meshes_left_native']}"
    if counts["failed_builds"] != 0:
        yield "a build failed"
    frames = len(differences)
    if frames > 1 and counts["devices"] >= frames:  # Cycles makes two for each session, which persistent data keep
        yield f"{counts['devices']} devices of Embree for {frames} frames: data were not persistent"
    if counts["builds"] < frames:
        yield f"{counts['builds']} builds for {frames} frames"
    if any(step["above_1e-2"] < step["pixels"] / 20 for step in steps_between_frames):
        yield "frames look alike"
    if name == "transparent-shadows" and differences[0]["green"] < differences[0]["pixels"] / 10:
        yield "no green light on the floor: the shadows are not transparent"


def amounts(difference):
    return f"{difference['any']}, {difference['above_1e-4']}, {difference['above_1e-2']} of {difference['pixels']}"


def test_case(options, folder, name):
    """Renders, compares, prints a line for each frame; the problems found."""
    renders = Renders(options, folder, name)
    native, sse, ours = (renders.render(side)[0] for side in ("native", "sse", "stbvh"))
    found = compare(options, folder, [*zip(native, sse), *zip(native, ours), *zip(native, native[1:])])
    frames = len(native)
    own, differences, between = found[:frames], found[frames:2 * frames], found[2 * frames:]
    counts = renders.statistics()
    problems = []
    for frame, (difference, embrees_own) in enumerate(zip(differences, own), renders.case.first):
        print(f"{name:<20} {frame:<6} {counts['meshes_taken_over']:<7} {amounts(difference):<28} {amounts(embrees_own)}",
              flush=True)
        problems += [f"frame {frame}: {problem}" for problem in problems_of_pair(difference, embrees_own)]
    return problems + list(problems_of_case(name, counts, differences, between))


def test(options, folder):
    print("                             meshes  pixels that differ: at all, by 1e-4, by 1e-2\n"
          "case                 frame  taken   stbvh from native            Embree's SSE4.2 from its best")
    failed = False
    for name in options.cases:
        for problem in test_case(options, folder, name):
            print(f"{'':20} FAILED: {problem}")
            failed = True
    return 1 if failed else 0


def spread(values, digits):
    return f"{statistics.median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def print_figures(options, folder):
    """A Markdown table: medians, with least and largest; a ratio is that of two runs that followed each other."""
    print("| case | native s | stbvh s | stbvh / native | native MB | stbvh MB | stbvh / native |\n|---|---|---|---|---|---|---|")
    for name in options.cases:
        renders = Renders(options, folder, name)
        pairs = [[renders.render(side, counted=False)[1:] for side in ("native", "stbvh")] for _ in range(options.figures)]
        cells = []
        for which, unit, digits in ((0, 1, 2), (1, 1e6, 0)):
            native, ours = ([pair[side][which] / unit for pair in pairs] for side in (0, 1))
            cells += [spread(native, digits), spread(ours, digits), spread([b / a for a, b in zip(native, ours)], 2)]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)
    return 0


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--library", type=Path, required=True, help="libstbvh_preload.so, or libstbvh_preload4.so for Blender 4")
    parser.add_argument("--embree-isa", type=Path, required=True, help="libembree_isa.so, built from embree_isa.c")
    parser.add_argument("--python", help="with this Python, which has the module bpy, instead of the program blender")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), metavar="CASE", help=", ".join(CASES))
    parser.add_argument("--size", type=int, default=480, help="width of the pictures")
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--all", action="store_true", help="take over all triangle meshes")
    parser.add_argument("--figures", type=int, metavar="N",
                        help="compare nothing; print a table of time and peak memory, of N runs of each side in turns")
    options = parser.parse_args()
    if options.figures is not None and options.figures < 1:
        parser.error("--figures must be 1 or more")
    for library in (options.library, options.embree_isa):
        if not library.is_file():  # the loader would go on without it
            parser.error(f"there is no {library}")
    return options


def main():
    options = parse()
    if not options.python and shutil.which("blender") is None:
        print("blender is not installed")
        return 77
    with tempfile.TemporaryDirectory(prefix="stbvh-blender-") as name:
        return print_figures(options, Path(name)) if options.figures else test(options, Path(name))


if __name__ == "__main__":
    sys.exit(main())
