#!/usr/bin/env python3
"""stbvh-ab where memory runs out in one allocation: it says so in its last line and ends with an error, or it prints and
writes what it does else. Usage: out_of_memory.py STBVH_AB LIBRARY [--every N]
LIBRARY: failing_allocations_preload.cpp, built. With N only every Nth allocation fails, from the Nth on."""

import argparse
import concurrent.futures
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

NOTHING_FAILED = 77
SCENE = """<?xml version="1.0"?>
<scene><TriangleMesh>
<animated_positions><positions>0 0 0 1 0 0 0 1 0</positions><positions>0 0 1 1 0 1 0 1 1</positions></animated_positions>
<triangles>0 1 2</triangles>
</TriangleMesh></scene>
"""
COMMANDS = {
    "error": ["error", "--structures", "stbvh,embree", "--count", "10", "--threads", "1", "--scenes", "{scene}"],
    "hard": ["hard", "--structures", "stbvh,embree", "--count", "10", "--threads", "1", "--families", "too-many-steps"],
    "convert": ["convert", "-o", "{folder}/out.xml", "{scene}"],
    "render": ["render", "--structures", "stbvh", "--size", "8x4", "--spp", "1", "--threads", "1", "--png",
               "-o", "{folder}/out.exr", "--scenes", "{scene}"],
    "compare": ["compare", "{picture}", "{picture}"],
}


def run(program, command, places, environment):
    arguments = [argument.format(**places) for argument in command]
    return subprocess.run([program, *arguments], env={**os.environ, **environment}, capture_output=True, text=True,
                          errors="replace", timeout=300, check=False)


def output_of(done, folder):
    """What it printed, but for how fast it was."""
    return re.sub(r" \(.* rays a second\)", "", done.stdout.replace(str(folder), ""))


def files_in(folder):
    """OpenEXR files hold how long they took: they are there or not."""
    return {f.name: b"" if f.suffix == ".exr" else f.read_bytes() for f in folder.iterdir()}


def problem_of(done, folder, expected_output, expected_files):
    files = files_in(folder)
    if not files.items() <= expected_files.items():
        return f"it leaves other files: {', '.join(files)}"
    if done.returncode in (1, 2):  # 2: in a file that it was given
        last = (done.stderr.splitlines() or [""])[-1]
        return None if last.startswith("stbvh-ab: ") else f"its last line is '{last}'"
    if done.returncode in (0, NOTHING_FAILED):
        if output_of(done, folder) != expected_output:
            return "its output is another"
        return None if files == expected_files else f"it leaves only {', '.join(files) or 'nothing'}"
    return f"exit code {done.returncode}: {done.stderr.strip()[-200:]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stbvh_ab", type=Path)
    parser.add_argument("library", type=Path)
    parser.add_argument("--every", type=int, default=1)
    options = parser.parse_args()
    program, library = options.stbvh_ab.resolve(), options.library.resolve()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    problems = 0
    with tempfile.TemporaryDirectory() as top, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        scene = Path(top) / "tiny.xml"
        scene.write_text(SCENE)
        places = {"scene": scene, "picture": Path(__file__).resolve().parent.parent / "fuzz/corpus/exr/seed_float"}

        def try_one(command, number, *expected):
            with tempfile.TemporaryDirectory(dir=top) as folder:
                environment = {"LD_PRELOAD": str(library), "FAILING_ALLOCATION": str(number)}
                done = run(program, command, {**places, "folder": folder}, environment)
                return number, done.returncode, problem_of(done, Path(folder), *expected)

        for name, command in COMMANDS.items():
            with tempfile.TemporaryDirectory(dir=top) as folder:
                reference = run(program, command, {**places, "folder": folder}, {})
                if reference.returncode != 0:
                    sys.exit(f"{name} fails anyway: {reference.stderr}")
                expected = output_of(reference, folder), files_in(Path(folder))
            number, ended = options.every - 1, False
            while not ended:
                numbers = [number + i * options.every for i in range(64)]
                for at, code, problem in pool.map(lambda n: try_one(command, n, *expected), numbers):
                    ended |= code == NOTHING_FAILED
                    if problem is not None:
                        print(f"{name}, allocation {at}: {problem}")
                        problems += 1
                number = numbers[-1] + options.every
            print(f"{name}: fewer than {number} allocations")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
