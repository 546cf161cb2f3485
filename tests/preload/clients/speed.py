#!/usr/bin/env python3
"""How many rays Embree's pathtracer traces natively and with the preload library, on scenes of the harness: a table in
Markdown of medians of runs in turns, in million rays a second as it prints them (--benchmark), shading included. Or on
turning tori, from small to large, of few segments and of many (--tori): there also its viewer with ambient occlusion,
which sets no filter functions; the pathtracer always does."""

import argparse
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from embree_tools import Side, find_tool, require_tools

AVERAGE = re.compile(r"^BENCHMARK_RENDER_MRAYPS_AVG\s+([0-9.]+)", re.MULTILINE)
SCENES = ["llama", "wheels", "train", "crowd", "dancer", "barbarian"]
TORI_TRIANGLES = [500, 2_000, 10_000, 40_000, 160_000]
TORI_SEGMENTS = [1, 2, 8]
TORUS_TRIANGLES = 40_000  # of the scene torus at scale 1
TORUS_SEGMENTS = 8
PATHTRACER = ["pathtracer"]
AMBIENT_OCCLUSION = ["viewer", "--shader", "ao"]


class Failed(Exception):
    pass


def mrays_per_s(side, tool, scene, options):
    command = [find_tool(tool[0]), *tool[1:], "-i", scene, "--size", options.size, options.size, "--benchmark", 1, options.frames]
    outcome = side.run(command, options.timeout)
    found = AVERAGE.search(outcome.text)
    if not outcome.ended_well() or found is None:
        raise Failed(f"{tool[0]} on {scene.name}: {outcome}")
    return float(found[1])


def convert(name, scale, folder, options):
    path = folder / f"{name}.xml"
    words = ["--scale", str(scale)] if scale else []
    done = subprocess.run([options.stbvh_ab, "convert", name, *words, "-o", path], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(f"stbvh-ab convert {name}: {done.stderr.strip()}")
    return path


def leave_steps_out(path, every):
    """Keeps the first step of the torus, and each that many after it."""
    lines = path.read_text().splitlines()
    first = lines.index("<animated_positions>") + 1
    last = lines.index("</animated_positions>")
    path.write_text("\n".join([*lines[:first], *lines[first:last:every], *lines[last:]]))


def tests(folder, options):
    """What is measured: a name, the tool, the scene's file, which is made when it is asked for."""
    if not options.tori:
        for name in options.scenes:
            yield name, PATHTRACER, convert(name, options.scale, folder, options)
        return
    for triangles in TORI_TRIANGLES:
        for segments in TORI_SEGMENTS:
            path = convert("torus", triangles / TORUS_TRIANGLES, folder, options)
            leave_steps_out(path, TORUS_SEGMENTS // segments)
            for tool in PATHTRACER, AMBIENT_OCCLUSION:
                yield f"{triangles:,} triangles | {segments} | {tool[0]}", tool, path


def row(name, pairs):
    """`pairs`: the rays of native runs and of ours that followed them."""
    native, ours = (statistics.median(values) for values in zip(*pairs))
    ratios = [b / a for a, b in pairs]
    return (f"| {name} | {native:.2f} | {ours:.2f} | "
            f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f}) |")


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stbvh-run", required=True, help="the script of the build")
    parser.add_argument("--stbvh-ab", required=True, help="the harness, for its scenes")
    parser.add_argument("--scenes", nargs="+", default=SCENES, metavar="SCENE", help=" ".join(SCENES))
    parser.add_argument("--tori", action="store_true", help="turning tori instead")
    parser.add_argument("--scale", type=float, help="of the scenes; stbvh-ab's own without it")
    parser.add_argument("--size", type=int, default=512, help="width and height of the picture")
    parser.add_argument("--frames", type=int, default=4, help="that a run measures, after one that it does not")
    parser.add_argument("--repeats", type=int, default=3, help="runs of each")
    parser.add_argument("--timeout", type=float, default=600, help="seconds a run may take")
    options = parser.parse_args()
    if options.repeats < 1:
        parser.error("--repeats must be 1 or more")
    return options


def main():
    options = parse()
    require_tools("pathtracer", "viewer")
    sides = Side(), Side(options.stbvh_run)
    columns = "| torus | segments | tool |" if options.tori else "| scene |"
    print(f"{columns} native | ours | ratio |\n" + "|---" * (columns.count("|") + 2) + "|", flush=True)
    try:
        with tempfile.TemporaryDirectory(prefix="stbvh-speed-") as folder:
            for name, tool, scene in tests(Path(folder), options):
                pairs = [[mrays_per_s(side, tool, scene, options) for side in sides] for _ in range(options.repeats)]
                print(row(name, pairs), flush=True)
    except Failed as failure:
        print(failure, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
