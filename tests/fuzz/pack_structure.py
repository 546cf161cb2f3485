#!/usr/bin/env python3
"""Packs files of saved structures (stbvh-ab build) into inputs of fuzz_structure: pack_structure.py FILE.stbvh... -o FOLDER."""
import argparse
import os
import struct

HEADER = 272  # sizeof(FileHeader), kernels/saved/file_format.h
SECTIONS = 24  # where block, tables, buffers and user stand in it: offset and bytes each


def pack(data):
    parts = []
    for i in range(4):
        offset, size = struct.unpack_from("<QQ", data, SECTIONS + 16 * i)
        parts.append(data[offset:offset + size])
    return data[:HEADER] + struct.pack("<4H", *(len(p) for p in parts)) + b"".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    os.makedirs(arguments.output, exist_ok=True)
    for path in arguments.files:
        with open(path, "rb") as file:
            data = file.read()
        with open(os.path.join(arguments.output, os.path.splitext(os.path.basename(path))[0]), "wb") as out:
            out.write(pack(data))


if __name__ == "__main__":
    main()
