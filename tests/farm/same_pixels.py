#!/usr/bin/env python3
"""Whether pictures of two folders have the same bits in every channel.

Usage: same_pixels.py FOLDER OTHER     (every *.exr of FOLDER, with the file of that name in OTHER)
The files are those of stbvh-ab: lines from the top down, compressed alike. So the same pixels are the same bytes, and what
may differ is what files say of their run. Ends with exit code 1 and a line for each picture that differs.
"""
import pathlib
import struct
import sys

STRINGS = "string"  # attributes of this kind tell of the scene and of the run
MAGIC = 20000630
LINES_OF_BLOCK = {0: 1, 1: 1, 2: 1, 3: 16}  # by compression: none, RLE, ZIPS, ZIP


def text_at(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def parts(path):
    """The header but for strings, by name, and the blocks of pixels, in order."""
    data = path.read_bytes()
    assert struct.unpack_from("<I", data)[0] == MAGIC, path
    at, header = 8, {}
    while data[at]:
        name, at = text_at(data, at)
        kind, at = text_at(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        if kind != STRINGS:
            header[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    _, top, _, bottom = struct.unpack("<4i", header["dataWindow"])
    count = -(-(bottom - top + 1) // LINES_OF_BLOCK[header["compression"][0]])
    blocks = []
    for (offset,) in struct.iter_unpack("<Q", data[at + 1:at + 1 + 8 * count]):
        _, size = struct.unpack_from("<ii", data, offset)
        blocks.append(data[offset:offset + 8 + size])
    return header, blocks


def difference(a, b):
    """In words; empty: there is none."""
    (header_a, blocks_a), (header_b, blocks_b) = parts(a), parts(b)
    for name in sorted(header_a.keys() | header_b.keys()):
        if header_a.get(name) != header_b.get(name):
            return f"{name} is another"
    pairs = zip(blocks_a, blocks_b, strict=True)
    return next((f"rows from {struct.unpack_from('<i', a)[0]} on differ" for a, b in pairs if a != b), "")


def differences(folder, other):
    """A line for each picture of `folder` that differs from that in `other`; and how many there are."""
    files = sorted(folder.glob("*.exr"))
    lines = []
    for file in files:
        found = difference(file, other / file.name) if (other / file.name).exists() else "is not there"
        lines += [f"{file.name}: {found}"] if found else []
    return lines, len(files)


if __name__ == "__main__":
    found_lines, pictures = differences(*map(pathlib.Path, sys.argv[1:3]))
    print(*found_lines, f"{pictures} pictures, {len(found_lines)} differ", sep="\n")
    sys.exit(1 if found_lines or pictures == 0 else 0)
