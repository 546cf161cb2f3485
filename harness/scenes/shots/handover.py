"""What a reader of shots hands over to the program: records in a binary file (shot_records.h has the other side).

After the magic each record has a tag, four bytes of zeros and its length, and then its bytes; all numbers are little-endian.
Each is written whole before the next begins, so that what was read is not lost where a library crashes.
"""
import os
import struct

import numpy as np

MAGIC = b"STBVSHT1"
END, MESH, CAMERA, SUN, SKY, WARNING, PROBLEM = range(7)
MOST_BYTES = 24 << 30  # as for all scene files

POLYGONS, CATMULL_CLARK, LOOP = range(3)
NO_BOUNDARY, EDGES, EDGES_AND_CORNERS = range(3)


class ShotProblem(Exception):
    """What keeps a file, or one thing in it, from being read: the text goes behind its name."""


class Faces:
    """The polygons of a mesh, or its cage with all that OpenSubdiv asks for."""

    def __init__(self, sizes, corners, scheme=POLYGONS, boundary=EDGES_AND_CORNERS, creases=((), ()), sharp=((), ()), holes=()):
        self.sizes = np.asarray(sizes, np.int64)
        self.corners = np.asarray(corners, np.int64)
        self.scheme = scheme
        self.boundary = boundary
        self.crease_edges, self.crease_sharpness = np.asarray(creases[0], np.int64).reshape(-1, 2), creases[1]
        self.sharp_vertices, self.vertex_sharpness = sharp
        self.holes = holes
        if len(self.sizes) == 0:
            raise ShotProblem("has no faces")
        if self.sizes.min() < 0 or self.sizes.sum() != len(self.corners):
            raise ShotProblem("has faces whose corners do not add up")
        if len(self.corners) and self.corners.min() < 0:
            raise ShotProblem("has a face with a corner below 0")

    def vertex_count(self):
        """Of positions that the faces need."""
        return int(self.corners.max()) + 1 if len(self.corners) else 0

    def turned_round(self):
        """Wound the other way; each face keeps its first corner."""
        ends = np.cumsum(self.sizes)
        firsts = np.repeat(ends - self.sizes, self.sizes)
        place = np.arange(len(self.corners)) - firsts
        turned = np.copy(self.corners)
        turned[:] = self.corners[firsts + (-place) % np.repeat(self.sizes, self.sizes)]
        other = object.__new__(Faces)
        other.__dict__ = {**self.__dict__, "corners": turned}
        return other


def chains(lengths, vertices, given):
    """Creases as files have them: a chain of vertices has one sharpness, or one for each edge."""
    edges, sharpness = [], []
    first = edge = 0
    for chain, length in enumerate(lengths):
        for i in range(first, first + length - 1):
            edges.append((vertices[i], vertices[i + 1]))
            sharpness.append(given[chain] if len(given) == len(lengths) else given[edge])
            edge += 1
        first += length
    return edges, sharpness


class Handover:
    def __init__(self, descriptor):
        self.descriptor = descriptor
        self.written = 0
        self._put([MAGIC])

    def _put(self, pieces):
        for piece in pieces:
            view = memoryview(piece).cast("B")
            while len(view):
                view = view[os.write(self.descriptor, view[: 1 << 30]):]

    def _record(self, tag, pieces):
        size = sum(memoryview(piece).nbytes for piece in pieces)
        self.written += size
        if self.written > MOST_BYTES:
            raise ShotProblem(f"needs more than {MOST_BYTES >> 30} GB")
        self._put([struct.pack("<IIQ", tag, 0, size), *pieces])

    def text(self, tag, text):
        self._record(tag, [" ".join(text.split()).encode("utf-8", "replace")])

    def mesh(self, name, faces, material, times, steps):
        """`times` of rays, one for each step; those of one step have none."""
        name = name.encode("utf-8", "replace")
        head = struct.pack("<IIIIQQQQQQQ6f", len(name), faces.scheme, faces.boundary, 0, len(steps[0]), len(faces.sizes),
                           len(faces.corners), len(steps), len(faces.crease_edges), len(faces.sharp_vertices),
                           len(faces.holes), *material)
        arrays = [(faces.sizes, "<u4"), (faces.corners, "<u4"), (faces.crease_edges, "<u4"), (faces.crease_sharpness, "<f4"),
                  (faces.sharp_vertices, "<u4"), (faces.vertex_sharpness, "<f4"), (faces.holes, "<u4"),
                  (times if len(steps) > 1 else (), "<f4")]
        self._record(MESH, [head, name, *(np.ascontiguousarray(a, kind) for a, kind in arrays if len(a)),
                            *(np.ascontiguousarray(step, "<f4") for step in steps)])

    def camera(self, steps):
        """Each: position, target, up and the vertical angle in degrees, ten numbers; equidistant over the shutter."""
        self._record(CAMERA, [np.ascontiguousarray(steps, "<f4")])

    def sun(self, direction, irradiance, half_angle):
        self._record(SUN, [struct.pack("<7f", *direction, *irradiance, half_angle)])

    def sky(self, radiance):
        self._record(SKY, [struct.pack("<3f", *radiance)])

    def end(self):
        self._record(END, [])
