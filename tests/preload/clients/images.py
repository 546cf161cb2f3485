#!/usr/bin/env python3
"""Pictures of Embree's tools with the preload library and without it: the same but for roundings, and no native tree over
moving triangles is built. --native runs both sides without the library: they must not differ in a single pixel."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from embree_tools import Difference, Side, find_tool, native_trees_of_moving_triangles, require_tools
from scenes import CONVERTED, MODELS, SCENES

# Those with _ispc trace packets, and streams were Embree 3's.
TOOLS = {"pathtracer": ("--spp", "4"), "pathtracer_ispc": ("--spp", "4"), "viewer": (), "viewer_ispc": (), "viewer_stream": ()}
# Tutorials with triangle meshes, for --all. The last looks along an edge of its cube, where two triangles are equally near.
TUTORIALS = {name: () for name in (
    "closest_point", "curve_geometry", "displacement_geometry", "dynamic_scene", "grid_geometry", "instanced_geometry",
    "interpolation", "intersection_filter", "lazy_geometry", "multiscene_geometry", "point_geometry",
    "subdivision_geometry", "user_geometry")}
TUTORIALS["triangle_geometry"] = ("--vp", "1.3", "1.6", "-1.7")
MODEL_FOLDER = next(Path("/usr/share/doc").glob("embree[34]/models"), Path())


class Job:
    """A command line of a tool, but for the picture it writes."""

    def __init__(self, name, command, moves):
        self.name, self.command, self.moves = name, command, moves


def write_scenes(folder, stbvh_ab, names):
    """Files by name, whether something moves in them, and the tools' options for them."""
    for name, (make, moves, options) in SCENES.items():
        if not names or name in names:
            path = folder / f"{name}.xml"
            path.write_text(make(), encoding="utf-8")
            yield name, path, moves, options
    for name, options in MODELS.items():
        if (not names or name in names) and (MODEL_FOLDER / name).exists():
            yield name, MODEL_FOLDER / name, True, options
    for name, scale in CONVERTED.items():
        if stbvh_ab and (not names or name in names):
            path = folder / f"{name}.xml"
            subprocess.run([stbvh_ab, "convert", name, "--scale", str(scale), "-o", path], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            yield name, path, True, ()


def make_jobs(options, folder):
    size = ["--size", str(options.size), str(options.size)]
    for name, path, moves, more in write_scenes(folder, options.stbvh_ab, options.scenes):
        for tool in options.tools:
            yield Job(f"{tool} {name}", [find_tool(tool), "-i", path, *size, *TOOLS[tool], *more], moves)
    if not options.scenes:
        yield Job("motion_blur_geometry", [find_tool("motion_blur_geometry"), *size], True)
        # Not along edges, where two triangles are equally near, and which comes first is nobody's.
        aside = ("--vp", "0.37", "3.1", "9", "--vi", "0.01", "0.02", "0")
        yield Job("next_hit", [find_tool("next_hit"), "-i", folder / "transparent.xml", *size, *aside], True)
    if options.all and not options.scenes:
        for tutorial, more in TUTORIALS.items():
            yield Job(tutorial, [find_tool(tutorial), *size, *more], False)


def compare_pictures(job, ours, folder, timeout, takes_all):
    """Problems, and a line about what was found."""
    pictures = folder / "native.ppm", folder / "ours.ppm"
    for picture in pictures:
        picture.unlink(missing_ok=True)
    statistics_file = folder / "statistics.json"
    statistics_file.unlink(missing_ok=True)
    native_run = Side().run([*job.command, "-o", pictures[0]], timeout)
    if not native_run.ended_well():
        return [f"natively: {native_run}"], "no picture"
    our_run = ours.run([*job.command, "-o", pictures[1]], timeout, ("--json", str(statistics_file)))
    if not our_run.ended_well():
        return [f"{our_run}"], "no picture"
    difference = Difference(*pictures)
    problems = []
    if difference.shown < 0.01:
        problems.append(f"nothing but background in {1 - difference.shown:.3%} of the native picture")
    if ours.is_native and difference.differing:
        problems.append("two native runs differ")
    if not difference.within_floats():
        problems.append("more than roundings explain")
    meshes = 0
    if not ours.is_native:
        meshes = json.loads(statistics_file.read_text())["meshes_taken_over"]
        if (job.moves or takes_all) and meshes == 0:
            problems.append("no mesh was taken over")
    return problems, f"{difference}; {meshes} meshes taken over"


def check_trees(job, ours, folder, timeout):
    """`--verbose 2` names each tree that Embree builds. Natively there must be one over moving triangles, or the test
    says nothing; its exit code does not count there (3.13.5 fails an assertion of its statistics in some scenes)."""
    command = [*job.command, "-o", folder / "verbose.ppm", "--verbose", "2"]
    natively = native_trees_of_moving_triangles(Side().run(command, timeout).text)
    if job.moves != bool(natively):
        return [f"Embree was expected to build {'a' if job.moves else 'no'} tree over moving triangles natively"]
    if ours.is_native:
        return []
    run = ours.run(command, timeout)
    problems = [f"still built natively: {line}" for line in native_trees_of_moving_triangles(run.text)]
    if "Embree Ray Tracing Kernels" not in run.text:
        problems.append("--verbose 2 said nothing")
    if not run.ended_well():
        problems.append(f"with --verbose 2: {run}")
    return problems


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stbvh-run", help="the script of the build")
    parser.add_argument("--stbvh-ab", help="the harness, for its scenes")
    parser.add_argument("--native", action="store_true")
    parser.add_argument("--all", action="store_true", help="take over meshes at rest too")
    parser.add_argument("--tools", type=lambda s: s.split(","), default=[t for t in TOOLS if find_tool(t)],
                        help="those that are installed, if not named")
    parser.add_argument("--scenes", type=lambda s: s.split(","), default=[])
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--timeout", type=float, default=120)
    parser.add_argument("--keep", type=Path, help="leave the files in this folder")
    options = parser.parse_args()
    if bool(options.stbvh_run) == options.native:
        parser.error("one of --stbvh-run and --native is needed")
    return options


def run_jobs(options, folder):
    ours = Side() if options.native else Side(options.stbvh_run, ["--all"] if options.all else [])
    failed = count = 0
    for job in make_jobs(options, folder):
        problems, found = compare_pictures(job, ours, folder, options.timeout, options.all)
        problems += check_trees(job, ours, folder, options.timeout)
        count += 1
        failed += bool(problems)
        print(f"{'FAILED' if problems else 'passed'}  {job.name}: {found}", flush=True)
        for problem in problems:
            print(f"        {problem}", flush=True)
    print(f"{count - failed} of {count} pictures are as they are natively")
    return 0 if count and not failed else 1


def main():
    options = parse()
    require_tools(*options.tools, "motion_blur_geometry", "next_hit", *(TUTORIALS if options.all else ()))
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
        return run_jobs(options, options.keep)
    with tempfile.TemporaryDirectory(prefix="stbvh-images-") as folder:
        return run_jobs(options, Path(folder))


if __name__ == "__main__":
    sys.exit(main())
