#!/usr/bin/env python3
"""stbvh-ab where memory runs out in one allocation: it says so in its last line and ends with an error, or it prints what it
prints else. Usage: out_of_memory.py STBVH_AB LIBRARY [--every N]
LIBRARY: failing_allocations_preload.cpp, built. With N only every Nth allocation fails, from the Nth on."""

import argparse
import concurrent.futures
import os
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
    "error": ["error", "--structures", "stbvh,embree", "--count", "10", "--threads", "1", "--scenes"],
    "convert": ["convert", "-o", "{folder}/out.xml"],
}


def run(program, command, scene, folder, environment):
    arguments = [argument.format(folder=folder) for argument in command]
    return subprocess.run([program, *arguments, scene], env={**os.environ, **environment}, capture_output=True, text=True,
                          errors="replace", timeout=300, check=False)


def problem_of(done, expected):
    if done.returncode in (1, 2):  # 2: in a file that it was given
        last = (done.stderr.splitlines() or [""])[-1]
        return None if last.startswith("stbvh-ab: ") else f"its last line is '{last}'"
    if done.returncode in (0, NOTHING_FAILED):
        return None if done.stdout == expected else "its output is another"
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

        def try_one(name, number, expected):
            with tempfile.TemporaryDirectory(dir=top) as folder:
                environment = {"LD_PRELOAD": str(library), "FAILING_ALLOCATION": str(number)}
                done = run(program, COMMANDS[name], scene, folder, environment)
                return number, done.returncode, problem_of(done, expected.replace("{folder}", folder))

        for name, command in COMMANDS.items():
            reference = run(program, command, scene, top, {})
            if reference.returncode != 0:
                sys.exit(f"{name} fails anyway: {reference.stderr}")
            expected = reference.stdout.replace(top, "{folder}")
            number, ended = options.every - 1, False
            while not ended:
                numbers = [number + i * options.every for i in range(64)]
                for at, code, problem in pool.map(lambda n: try_one(name, n, expected), numbers):
                    ended |= code == NOTHING_FAILED
                    if problem is not None:
                        print(f"{name}, allocation {at}: {problem}")
                        problems += 1
                number = numbers[-1] + options.every
            print(f"{name}: fewer than {number} allocations")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
