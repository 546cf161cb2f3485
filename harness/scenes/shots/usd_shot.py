"""Meshes, cameras and lights of a USD stage, by usd-core."""
import math
import re

import numpy as np
from pxr import Gf, Tf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel

import shot_writer
from handover import CATMULL_CLARK, EDGES, EDGES_AND_CORNERS, LOOP, NO_BOUNDARY, POLYGONS, WARNING, Faces, ShotProblem, chains
from shot_notes import Notes

SHOWN_PURPOSES = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
BOUNDARIES = {"none": NO_BOUNDARY, "edgeOnly": EDGES, "edgeAndCorner": EDGES_AND_CORNERS}
SCHEMES = {"none": POLYGONS, "bilinear": POLYGONS, "catmullClark": CATMULL_CLARK, "loop": LOOP}
MOST_ERRORS = 5
CACHED_NUMBERS = 20_000_000  # of matrices of instances


def attribute_times(attribute):
    if not attribute or not attribute.ValueMightBeTimeVarying():
        return []
    if attribute.HasSpline():
        return [float(time) for time in attribute.GetSpline().GetKnots().keys()]
    return attribute.GetTimeSamples()


def ancestors(prim, top=None):
    """From `prim` up to below `top`, or to the root."""
    while prim and not prim.IsPseudoRoot() and prim != top:
        yield prim
        prim = prim.GetParent()


def transform_times(prim, top=None):
    times = set()
    for above in ancestors(prim, top):
        xformable = UsdGeom.Xformable(above)
        if xformable:
            for op in xformable.GetOrderedXformOps():
                times.update(attribute_times(op.GetAttr()))
            if xformable.GetResetXformStack():
                break
    return times


def visibility_times(prim, top=None):
    times = set()
    for above in ancestors(prim, top):
        if above.IsA(UsdGeom.Imageable):
            times.update(attribute_times(UsdGeom.Imageable(above).GetVisibilityAttr()))
    return times


class World:
    """Where prims of the stage are, when they are not in an instancer's prototype."""

    def __init__(self, correction):
        self.correction = correction

    def times(self, prim):
        return transform_times(prim)

    def matrix(self, prim, time):
        return np.array(UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)) @ self.correction

    def change_times(self, prim):
        return visibility_times(prim)

    def is_seen(self, prim, time):
        return UsdGeom.Imageable(prim).ComputeVisibility(time) != UsdGeom.Tokens.invisible


class Instances:
    """All of one instancer."""

    def __init__(self, instancer, frame):
        self.instancer, self.frame, self.prim = instancer, frame, instancer.GetPrim()
        self.cache, self.cached = {}, 0
        moving = [instancer.GetPositionsAttr(), instancer.GetOrientationsAttr(), instancer.GetOrientationsfAttr(),
                  instancer.GetScalesAttr(), instancer.GetVelocitiesAttr(), instancer.GetAngularVelocitiesAttr(),
                  instancer.GetAccelerationsAttr()]
        self.motion_times = {time for attribute in moving for time in attribute_times(attribute)}
        chosen = [instancer.GetProtoIndicesAttr(), instancer.GetIdsAttr(), instancer.GetInvisibleIdsAttr()]
        self.choice_times = {time for attribute in chosen for time in attribute_times(attribute)}
        self.prototypes = [self.prim.GetStage().GetPrimAtPath(path)
                           for path in instancer.GetPrototypesRel().GetForwardedTargets()]

    def chosen(self, time):
        """The prototype's number for each instance, -1 where it is hidden."""
        key = ("chosen", time)
        if key not in self.cache:
            numbers = np.array(self.instancer.GetProtoIndicesAttr().Get(time) or [], np.int64)
            mask = np.array(self.instancer.ComputeMaskAtTime(time), bool)
            if len(mask) == len(numbers):
                numbers[~mask] = -1
            self._keep(key, numbers)
        return self.cache[key]

    def matrices(self, time):
        key = ("matrices", time)
        if key not in self.cache:
            self._keep(key, np.array(self.instancer.ComputeInstanceTransformsAtTime(
                time, time, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask)))
        return self.cache[key]

    def _keep(self, key, values):
        if self.cached > CACHED_NUMBERS:
            self.cache, self.cached = {}, 0
        self.cache[key] = values
        self.cached += values.size

    def count(self):
        return max((len(self.chosen(time)) for time in self.choice_times or {0.0}), default=0)

    def prototypes_of(self, instance):
        numbers = {int(chosen[instance]) for chosen in map(self.chosen, sorted(self.choice_times) or [0.0])
                   if instance < len(chosen)}
        return sorted(number for number in numbers if 0 <= number < len(self.prototypes))


class Instance:
    """Where prims of a prototype are in one instance of it."""

    def __init__(self, instances, number, prototype):
        self.instances, self.number, self.prototype = instances, number, prototype
        self.root = instances.prototypes[prototype]

    def times(self, prim):
        both = self.instances
        return transform_times(prim, self.root) | both.motion_times | transform_times(self.root) | both.frame.times(both.prim)

    def matrix(self, prim, time):
        inner = np.array(UsdGeom.XformCache(time).ComputeRelativeTransform(prim, self.root)[0])
        matrices = self.instances.matrices(time)
        if self.number >= len(matrices):
            raise ShotProblem("is in an instance that has no transform")
        return inner @ matrices[self.number] @ self.instances.frame.matrix(self.instances.prim, time)

    def change_times(self, prim):
        both = self.instances
        return visibility_times(prim, self.root.GetParent()) | both.choice_times | both.frame.change_times(both.prim)

    def is_seen(self, prim, time):
        chosen = self.instances.chosen(time)
        return (self.number < len(chosen) and chosen[self.number] == self.prototype
                and all(UsdGeom.Imageable(above).GetVisibilityAttr().Get(time) != UsdGeom.Tokens.invisible
                        for above in ancestors(prim, self.root.GetParent()) if above.IsA(UsdGeom.Imageable))
                and self.instances.frame.is_seen(self.instances.prim, time))


class MeshItem(shot_writer.Item):
    def __init__(self, prim, frame, name, material):
        self.mesh, self.prim, self.frame, self.name, self.material = UsdGeom.Mesh(prim), prim, frame, name, material
        mesh = self.mesh
        self.topology_times = {time for attribute in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr(),
                                                      mesh.GetHoleIndicesAttr()) for time in attribute_times(attribute)}
        self.has_velocities = mesh.GetVelocitiesAttr().HasAuthoredValue()
        # With velocities a single sample moves too.
        self.point_times = set(mesh.GetPointsAttr().GetTimeSamples() if self.has_velocities
                               else attribute_times(mesh.GetPointsAttr()))
        self.moves_without_velocities = bool(self.topology_times) and not self.has_velocities
        self.matrix_times = frame.times(prim)
        self.still_matrix = None if self.matrix_times else frame.matrix(prim, 0.0)
        self.still_points = None

    def times(self):
        return self.point_times | self.matrix_times

    def change_times(self):
        return self.topology_times | self.frame.change_times(self.prim)

    def state(self, time):
        if not self.frame.is_seen(self.prim, time):
            return None
        if not self.topology_times:
            return "same"
        counts, corners = self.mesh.GetFaceVertexCountsAttr().Get(time), self.mesh.GetFaceVertexIndicesAttr().Get(time)
        return np.array(counts or []).tobytes(), np.array(corners or []).tobytes()

    def faces(self, time):
        mesh = self.mesh
        scheme = SCHEMES.get(mesh.GetSubdivisionSchemeAttr().Get(), POLYGONS)
        extra = {}
        if scheme != POLYGONS:
            extra = {"boundary": BOUNDARIES.get(mesh.GetInterpolateBoundaryAttr().Get(), EDGES_AND_CORNERS),
                     "creases": creases(mesh, time),
                     "sharp": (mesh.GetCornerIndicesAttr().Get(time) or (), mesh.GetCornerSharpnessesAttr().Get(time) or ()),
                     "holes": np.array(mesh.GetHoleIndicesAttr().Get(time) or (), np.int64)}
        faces = Faces(mesh.GetFaceVertexCountsAttr().Get(time) or (), mesh.GetFaceVertexIndicesAttr().Get(time) or (),
                      scheme, **extra)
        is_left_handed = mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded
        is_mirrored = np.linalg.det(self._matrix(time)[:3, :3]) < 0
        return faces.turned_round() if is_left_handed != is_mirrored else faces

    def _matrix(self, time):
        return self.frame.matrix(self.prim, time) if self.still_matrix is None else self.still_matrix

    def _points(self, time):
        if self.still_points is not None:
            return self.still_points
        points = self.mesh.ComputePointsAtTime(time, time) if self.has_velocities else self.mesh.GetPointsAttr().Get(time)
        points = np.array(points or np.zeros((0, 3)), np.float64).reshape(-1, 3)
        if not self.point_times:
            self.still_points = points
        return points

    def positions(self, time):
        matrix = self._matrix(time)
        return self._points(time) @ matrix[:3, :3] + matrix[3, :3]


def creases(mesh, time):
    lengths = mesh.GetCreaseLengthsAttr().Get(time) or ()
    vertices = mesh.GetCreaseIndicesAttr().Get(time) or ()
    given = mesh.GetCreaseSharpnessesAttr().Get(time) or ()
    return chains(lengths, vertices, given)


class Stage:
    def __init__(self, stage, notes):
        self.stage, self.notes = stage, notes
        self.items, self.cameras, self.lights = [], [], []
        self.colors = {}
        self.correction = world_correction(stage)

    def visit(self, root, frame, name, instancers=()):
        """`name` goes before the paths of what is in an instance; `instancers` are those that `root` is in."""
        predicate = Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded) if instancers else \
            Usd.TraverseInstanceProxies()
        prims = iter(Usd.PrimRange(root, predicate))
        for prim in prims:
            if prim.IsA(UsdGeom.Imageable) and UsdGeom.Imageable(prim).ComputePurpose() not in SHOWN_PURPOSES:
                continue
            if prim.IsA(UsdGeom.PointInstancer):
                prims.PruneChildren()
                self._visit_instances(prim, frame, name, instancers)
            elif prim.IsA(UsdGeom.Mesh):
                self._add_mesh(prim, frame, name)
            elif prim.IsA(UsdGeom.Gprim):
                self.notes.add(f"left out, as only meshes are read ({prim.GetTypeName()})", name + str(prim.GetPath()))
            elif prim.IsA(UsdGeom.Camera) and not instancers:
                self.cameras.append(prim)
            elif prim.HasAPI(UsdLux.LightAPI) and not instancers:
                self.lights.append(prim)

    def _visit_instances(self, prim, frame, name, instancers):
        path = prim.GetPath()
        if path in instancers:
            self.notes.add("left out, as it is an instance of itself", str(path))
            return
        try:
            instances = Instances(UsdGeom.PointInstancer(prim), frame)
            if len(self.items) + instances.count() > shot_writer.MOST_MESHES:
                raise ShotProblem(f"has more than {shot_writer.MOST_MESHES} instances")
            for number in range(instances.count()):
                for prototype in instances.prototypes_of(number):
                    self.visit(instances.prototypes[prototype], Instance(instances, number, prototype),
                               f"{name}{path}[{number}]", (*instancers, path))
        except (ShotProblem, Tf.ErrorException, RuntimeError, TypeError, ValueError) as error:
            self.notes.add(f"left out ({' '.join(str(error).split())[:200]})", name + str(path))

    def _add_mesh(self, prim, frame, name):
        try:
            self.items.append(MeshItem(prim, frame, name + str(prim.GetPath()), lambda: self._material(prim)))
        except (ShotProblem, Tf.ErrorException, RuntimeError, TypeError, ValueError) as error:
            self.notes.add(f"left out ({' '.join(str(error).split())[:200]})", name + str(prim.GetPath()))

    def _material(self, prim):
        color = self._display_color(prim)
        emission = (0.0, 0.0, 0.0)
        if UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(prim)):
            self.notes.add("materials of single faces are left out", str(prim.GetPath()))
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        shader = material.ComputeSurfaceSource()[0] if material else None
        if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface":
            color = self._constant(shader, "diffuseColor") or color
            emission = self._constant(shader, "emissiveColor") or emission
        elif shader:
            self.notes.add("materials other than UsdPreviewSurface are read as diffuse", str(material.GetPath()))
        return *(min(max(c, 0.0), 1.0) for c in color), *emission

    def _constant(self, shader, name):
        entry = shader.GetInput(name)
        if not entry:
            return None
        if entry.HasConnectedSource():
            self.notes.add("textures are left out", str(shader.GetPath()))
            return None
        value = entry.Get()
        return tuple(value) if value is not None else None

    def _display_color(self, prim):
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
        colors = primvar.Get(Usd.TimeCode.EarliestTime()) if primvar else None
        if not colors:
            return shot_writer.GREY[:3]
        if any(color != colors[0] for color in colors):
            self.notes.add("colors that vary over a mesh are left out, but for the first", str(prim.GetPath()))
        return tuple(colors[0])


def world_correction(stage):
    """To meters, and y up."""
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    matrix = np.diag([scale, scale, scale, 1.0])
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        matrix = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]) @ matrix
    return matrix


def open_stage(file, out):
    try:
        stage = Usd.Stage.Open(file)
    except Tf.ErrorException as error:
        # What the parser says stands first, in quotes behind its own place.
        first = str(error).strip().splitlines()[0]
        raise ShotProblem("cannot be read: " + first.partition(" : ")[2].strip("' ")) from error
    errors = stage.GetCompositionErrors()
    for error in errors[:MOST_ERRORS]:
        out.text(WARNING, f"{error.rootSite.path}: {without_layers(str(error))}")
    if len(errors) > MOST_ERRORS:
        out.text(WARNING, f"{len(errors) - MOST_ERRORS} more references and payloads cannot be followed")
    return stage


def without_layers(text):
    """The session's layer is a name that only this run knows."""
    return re.sub(r",?@anon:[^@]*@", "", " ".join(text.split()))[:400]


def bake_skins(stage, notes):
    """Skins and blend shapes become samples of points, in a layer of this run; instances are made single for it."""
    stage.SetEditTarget(stage.GetSessionLayer())
    while True:
        instances = [prim for prim in stage.Traverse() if prim.IsInstance() and any(
            inner.IsA(UsdSkel.Root) or inner.HasAPI(UsdSkel.BindingAPI) for inner in Usd.PrimRange(prim.GetPrototype()))]
        if not instances:
            break
        for prim in instances:
            prim.SetInstanceable(False)
    roots = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)]
    for root in roots:
        try:
            UsdSkel.BakeSkinning(Usd.PrimRange(root), Gf.Interval.GetFullInterval())
        except (Tf.ErrorException, RuntimeError) as error:
            notes.add(f"is shown without its skins ({' '.join(str(error).split())[:200]})", str(root.GetPath()))


def stage_range(stage, cameras):
    """The range that it names; of one frame, the time that its first camera's shutter is open; None where it names none."""
    if not stage.HasAuthoredTimeCodeRange():
        return None
    begin, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    if begin == end and cameras:
        camera = UsdGeom.Camera(cameras[0])
        opening, closing = camera.GetShutterOpenAttr().Get(begin), camera.GetShutterCloseAttr().Get(begin)
        if opening is not None and closing is not None and opening < closing:
            return begin + opening, begin + closing
    return (begin, end) if begin <= end else None


def write_camera(out, cameras, shutter, steps, world, notes):
    perspective = [prim for prim in cameras if UsdGeom.Camera(prim).GetProjectionAttr().Get() == UsdGeom.Tokens.perspective]
    for prim in cameras:
        if prim not in perspective:
            notes.add("orthographic cameras are left out", str(prim.GetPath()))
    if not perspective:
        return
    for prim in perspective[1:]:
        notes.add("cameras but the first are left out", str(prim.GetPath()))
    prim = perspective[0]
    camera = UsdGeom.Camera(prim)
    lens = [camera.GetFocalLengthAttr(), camera.GetVerticalApertureAttr()]
    is_moving = bool(transform_times(prim)) or any(attribute_times(attribute) for attribute in lens)

    def view_at(time):
        matrix = world.matrix(prim, time)
        position, forward, up = matrix[3, :3], -matrix[2, :3], matrix[1, :3]
        forward = forward / np.linalg.norm(forward)
        return position, position + forward, up, camera.GetCamera(time).GetFieldOfView(Gf.Camera.FOVVertical)

    shot_writer.write_camera(out, shutter, steps if is_moving else 1, view_at)


def write_lights(out, lights, shutter, world, notes):
    """Suns and plain skies, as they are when the shutter opens."""
    for prim in lights:
        light = UsdLux.LightAPI(prim)
        if UsdGeom.Imageable(prim).ComputeVisibility(shutter.begin) == UsdGeom.Tokens.invisible:
            continue
        radiance = np.array(light.GetColorAttr().Get(shutter.begin)) * light.GetIntensityAttr().Get(shutter.begin) * \
            2.0 ** light.GetExposureAttr().Get(shutter.begin)
        if prim.IsA(UsdLux.DistantLight):
            half_angle = UsdLux.DistantLight(prim).GetAngleAttr().Get(shutter.begin) / 2
            # Radiance of its disc, or, where it has no disc or says so, what falls on a surface.
            disc = math.pi * math.sin(math.radians(half_angle)) ** 2
            irradiance = radiance if disc == 0 or light.GetNormalizeAttr().Get(shutter.begin) else radiance * disc
            out.sun(-world.matrix(prim, shutter.begin)[2, :3], irradiance, half_angle)
        elif prim.IsA(UsdLux.DomeLight) or prim.IsA(UsdLux.DomeLight_1):
            if prim.GetAttribute("inputs:texture:file").Get():
                notes.add("pictures of skies are left out", str(prim.GetPath()))
            out.sky(radiance)
        else:
            notes.add(f"left out, as only distant and dome lights are read ({prim.GetTypeName()})", str(prim.GetPath()))


def read(file, out, asked, share):
    notes = Notes()
    stage = open_stage(file, out)
    bake_skins(stage, notes)
    found = Stage(stage, notes)
    world = World(found.correction)
    found.visit(stage.GetPseudoRoot(), world, "")
    rate = stage.GetTimeCodesPerSecond() or 24.0
    shutter = shot_writer.find_shutter(asked.in_time(rate, 1.0), found.items, stage_range(stage, found.cameras))
    write_camera(out, found.cameras, shutter, asked.camera_steps, world, notes)
    write_lights(out, found.lights, shutter, world, notes)
    shot_writer.write_items(out, notes, found.items, shutter, share)
    notes.hand_over(out)
