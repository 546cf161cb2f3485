#!/usr/bin/env python3
"""Writes the seeds of the fuzz targets: tests/fuzz/make_corpus.py FOLDER makes FOLDER/build and FOLDER/rays.

The bytes are in the order in which take_mesh() (mesh_bytes.cpp), take_ray() (ray_bytes.cpp) and the targets
read them. The same seeds each time; found inputs that are kept as regressions have names of their own.
"""
import pathlib
import random
import struct
import sys

NEVER = 0x00  # a byte for which ByteReader::rarely() is false
RAW = 0xFF  # a byte after which ByteReader::number() takes any four
TARGETS = 14  # of fuzz_rays
INF = float("inf")


def number(rng):
    """A byte of ByteReader::number(): a multiple of 1/16 in [-2, 2], sometimes an edge."""
    return bytes([rng.randrange(0xE0, 0xF6) if rng.random() < 0.05 else 112 + rng.randrange(-32, 33)])


def power(rng):
    return rng.randrange(256) if rng.random() < 0.2 else rng.randrange(-80, 81) & 0xFF


def aimed_ray(rng):
    time = bytes([rng.randrange(0xF8), rng.randrange(256)])
    target = bytes(rng.randrange(256) for _ in range(4))
    direction = number(rng) + number(rng) + number(rng)
    return (bytes([rng.randrange(0xD0), rng.randrange(256), NEVER]) + time + target + direction +
            bytes([power(rng), power(rng), NEVER, NEVER, NEVER]))


def raw_ray(rng):
    floats = [rng.choice([0.0, -0.0, 1.0, -1.0, 1e-42, 3e38, INF, float("nan"), rng.uniform(-2, 2)]) for _ in range(9)]
    return bytes([0xD0]) + struct.pack("<9fI", *floats, 0xFFFFFFFF)


def rays(rng, count):
    return b"".join(raw_ray(rng) if rng.random() < 0.2 else aimed_ray(rng) for _ in range(count))


def mesh(rng, steps, vertices, triangles):
    out = bytes([steps, vertices, triangles, NEVER])
    out += bytes(rng.randrange(0xFC) for _ in range(3 * triangles))
    out += rng.choice([bytes([0x00]), bytes([0x60, rng.randrange(4), rng.randrange(4, 8)])])  # time range
    out += bytes([NEVER, NEVER, NEVER])  # strides, counts
    out += bytes([power(rng), NEVER, rng.choice([0, 0, 60, 200])])  # scale, offset, tremble
    for _ in range(3 * vertices):
        out += number(rng) + (number(rng) if rng.random() < 0.7 else bytes([112]))
    overrides = rng.choice([0, 0, 0, 2])
    out += bytes([overrides])
    for _ in range(overrides):
        out += bytes([rng.randrange(max(steps, 1)), rng.randrange(3), vertices - 1, RAW]) + rng.randbytes(4)
    return out + bytes([NEVER, NEVER, NEVER, NEVER, rng.randrange(256)])


def build_seed(rng):
    flags = rng.randrange(16)
    cancel_at = rng.choice([0, 0, 1, 3, 7, 20])
    out = bytes([flags, cancel_at])
    if flags & 1:
        out += bytes([rng.choice([0, 2, 5])])
    meshes = rng.randrange(1, 5)
    out += bytes([meshes])
    for _ in range(meshes):
        steps = rng.choice([1, 1, 2, 3, 5, 9, 17, 64, 128, 129, 130])
        out += mesh(rng, steps, rng.randrange(3, 27), rng.randrange(1, 27))
    return out + rays(rng, 6)


def ray_seed(rng, target):
    return bytes([rng.randrange(2), target]) + rays(rng, 6)


def main():
    folder = pathlib.Path(sys.argv[1])
    rng = random.Random(1)
    for name in ("build", "rays"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    for i in range(60):
        (folder / "build" / f"seed_{i:02}").write_bytes(build_seed(rng))
    for i in range(4 * TARGETS):
        (folder / "rays" / f"seed_{i:02}").write_bytes(ray_seed(rng, i % TARGETS))


if __name__ == "__main__":
    main()
