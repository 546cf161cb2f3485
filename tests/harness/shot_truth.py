#!/usr/bin/env python3
"""How far what read_shot.py handed over is from what the libraries say at 50 times, of the diagonal: usd-core evaluates,
alembic3d finds the samples around a time.

Usage: shot_truth.py FILE HANDOVER [A,B], with the Python of the shots; A,B: the shutter of an Alembic file.
Prints the share, and how many meshes were compared.
It finds its way through the stage by the names of the meshes, and shares no code with the reader.
"""
import re
import struct
import sys

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel

HEAD = "<IIIIQQQQQQQ6f"


def mesh_records(file):
    data = open(file, "rb").read()
    at = 8
    while at < len(data):
        tag, _, size = struct.unpack_from("<IIQ", data, at)
        if tag == 1:
            yield data[at + 16:at + 16 + size]
        at += 16 + size


def read_mesh(data):
    """Name, ray times, steps."""
    name_bytes, _, _, _, vertices, faces, corners, steps, edges, sharp, holes, *_ = struct.unpack_from(HEAD, data)
    at = struct.calcsize(HEAD)
    name = data[at:at + name_bytes].decode()
    at += name_bytes + 4 * (faces + corners + 3 * edges + 2 * sharp + holes)
    times = np.frombuffer(data, "<f4", steps if steps > 1 else 0, at)
    at += times.nbytes
    return name, times, np.frombuffer(data, "<f4", 3 * vertices * steps, at).reshape(steps, vertices, 3)


def handed_over(times, steps, time):
    """Where the mesh is at a ray time; None where it is not there."""
    if len(steps) == 1:
        return steps[0].astype(float)
    if not times[0] <= time <= times[-1]:
        return None
    after = int(np.clip(np.searchsorted(times, time), 1, len(times) - 1))
    f = (time - float(times[after - 1])) / (float(times[after]) - float(times[after - 1]))
    return steps[after - 1] + f * (steps[after].astype(float) - steps[after - 1])


def true_points(stage, name, time):
    """In the stage's own units; None where it cannot be seen."""
    instancer_path, number, path = re.fullmatch(r"(?:(.*)\[(\d+)\])?(.*)", name).groups()
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(path))
    cache = UsdGeom.XformCache(time)
    if instancer_path is None:
        if mesh.ComputeVisibility(time) == "invisible":
            return None
        matrix = cache.GetLocalToWorldTransform(mesh.GetPrim())
    else:
        instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath(instancer_path))
        matrix = instancer.ComputeInstanceTransformsAtTime(time, time, instancer.IncludeProtoXform, instancer.IgnoreMask)[
            int(number)] * cache.GetLocalToWorldTransform(instancer.GetPrim())
        # The transform of the prototype's root is in it.
        prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
        root = stage.GetPrimAtPath(next(p for p in prototypes if mesh.GetPath().HasPrefix(p)))
        matrix = cache.ComputeRelativeTransform(mesh.GetPrim(), root)[0] * matrix
    points = np.array(mesh.ComputePointsAtTime(time, time), float).reshape(-1, 3)
    return np.array([list(matrix.Transform(Gf.Vec3d(*point))) for point in points])


class Archive:
    def __init__(self, file):
        from alembic3d import Abc, AbcGeom
        self.archive, self.at, self.geom = Abc.IArchive(file), Abc.ISampleSelector, AbcGeom
        self.wrap = Abc.WrapExistingFlag.kWrapExisting
        self.begin, self.end = Abc.GetArchiveStartAndEndTime(self.archive)

    def around(self, schema, time, value):
        """`value` of the samples before and after `time`, with the time of the first and where between the two `time` is."""
        sampling, count = schema.getTimeSampling(), schema.getNumSamples()
        begin, end = (sampling.getSampleTime(find(time, count)) for find in (sampling.getFloorIndex, sampling.getCeilIndex))
        part = (time - begin) / (end - begin) if begin < time < end else 0.0
        first, last = (np.array(value(schema.getValue(self.at(t))), float) for t in (begin, end))
        return first, last, begin, part

    def points(self, name, time):
        found, matrix = self.archive.getTop(), np.eye(4)
        for part in name.strip("/").split("/"):
            found = found.getChild(part)
            if self.geom.IXform.matches(found.getHeader()):
                schema = self.geom.IXform(found, self.wrap).getSchema()
                first, last, _, f = self.around(schema, time, lambda value: [list(row) for row in value.getMatrix()])
                matrix = (first * (1 - f) + last * f) @ matrix
        mesh = self.geom.IPolyMesh(found, self.wrap).getSchema()
        first, last, begin, f = self.around(mesh, time, lambda value: value.getPositions())
        if mesh.getVelocitiesProperty().valid():
            points = first + (time - begin) * np.array(mesh.getValue(self.at(begin)).getVelocities(), float)
        else:
            points = first * (1 - f) + last * f
        return points @ matrix[:3, :3] + matrix[3, :3]


def alembic_main():
    archive = Archive(sys.argv[1])
    begin, end = map(float, sys.argv[3].split(",")) if len(sys.argv) > 3 else (archive.begin, archive.end)
    worst, low, high, records = 0.0, np.full(3, np.inf), np.full(3, -np.inf), list(map(read_mesh, mesh_records(sys.argv[2])))
    for i in range(50):
        ray_time = (i + 0.382) / 50
        for name, times, steps in records:
            truth = archive.points(name, begin + ray_time * (end - begin))
            worst = max(worst, np.linalg.norm(handed_over(times, steps, ray_time) - truth, axis=1).max())
            low, high = np.minimum(low, truth.min(axis=0)), np.maximum(high, truth.max(axis=0))
    print(worst / np.linalg.norm(high - low), len(records))


def main():
    if sys.argv[1].endswith(".abc"):
        alembic_main()
        return
    stage = Usd.Stage.Open(sys.argv[1])
    stage.SetEditTarget(stage.GetSessionLayer())
    for prim in list(stage.Traverse()):
        if prim.IsA(UsdSkel.Root):
            UsdSkel.BakeSkinning(Usd.PrimRange(prim), Gf.Interval.GetFullInterval())
    begin, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    if not stage.HasAuthoredTimeCodeRange():
        times = [t for prim in stage.Traverse() for attribute in prim.GetAttributes() for t in attribute.GetTimeSamples()
                 if prim.IsA(UsdGeom.Mesh) and attribute.GetName() in ("points", "faceVertexCounts")]
        begin, end = min(times), max(times)
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    is_z_up = UsdGeom.GetStageUpAxis(stage) == "Z"
    records = [read_mesh(data) for data in mesh_records(sys.argv[2])]
    worst, low, high = 0.0, np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(50):
        ray_time = (i + 0.382) / 50
        seen = {}
        for name, times, steps in records:
            seen.setdefault(name, []).append(handed_over(times, steps, ray_time))
        for name, parts in seen.items():
            truth = true_points(stage, name, begin + ray_time * (end - begin))
            parts = [part for part in parts if part is not None]
            if len(parts) != (truth is not None):
                sys.exit(f"{name} is there {len(parts)} times at ray time {ray_time}")
            if truth is None:
                continue
            truth = truth * scale
            if is_z_up:
                truth = truth[:, [0, 2, 1]] * [1, 1, -1]
            truth = truth[:len(parts[0])]
            worst = max(worst, np.linalg.norm(parts[0] - truth, axis=1).max())
            low, high = np.minimum(low, truth.min(axis=0)), np.maximum(high, truth.max(axis=0))
    print(worst / np.linalg.norm(high - low), len(records))


if __name__ == "__main__":
    main()
