#!/usr/bin/env python3
"""The template harness/farm/openjd.yaml through Open Job Description's own check and local runner: its pictures have the bits
of one process, what is finished is not rendered again, and where a tile fails nothing is merged.

Usage: openjd_test.py STBVH_AB     Exit code 77: the runner is not there and cannot be installed.
"""
import os
import pathlib
import subprocess
import sys
import tempfile

import same_pixels

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
from python_environment import environment

TEMPLATE = ROOT / "harness/farm/openjd.yaml"
PACKAGES = ["openjd-cli==0.8.0", "openjd-model==0.13.0", "openjd-sessions==0.13.0"]
FRAMES, TILES, SIZE, SAMPLES = "1001-1003:2", 2, "48x27", 2
SHUTTER = "--shutter -0.25,0.25"


class Job:
    """One folder of pictures, rendered by the template."""

    def __init__(self, python, program, output):
        self.command, self.program, self.output = [python, "-m", "openjd"], program, output

    def run(self, tasks_fail=False, **others):
        values = {"Scene": ROOT / "data/propeller.glb", "Output": self.output, "Frames": FRAMES, "Tiles": TILES, "Size": SIZE,
                  "Samples": SAMPLES, "Program": self.program, "Options": SHUTTER, **others}
        words = [word for name, value in values.items() for word in ("-p", f"{name}={value}")]
        done = subprocess.run([*self.command, "run", TEMPLATE, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, check=False)
        expect((done.returncode != 0) == tasks_fail, f"exit code {done.returncode}", done.stdout)
        return done.stdout

    def names(self, pattern):
        return sorted(file.name for file in self.output.glob(pattern))


def expect(condition, *words):
    if not condition:
        sys.exit("FAILED: " + "\n".join(map(str, words)))


def main():
    program = os.path.abspath(sys.argv[1])
    python = environment(PACKAGES) / "bin/python"
    checked = subprocess.run([python, "-m", "openjd", "check", TEMPLATE], stdout=subprocess.PIPE, text=True, check=False)
    expect(checked.returncode == 0, checked.stdout)
    with tempfile.TemporaryDirectory() as folder:
        one, output = pathlib.Path(folder, "one process"), pathlib.Path(folder, "the job's")
        output.mkdir()
        subprocess.run([program, "render", "--scenes", ROOT / "data/propeller.glb", "--structures", "stbvh",
                        "--frames", FRAMES, "--size", SIZE, "--spp", str(SAMPLES), *SHUTTER.split(), "-o", one],
                       stdout=subprocess.DEVNULL, check=True)
        job = Job(python, program, output)
        job.run()
        merged = [f"propeller-stbvh.{frame}.exr" for frame in (1001, 1003)]
        expect(job.names("*.png") == [name.replace("exr", "png") for name in merged], job.names("*"))
        expect(len(job.names("*.exr")) == len(merged) * (1 + TILES), job.names("*"))
        lines, pictures = same_pixels.differences(one, output)
        expect(not lines and pictures == len(merged), lines, pictures)

        # Of four tiles one is lost: it alone is rendered again, to the same bits.
        (output / "propeller-stbvh.1003.2of2.exr").unlink()
        (output / merged[1]).unlink()
        said = job.run()
        expect(said.count("finished before") == len(merged) * TILES - 1, said)
        expect(not same_pixels.differences(one, output)[0], "the lost tile made again is another")

        # Another seed: nothing is mixed with what is there. Then a tile fails: nothing is merged.
        said = job.run(Seed=2)
        expect(said.count("made again, as its seed was another") == len(merged) * TILES, said)
        expect(len(same_pixels.differences(one, output)[0]) == len(merged), "another seed made the same picture")
        (output / merged[0]).unlink()
        job.run(tasks_fail=True, Options="--no-such-option")
        expect(not (output / merged[0]).exists(), "merged after a failure")


if __name__ == "__main__":
    main()
