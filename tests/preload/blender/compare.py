"""Run by Blender: how pairs of OpenEXR pictures differ, as a line of JSON for each.

blender -b --factory-startup -P compare.py -- A.exr B.exr [C.exr D.exr ...]"""

import json
import sys

import bpy


def read(path):
    """The pixels, as tuples of red, green and blue."""
    picture = bpy.data.images.load(path)
    picture.colorspace_settings.name = "Non-Color"
    values, channels = picture.pixels[:], picture.channels
    return list(zip(values[0::channels], values[1::channels], values[2::channels]))


def mean(pixels):
    return sum(map(sum, pixels)) / (3 * len(pixels))


def difference(first, second):
    if len(first) != len(second):
        sys.exit("the pictures differ in size")
    changes = [max(abs(a - b) for a, b in zip(p, q)) / max(1e-2, *p, *q) for p, q in zip(first, second)]
    return {
        "pixels": len(first),
        "distinct": len(set(first)),
        "green": sum(g > 1.5 * max(r, b) for r, g, b in first),
        "any": sum(change > 0 for change in changes),
        "above_1e-4": sum(change > 1e-4 for change in changes),
        "above_1e-2": sum(change > 1e-2 for change in changes),
        "mean_relative": abs(mean(first) - mean(second)) / mean(first),
    }


names = sys.argv[sys.argv.index("--") + 1:]
for pair in zip(names[0::2], names[1::2]):
    print("DIFFERENCE " + json.dumps(difference(*map(read, pair))))
