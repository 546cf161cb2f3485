"""Embree's own programs (Debian: embree-tools), run natively or with the preload library."""

import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

SKIPPED = 77  # ctest's SKIP_RETURN_CODE


def skip(sentence):
    print(f"skipped: {sentence}")
    sys.exit(SKIPPED)


def find_tool(name):
    """What a program of Embree is called here, or None: from Embree 4 on their names begin with embree_."""
    return next((found for found in (f"embree_{name}", name) if shutil.which(found)), None)


def require_tools(*names):
    """What they are called here; skips the test where one of them is not installed."""
    missing = [name for name in names if find_tool(name) is None]
    if missing:
        skip(f"{', '.join(missing)}: not installed (embree-tools)")
    return [find_tool(name) for name in names]


def serves(stbvh_run):
    """The major versions of Embree for which the drop-in library lies beside the script."""
    folder = Path(stbvh_run).resolve().parent
    return [major for major, name in ((3, "libstbvh_preload.so"), (4, "libstbvh_preload4.so")) if (folder / name).exists()]


class Outcome:
    """How a program ended: its exit code (negative: the signal; None: it took too long) and all it said."""

    def __init__(self, exit_code, text):
        self.exit_code = exit_code
        self.text = text

    def ended_well(self):
        return self.exit_code == 0

    def __str__(self):
        how = "took too long" if self.exit_code is None else f"exit code {self.exit_code}"
        return f"{how}; it said last:\n{os.linesep.join(self.text.splitlines()[-8:])}"


class Side:
    """Where a program runs: natively, or under `stbvh-run OPTIONS`."""

    def __init__(self, stbvh_run=None, options=()):
        self.prefix = [] if stbvh_run is None else [str(stbvh_run), *options]
        self.is_native = stbvh_run is None

    def run(self, command, timeout, more=()):
        """`more`: further options of stbvh-run, where that is used."""
        prefix = [] if self.is_native else [*self.prefix, *more]
        try:
            done = subprocess.run([*prefix, *map(str, command)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, timeout=timeout, check=False)
            return Outcome(done.returncode, done.stdout.decode(errors="replace"))
        except subprocess.TimeoutExpired as late:
            return Outcome(None, (late.stdout or b"").decode(errors="replace"))


MOVING_TREE = re.compile(r"building \S*(MB<triangle|<triangle\w*mb>)", re.IGNORECASE)


def native_trees_of_moving_triangles(text):
    """Lines of `--verbose 2` that say that Embree builds a tree over moving triangles."""
    return [line for line in text.splitlines() if MOVING_TREE.search(line)]


def read_ppm(path):
    """Width, height and the bytes of a binary PPM file of 8 bits; a ValueError for anything else."""
    data = Path(path).read_bytes()
    header = re.match(rb"P6\s(?:#[^\n]*\n|\s)*(\d+)\s+(\d+)\s+255\s", data)
    if header is None:
        raise ValueError(f"{path} is no PPM picture")
    width, height = int(header[1]), int(header[2])
    pixels = data[header.end():]
    if len(pixels) != 3 * width * height:
        raise ValueError(f"{path} has {len(pixels)} bytes of pixels, not {3 * width * height}")
    return width, height, pixels


class Difference:
    """How far two pictures are apart, in steps of 8 bits."""

    def __init__(self, first, second):
        (width, height, a), (other_width, other_height, b) = read_ppm(first), read_ppm(second)
        if (width, height) != (other_width, other_height):
            raise ValueError(f"{first} and {second} differ in size")
        steps = [abs(x - y) for x, y in zip(a, b)]
        by_pixel = [max(steps[i:i + 3]) for i in range(0, len(steps), 3)]
        self.pixels = len(by_pixel)
        self.differing = sum(s > 0 for s in by_pixel)
        self.large = sum(s > LARGE for s in by_pixel)
        self.largest = max(by_pixel)
        self.mean = sum(steps) / len(steps)
        colors = Counter(a[i:i + 3] for i in range(0, len(a), 3))
        self.shown = 1 - max(colors.values()) / self.pixels  # what is not background

    def within_floats(self):
        """Whether other roundings of hit distances explain it: they move a color by a step, or let single paths go
        another way at an edge."""
        return (self.differing <= MOST_DIFFERING * self.pixels and self.large <= MOST_LARGE * self.pixels and
                self.mean <= LARGEST_MEAN)

    def __str__(self):
        return (f"{self.differing} of {self.pixels} pixels differ, {self.large} by more than {LARGE} of 255, "
                f"the most {self.largest}, mean {self.mean:.4f}")


LARGE = 8
MOST_DIFFERING = 0.005
MOST_LARGE = 0.001
LARGEST_MEAN = 0.02
