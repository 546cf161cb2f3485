"""Meshes and the camera of an Alembic file, by alembic3d."""
import functools

import numpy as np
from alembic3d import Abc, AbcGeom

import shot_writer
from handover import CATMULL_CLARK, EDGES, EDGES_AND_CORNERS, NO_BOUNDARY, Faces, ShotProblem, chains
from shot_notes import Notes


DEEPEST = 200
EXISTING = Abc.WrapExistingFlag.kWrapExisting
BOUNDARIES = {0: NO_BOUNDARY, 1: EDGES_AND_CORNERS, 2: EDGES}  # as in RenderMan
NOT_SHOWN = "left out, as only meshes are read"
KEPT_SAMPLES = 4
FRAME_RATE = 24.0  # the files name none


def sample_at(sampling, index):
    """Selects a sample by its time: alembic3d takes a whole number for a time, too."""
    return Abc.ISampleSelector(float(sampling.getSampleTime(index)))


class Samples:
    """The values of an array property and their times."""

    def __init__(self, prop, shape=(-1,)):
        self.prop, self.shape = prop, shape
        self.count = prop.getNumSamples() if prop.valid() else 0
        self.sampling = prop.getTimeSampling() if self.count else None
        self.times = np.array([self.sampling.getSampleTime(i) for i in range(self.count)])
        if np.any(np.diff(self.times) <= 0) or not np.all(np.isfinite(self.times)):
            raise ShotProblem("has samples whose times do not go up")
        self.value = functools.lru_cache(KEPT_SAMPLES)(self._value)

    def _value(self, index):
        return np.array(self.prop.getValue(sample_at(self.sampling, int(index)))).reshape(self.shape)

    def before(self, time):
        """Number of the last sample that is not later than `time`, or of the first."""
        return max(int(np.searchsorted(self.times, time, "right")) - 1, 0)

    def held(self, time):
        return self.value(self.before(time)) if self.count else np.zeros(0)

    def between(self, time):
        """The sample before `time`, the one after it, and where `time` is between the two."""
        index = self.before(time)
        if index + 1 >= self.count or time <= self.times[index]:
            return index, index, 0.0
        return index, index + 1, (time - self.times[index]) / (self.times[index + 1] - self.times[index])


class Transform:
    """Matrices of one object, interpolated number by number, as usd-core does with matrices."""

    def __init__(self, schema):
        count = max(schema.getNumSamples(), 1) if not schema.isConstant() else 1
        sampling = schema.getTimeSampling()
        self.times = np.array([sampling.getSampleTime(i) for i in range(count)])
        if np.any(np.diff(self.times) <= 0):
            raise ShotProblem("has samples whose times do not go up")
        values = [schema.getValue(sample_at(sampling, i)) for i in range(count)]
        self.inherits = all(value.getInheritsXforms() for value in values)
        self.matrices = np.array([[list(row) for row in value.getMatrix()] for value in values])

    def is_moving(self):
        return len(self.times) > 1

    def matrix(self, time):
        index = max(int(np.searchsorted(self.times, time, "right")) - 1, 0)
        if index + 1 >= len(self.times) or time <= self.times[index]:
            return self.matrices[index]
        f = (time - self.times[index]) / (self.times[index + 1] - self.times[index])
        return self.matrices[index] + f * (self.matrices[index + 1] - self.matrices[index])


class Place:
    """The transforms above an object, and who may hide it."""

    def __init__(self, chain=(), hiders=()):
        self.chain, self.hiders = chain, hiders  # from the root on

    def below(self, transform):
        return Place((*self.chain, transform) if transform.inherits else (transform,), self.hiders)

    def hidden_by(self, hider):
        return Place(self.chain, (*self.hiders, hider))

    def times(self):
        return {float(time) for transform in self.chain if transform.is_moving() for time in transform.times}

    def matrix(self, time):
        matrix = np.eye(4)
        for transform in self.chain:
            matrix = transform.matrix(time) @ matrix
        return matrix

    def change_times(self):
        return {float(time) for hider in self.hiders if hider.count > 1 for time in hider.times}

    def is_seen(self, time):
        return all(hider.held(time)[0] != 0 for hider in self.hiders)


class MeshItem(shot_writer.Item):
    def __init__(self, name, schema, place, is_cage):
        self.name, self.schema, self.place, self.is_cage = name, schema, place, is_cage
        self.points = Samples(schema.getPositionsProperty(), (-1, 3))
        self.velocities = Samples(schema.getVelocitiesProperty(), (-1, 3))
        self.counts = Samples(schema.getFaceCountsProperty())
        self.corners = Samples(schema.getFaceIndicesProperty())
        if self.points.count == 0:
            raise ShotProblem("has no points")
        self.has_velocities = self.velocities.count > 0 and np.array_equal(self.velocities.times, self.points.times)
        self.changes = self.counts.count > 1 or self.corners.count > 1
        self.moves_without_velocities = self.changes and not self.has_velocities

    def material(self):
        return shot_writer.GREY

    def times(self):
        own = {float(time) for time in self.points.times} if self.points.count > 1 or self.has_velocities else set()
        return own | self.place.times()

    def change_times(self):
        own = {float(time) for samples in (self.counts, self.corners) if samples.count > 1 for time in samples.times}
        return own | self.place.change_times()

    def state(self, time):
        if not self.place.is_seen(time):
            return None
        return (self.counts.held(time).tobytes(), self.corners.held(time).tobytes()) if self.changes else "same"

    def faces(self, time):
        extra = self._cage(time) if self.is_cage else {}
        faces = Faces(self.counts.held(time), self.corners.held(time), **extra)
        # Alembic winds clockwise.
        return faces if np.linalg.det(self.place.matrix(time)[:3, :3]) < 0 else faces.turned_round()

    def _cage(self, time):
        schema = self.schema
        lengths, edges, sharpness, corners, corner_sharpness, holes = (
            Samples(prop).held(time) for prop in (
                schema.getCreaseLengthsProperty(), schema.getCreaseIndicesProperty(), schema.getCreaseSharpnessesProperty(),
                schema.getCornerIndicesProperty(), schema.getCornerSharpnessesProperty(), schema.getHolesProperty()))
        boundary = schema.getInterpolateBoundaryProperty()
        value = boundary.getValue(Abc.ISampleSelector()) if boundary.valid() and boundary.getNumSamples() else 0
        return {"scheme": CATMULL_CLARK, "boundary": BOUNDARIES.get(value, EDGES_AND_CORNERS),
                "creases": chains(lengths.astype(int), edges, sharpness),
                "sharp": (corners, corner_sharpness), "holes": holes}

    def _points(self, time):
        before, after, f = self.points.between(time)
        points = self.points.value(before).astype(np.float64)
        if self.has_velocities and len(self.velocities.value(before)) == len(points):
            return points + (time - self.points.times[before]) * self.velocities.value(before)
        if f == 0 or len(self.points.value(after)) != len(points):
            return points
        return points + f * (self.points.value(after) - points)

    def positions(self, time):
        matrix = self.place.matrix(time)
        return self._points(time) @ matrix[:3, :3] + matrix[3, :3]


class Archive:
    def __init__(self, notes):
        self.notes = notes
        self.items, self.cameras = [], []

    def visit(self, parent, place, depth=0):
        if depth > DEEPEST:
            raise ShotProblem(f"has objects that are more than {DEEPEST} deep in each other")
        for index in range(parent.getNumChildren()):
            try:
                self._visit_child(parent.getChild(index), place, depth)
            except ShotProblem as problem:
                self.notes.add(f"left out, for it {problem}", parent.getChildHeader(index).getFullName())
            except (RuntimeError, ValueError, IndexError, TypeError) as error:
                self.notes.add(f"left out ({' '.join(str(error).split())[:200]})", f"{parent.getFullName()}, child {index}")

    def _visit_child(self, child, place, depth):
        header, name = child.getHeader(), child.getFullName()
        visibility = AbcGeom.GetVisibilityProperty(child)
        if visibility.valid() and visibility.getNumSamples() > 0:
            place = place.hidden_by(Samples(visibility))
        if AbcGeom.IXform.matches(header):
            place = place.below(Transform(AbcGeom.IXform(child, EXISTING).getSchema()))
        elif AbcGeom.IPolyMesh.matches(header):
            self.items.append(MeshItem(name, AbcGeom.IPolyMesh(child, EXISTING).getSchema(), place, False))
        elif AbcGeom.ISubD.matches(header):
            self.items.append(MeshItem(name, AbcGeom.ISubD(child, EXISTING).getSchema(), place, True))
        elif AbcGeom.ICamera.matches(header):
            self.cameras.append((name, AbcGeom.ICamera(child, EXISTING).getSchema(), place))
        elif AbcGeom.IFaceSet.matches(header):
            self.notes.add("groups of faces are left out", name)
        else:
            for kind in (AbcGeom.ICurves, AbcGeom.IPoints, AbcGeom.INuPatch, AbcGeom.ILight):
                if kind.matches(header):
                    self.notes.add(f"{NOT_SHOWN} ({kind.__name__[1:]})", name)
        self.visit(child, place, depth + 1)


def write_camera(out, cameras, shutter, steps, notes):
    if not cameras:
        return
    for name, _, _ in cameras[1:]:
        notes.add("cameras but the first are left out", name)
    _, schema, place = cameras[0]

    def view_at(time):
        matrix = place.matrix(time)
        sample = schema.getValue(Abc.ISampleSelector(time))
        position, forward, up = matrix[3, :3], -matrix[2, :3], matrix[1, :3]
        # The aperture is in centimeters, the focal length in millimeters.
        height = 10 * sample.getVerticalAperture() / sample.getFocalLength()
        return position, position + forward / np.linalg.norm(forward), up, 2 * np.degrees(np.arctan(height / 2))

    is_moving = bool(place.times()) or schema.getNumSamples() > 1
    shot_writer.write_camera(out, shutter, steps if is_moving else 1, view_at)


def open_archive(file):
    with open(file, "rb") as opened:
        start = opened.read(8)
    if start[1:4] == b"HDF":
        raise ShotProblem("is an Alembic file in HDF5, which alembic3d does not read (abcconvert -toOgawa makes another)")
    try:
        return Abc.IArchive(file)
    except RuntimeError as error:
        raise ShotProblem(f"is not an Alembic file that alembic3d can read: {' '.join(str(error).split())}") from error


def read(file, out, asked, share):
    notes = Notes()
    archive = open_archive(file)
    found = Archive(notes)
    found.visit(archive.getTop(), Place())
    shutter = shot_writer.find_shutter(asked.in_time(1.0, 1.0 / FRAME_RATE), found.items, None)
    write_camera(out, found.cameras, shutter, asked.camera_steps, notes)
    shot_writer.write_items(out, notes, found.items, shutter, share)
    notes.hand_over(out)
