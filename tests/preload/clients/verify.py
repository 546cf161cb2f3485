#!/usr/bin/env python3
"""embree_verify, Embree's own test suite, with the preload library: what passes natively must pass with it.

The lists are of the tests of triangles with motion blur (and, with --all, of all triangles) that pass natively. Left out
are ray_masks and sphere_filter_multi_hit_tests, which fail or crash natively, and with AVX512 those that hang."""

import argparse
import json
import re
import sys
import tempfile
from collections import Counter
from pathlib import Path

from embree_tools import Side, require_tools, skip

WATERTIGHT = ["watertight_triangles_mb.*"]
MOTION_BLUR = [r"get_bounds\.triangles_mb", r"get_linear_bounds\.triangles_mb", r"buffer_stride\.triangles_mb",
               r"build\..*", r"empty_geometry.*", r"overlapping_primitives.*", r"new_delete_geometry.*",
               r"point_query.*", r"regression_static.*", r"regression_dynamic.*"]
ALL_TRIANGLES = [r"triangle_hit.*", r"intersection_filter.*", r"inactive_rays.*", r"update.*",
                 r"ray_alignment_test.*", r"enable_disable.*", r"disable_detach.*", r"user_geometry_id.*"]
LISTS = {"watertight": WATERTIGHT, "motion-blur": WATERTIGHT + MOTION_BLUR,
         "all-triangles": WATERTIGHT + MOTION_BLUR + ALL_TRIANGLES}
RESULT = re.compile(r"^\s*(AVX\w+\.\S+) .*\[(PASSED|FAILED)", re.MULTILINE)


def run_tests(side, isa, patterns, intensity, timeout, more=()):
    """How many tests there were, which failed (names repeat), and how the program ended."""
    # By lines, so that what was done before a crash is known.
    command = ["stdbuf", "-oL", "embree_verify", "--no-colors", "--flatten", "--intensity", str(intensity)]
    for pattern in patterns:
        command += ["--run", rf"{isa}\.{pattern}"]
    outcome = side.run(command, timeout, more)
    results = RESULT.findall(outcome.text)
    return len(results), Counter(name for name, result in results if result != "PASSED"), outcome


def without_native_failures(failed, isa, intensity, timeout):
    """Those of the failures that are not there natively."""
    ours = Counter()
    for name, count in failed.items():
        pattern = re.escape(name.removeprefix(isa + "."))
        _, natively, _ = run_tests(Side(), isa, [pattern], intensity, timeout)
        ours[name] = max(count - natively[name], 0)
    return +ours


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stbvh-run", help="the script of the build; without it everything runs natively")
    parser.add_argument("--isa", choices=("AVX2", "AVX512"), default="AVX2")
    parser.add_argument("--list", choices=LISTS, default="motion-blur")
    parser.add_argument("--intensity", type=float, default=0.5,
                        help="at least 0.1: below, the watertight tests cast no rays; embree_verify's own default is 1")
    parser.add_argument("--timeout", type=float, default=1500)
    parser.add_argument("--at-least", type=int, default=1, help="fewer tests are a failure")
    options = parser.parse_args()
    if options.intensity < 0.1:
        parser.error("--intensity must be 0.1 or more")
    return options


def machine_has(isa):
    flag = {"AVX2": "avx2", "AVX512": "avx512f"}[isa]
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        return re.search(rf"^flags\s*:.*\b{flag}\b", file.read(), re.MULTILINE) is not None


def main():
    options = parse()
    require_tools("embree_verify", "stdbuf")
    if not machine_has(options.isa):
        skip(f"this machine has no {options.isa}")
    run_options = ["--all"] if options.list == "all-triangles" else []
    side = Side(options.stbvh_run, run_options) if options.stbvh_run else Side()
    with tempfile.TemporaryDirectory(prefix="stbvh-verify-") as folder:
        file = Path(folder) / "statistics.json"
        count, failed, outcome = run_tests(side, options.isa, LISTS[options.list], options.intensity, options.timeout,
                                           ("--json", str(file)))
        statistics = json.loads(file.read_text()) if file.exists() else {"meshes_taken_over": 0, "rays": 0}
    ours = failed if side.is_native else without_native_failures(failed, options.isa, options.intensity,
                                                                 options.timeout)
    print(f"{options.isa}, {options.list}, intensity {options.intensity}: {count - failed.total()} of {count} tests passed, "
          f"{failed.total()} failed, {failed.total() - ours.total()} of them natively too")
    for name, times in sorted(ours.items()):
        print(f"FAILED  {name}" + (f" ({times} times)" if times > 1 else ""))
    print(f"{statistics['meshes_taken_over']} meshes taken over, {statistics['rays']} rays")
    broken = outcome.exit_code not in (0, 1) or count < options.at_least
    idle = not side.is_native and 0 in (statistics["meshes_taken_over"], statistics["rays"])
    if idle:
        print("nothing was asked of the preload library")
    if broken:
        print(f"embree_verify did not end as it should (of {options.at_least} tests or more): {outcome}")
    return 1 if ours or broken or idle else 0


if __name__ == "__main__":
    sys.exit(main())
