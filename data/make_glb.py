#!/usr/bin/env python3
"""Makes the animated .glb files of this folder, and expected/*.bin: where their vertices are at some times.

    python3 data/make_glb.py        writes beside itself; the same bytes every time

The expected positions are computed here from the numbers that go into the files, with code of its own (plain Python,
double precision), so that the C++ loader is compared with something it shares nothing with.
"""
import json
import math
import pathlib
import struct

FOLDER = pathlib.Path(__file__).resolve().parent
STEPS = 7
BYTE, UBYTE, SHORT, USHORT, UINT, FLOAT = 5120, 5121, 5122, 5123, 5125, 5126
FORMAT = {BYTE: "b", UBYTE: "B", SHORT: "h", USHORT: "H", UINT: "I", FLOAT: "f"}
TRIANGLES, STRIP, FAN = 4, 5, 6


def f32(x):
    """Rounded to single precision, element by element."""
    if isinstance(x, (list, tuple)):
        return [f32(e) for e in x]
    return struct.unpack("<f", struct.pack("<f", x))[0]


# ---- writing -----------------------------------------------------------------------------------------------------

class Glb:
    """A glTF document that grows; rows are lists of numbers, one for each element of an accessor."""

    def __init__(self):
        self.binary = bytearray()
        self.doc = {"asset": {"version": "2.0", "generator": "STBVH data/make_glb.py"}, "scene": 0,
                    "scenes": [{"nodes": [0]}], "nodes": [], "meshes": [], "accessors": [], "bufferViews": [],
                    "materials": [], "animations": [{"name": "", "channels": [], "samplers": []}]}

    def view(self, data, stride=0):
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        if stride:
            view["byteStride"] = stride
        self.binary += data
        return self.add("bufferViews", view)

    def add(self, kind, item):
        self.doc.setdefault(kind, []).append(item)
        return len(self.doc[kind]) - 1

    def accessor(self, rows, component=FLOAT, normalized=False, view=None, offset=0, bounds=False):
        """Tightly packed in a view of its own, unless `view` already holds the rows at `offset`."""
        rows = [r if isinstance(r, (list, tuple)) else [r] for r in rows]
        width = len(rows[0])
        if view is None:
            view = self.view(b"".join(struct.pack("<%d%s" % (width, FORMAT[component]), *r) for r in rows))
        accessor = {"bufferView": view, "componentType": component, "count": len(rows),
                    "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[width]}
        if offset:
            accessor["byteOffset"] = offset
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor["min"] = [min(r[i] for r in rows) for i in range(width)]
            accessor["max"] = [max(r[i] for r in rows) for i in range(width)]
        return self.add("accessors", accessor)

    def sparse(self, count, places, rows):
        """Zero but at `places`, without a view for the rest."""
        accessor = {"componentType": FLOAT, "count": count, "type": "VEC3",
                    "min": [min([0] + [r[i] for r in rows]) for i in range(3)],
                    "max": [max([0] + [r[i] for r in rows]) for i in range(3)],
                    "sparse": {
                        "count": len(places),
                        "indices": {"bufferView": self.view(struct.pack("<%dH" % len(places), *places)),
                                    "componentType": USHORT},
                        "values": {"bufferView": self.view(b"".join(struct.pack("<3f", *r) for r in rows))}}}
        return self.add("accessors", accessor)

    def material(self, r, g, b):
        return self.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1], "metallicFactor": 0}})

    def animate(self, node, path, times, values, interpolation, component=FLOAT, normalized=False):
        animation = self.doc["animations"][0]
        animation["samplers"].append({"input": self.accessor(times, bounds=True), "interpolation": interpolation,
                                      "output": self.accessor(values, component, normalized)})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1,
                                      "target": {"node": node, "path": path}})

    def write(self, name, clip):
        self.doc["animations"][0]["name"] = clip
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.doc["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.doc, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        with open(FOLDER / (name + ".glb"), "wb") as out:
            out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self.binary)))
            out.write(struct.pack("<I4s", len(text), b"JSON") + text)
            out.write(struct.pack("<I4s", len(self.binary), b"BIN\0") + bytes(self.binary))


def write_expected(name, clip_end, triangles, positions_at):
    """counts; triangles; positions of all vertices at STEPS equidistant times from 0 to clip_end."""
    steps = [positions_at(clip_end * i / (STEPS - 1)) for i in range(STEPS)]
    (FOLDER / "expected").mkdir(exist_ok=True)
    with open(FOLDER / "expected" / (name + ".bin"), "wb") as out:
        out.write(struct.pack("<3I", STEPS, len(steps[0]), len(triangles)))
        for triangle in triangles:
            out.write(struct.pack("<3I", *triangle))
        for step in steps:
            for p in step:
                out.write(struct.pack("<3f", *p))


# ---- evaluating --------------------------------------------------------------------------------------------------

def segment(times, t):
    """Number of the key at or before t, and where between it and the next; (key, 0) outside."""
    if t < times[0]:
        return 0, 0.0
    for i in range(len(times) - 1):
        if t < times[i + 1]:
            return i, (t - times[i]) / (times[i + 1] - times[i])
    return len(times) - 1, 0.0


def step_key(times, values, t):
    return values[segment(times, t)[0]]


def linear(times, values, t):
    i, f = segment(times, t)
    return values[i] if f == 0 else [(1 - f) * a + f * b for a, b in zip(values[i], values[i + 1])]


def spherical(times, values, t):
    """Turns a by the f-th part of the rotation from a to b: another way to the slerp than the loader's."""
    i, f = segment(times, t)
    if f == 0:
        return unit(values[i])
    a, b = unit(values[i]), unit(values[i + 1])
    x, y, z, w = product(b, [-a[0], -a[1], -a[2], a[3]])
    if w < 0:
        x, y, z, w = -x, -y, -z, -w
    sine = math.sqrt(x * x + y * y + z * z)
    half = f * math.atan2(sine, w)
    s = math.sin(half) / sine if sine else 0.0
    return product([x * s, y * s, z * s, math.cos(half)], a)


def cubic(times, rows, t):
    """rows: in-tangent, value, out-tangent of each key. By de Casteljau on the equivalent Bezier curve."""
    i, f = segment(times, t)
    if f == 0:
        return rows[3 * i + 1]
    d = (times[i + 1] - times[i]) / 3
    v0, o0, i1, v1 = rows[3 * i + 1], rows[3 * i + 2], rows[3 * i + 3], rows[3 * i + 4]
    points = [v0, [v + d * o for v, o in zip(v0, o0)], [v - d * k for v, k in zip(v1, i1)], v1]
    while len(points) > 1:
        points = [[(1 - f) * a + f * b for a, b in zip(p, q)] for p, q in zip(points, points[1:])]
    return points[0]


def unit(q):
    length = math.sqrt(sum(x * x for x in q))
    return [x / length for x in q]


def product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz]


def turn(q, p):
    """p rotated by the unit quaternion q, as q p q*."""
    return product(product(q, [p[0], p[1], p[2], 0]), [-q[0], -q[1], -q[2], q[3]])[:3]


def plus(a, b):
    return [x + y for x, y in zip(a, b)]


def about(axis, degrees):
    """Quaternion of a rotation about a unit axis."""
    s = math.sin(math.radians(degrees) / 2)
    return [axis[0] * s, axis[1] * s, axis[2] * s, math.cos(math.radians(degrees) / 2)]


def grid(columns, rows, wrap=False):
    """Triangles of a sheet with `columns` x `rows` vertices, row by row; wrap joins its left and right side."""
    triangles = []
    for j in range(rows - 1):
        for i in range(columns if wrap else columns - 1):
            a, b = j * columns + i, j * columns + (i + 1) % columns
            triangles += [[a, b, b + columns], [a, b + columns, a + columns]]
    return triangles


# ---- the four files ----------------------------------------------------------------------------------------------

def bending_tube():
    """A skinned tube: four joints in a chain turn on CUBICSPLINE curves. Its node's own transform must not count."""
    sides, rings, joints, bone = 16, 25, 4, 1.0
    positions, joint_rows, weight_rows = [], [], []
    for j in range(rings):
        y = (joints * bone) * j / (rings - 1)
        radius = 0.35 * (1 - 0.12 * y)
        low = min(int(y / bone), joints - 1)
        high = min(low + 1, joints - 1)
        share = f32((y / bone - low) ** 2) if high != low else 0.0
        for i in range(sides):
            a = 2 * math.pi * i / sides
            positions.append(f32([radius * math.cos(a), y, radius * math.sin(a)]))
            joint_rows.append([low, high, 0, 0])
            weight_rows.append([2 * (1 - share), 2 * share, 0, 0])  # sums to 2: loaders must normalise
    weight_rows = f32(weight_rows)
    times = f32([0.0, 0.5, 1.1, 2.0])
    bend = [0, 35, -20, 0]
    curves = []
    for joint in range(joints):
        axis = unit([0.3 * joint, 0.2, 1])
        rows = []
        for degrees in bend:
            q = about(axis, degrees * (1 if joint else 0.3))
            slope = about(axis, degrees + 25)
            rows += [[0.8 * (s - v) for s, v in zip(slope, q)], q, [1.1 * (s - v) for s, v in zip(slope, q)]]
        curves.append(f32(rows))

    glb = Glb()
    inverse_bind = [[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -bone * j, 0, 1] for j in range(joints)]
    triangles = grid(sides, rings, wrap=True)
    attributes = {"POSITION": glb.accessor(positions, bounds=True), "JOINTS_0": glb.accessor(joint_rows, UBYTE),
                  "WEIGHTS_0": glb.accessor(weight_rows)}
    glb.add("meshes", {"primitives": [{"attributes": attributes, "material": glb.material(0.8, 0.35, 0.2),
                                       "indices": glb.accessor(sum(triangles, []), USHORT)}]})
    glb.add("skins", {"joints": list(range(1, joints + 1)), "inverseBindMatrices": glb.accessor(inverse_bind)})
    glb.add("nodes", {"name": "tube", "mesh": 0, "skin": 0, "translation": [5, 6, 7], "scale": [2, 3, 4]})
    for j in range(joints):
        node = {"name": "joint %d" % j, "translation": [0, bone if j else 0, 0]}
        if j + 1 < joints:
            node["children"] = [j + 2]
        glb.add("nodes", node)
        glb.animate(j + 1, "rotation", times, curves[j], "CUBICSPLINE")
    glb.doc["scenes"][0]["nodes"] = [0, 1]
    glb.write("bending_tube", "bend")

    def positions_at(t):
        rotations = [unit(cubic(times, curve, t)) for curve in curves]

        def follow(joint, p):
            p = [p[0], p[1] - bone * joint, p[2]]
            for k in range(joint, -1, -1):
                p = plus(turn(rotations[k], p), [0, bone if k else 0, 0])
            return p

        result = []
        for p, (low, high, _, _), weights in zip(positions, joint_rows, weight_rows):
            share = weights[1] / (weights[0] + weights[1])
            result.append([(1 - share) * a + share * b for a, b in zip(follow(low, p), follow(high, p))])
        return result

    write_expected("bending_tube", times[-1], triangles, positions_at)


def morphing_sphere():
    """Three morph targets: two with LINEAR weights, one that the curve keeps at its weight."""
    columns, rows = 24, 13
    sphere = []
    for j in range(rows):
        for i in range(columns):
            polar, a = math.pi * j / (rows - 1), 2 * math.pi * i / columns
            sphere.append([math.sin(polar) * math.cos(a), math.cos(polar), math.sin(polar) * math.sin(a)])
    positions = f32(sphere)
    targets = f32([[[0.4 * x, -0.6 * y, 0.4 * z] for x, y, z in sphere],
                   [[0.5 * x * math.sin(5 * y) ** 2, 0.0, 0.5 * z * math.sin(5 * y) ** 2] for x, y, z in sphere],
                   [[0.0, 0.3 * x * x, 0.0] for x, y, z in sphere]])
    times = f32([0.0, 0.4, 1.0, 1.6])
    weights = f32([[0, 0, 0.5], [1, 0.2, 0.5], [0.3, 1, 0.5], [0, 0, 0.5]])
    place, scale = f32([0.5, 1, -0.25]), f32([1, 1.5, 1])

    glb = Glb()
    triangles = grid(columns, rows, wrap=True)
    glb.add("meshes", {
        "weights": [0.1, 0.2, 0.5],
        "primitives": [{"attributes": {"POSITION": glb.accessor(positions, bounds=True)},
                        "targets": [{"POSITION": glb.accessor(t, bounds=True)} for t in targets],
                        "indices": glb.accessor(sum(triangles, []), UINT), "material": glb.material(0.2, 0.5, 0.8)}]})
    glb.add("nodes", {"name": "sphere", "mesh": 0, "translation": place, "scale": scale})
    glb.animate(0, "weights", times, sum(weights, []), "LINEAR")
    glb.write("morphing_sphere", "breathe")

    def positions_at(t):
        now = linear(times, weights, t)
        result = []
        for v, p in enumerate(positions):
            for w, target in zip(now, targets):
                p = plus(p, [w * d for d in target[v]])
            result.append([s * x + o for s, x, o in zip(scale, p, place)])
        return result

    write_expected("morphing_sphere", times[-1], triangles, positions_at)


def blade_mesh():
    """A twisted blade as one triangle strip, along +y."""
    pairs = 12
    rows = []
    for i in range(pairs):
        y, twist = 0.2 + 1.6 * i / (pairs - 1), math.radians(60 - 35 * i / (pairs - 1))
        half = 0.22 * math.sqrt(1 - (2 * i / (pairs - 1) - 1) ** 4 * 0.7)
        for side in (-1, 1):
            rows.append(f32([side * half * math.cos(twist), y, side * half * math.sin(twist)]))
    triangles = [[i, i + 1 + i % 2, i + 2 - i % 2] for i in range(2 * pairs - 2)]
    return rows, triangles


def hub_mesh():
    """A cone as one triangle fan around its tip."""
    rim = 16
    rows = [[0.0, 0.0, 0.5]]
    for i in range(rim + 1):
        a = 2 * math.pi * i / rim
        rows.append(f32([0.25 * math.cos(a), 0.25 * math.sin(a), 0.0]))
    return rows, [[i + 1, i + 2, 0] for i in range(rim)]


def mast_mesh():
    """A slim box without indices."""
    corners = [[x, y, z] for x in (-0.1, 0.1) for y in (-2.5, 0.1) for z in (-0.6, -0.2)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    rows = [f32(corners[k]) for a, b, c, d in faces for k in (a, b, c, a, c, d)]
    return rows, [[i, i + 1, i + 2] for i in range(0, len(rows), 3)]


def propeller():
    """A mast that stands still, a hub that turns (LINEAR, one quaternion flipped), blades whose pitch jumps (STEP)."""
    blades = 3
    spin_times = f32([0.0, 0.3, 0.5, 0.9, 1.2])
    spin = f32([about([0, 0, 1], a) for a in (0, 100, 170, 290, 400)])
    spin[2] = [-x for x in spin[2]]
    pitch_times = f32([0.25, 0.65, 0.95])  # the first key is behind the clip's begin
    pitch = f32([about([0, 1, 0], a) for a in (0, 25, -15)])
    mount = f32([about([0, 0, 1], 360 * b / blades) for b in range(blades)])
    place = f32([0, 0.5, 0])

    glb = Glb()
    (mast, mast_triangles), (hub, hub_triangles), (blade, blade_triangles) = mast_mesh(), hub_mesh(), blade_mesh()
    for rows, mode, color in ((mast, TRIANGLES, (0.5, 0.5, 0.5)), (hub, FAN, (0.8, 0.7, 0.1)),
                              (blade, STRIP, (0.15, 0.3, 0.6))):
        primitive = {"attributes": {"POSITION": glb.accessor(rows, bounds=True)}, "mode": mode,
                     "material": glb.material(*color)}
        if mode == STRIP:
            primitive["indices"] = glb.accessor(list(range(len(rows))), UBYTE)
        glb.add("meshes", {"primitives": [primitive]})
    # Node 0 has a matrix (column by column); node 2 turns; each blade is a mount and, below it, the pitch.
    glb.add("nodes", {"name": "mast", "mesh": 0, "children": [1],
                      "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0] + place + [1]})
    glb.add("nodes", {"name": "hub", "mesh": 1, "children": [2 + 2 * b for b in range(blades)]})
    glb.animate(1, "rotation", spin_times, spin, "LINEAR")
    for b in range(blades):
        glb.add("nodes", {"name": "mount %d" % b, "rotation": mount[b], "children": [3 + 2 * b]})
        glb.add("nodes", {"name": "blade %d" % b, "mesh": 2})
        glb.animate(3 + 2 * b, "rotation", pitch_times, pitch, "STEP")
    glb.write("propeller", "spin")

    parts = [(mast, mast_triangles), (hub, hub_triangles)] + [(blade, blade_triangles)] * blades
    triangles, first = [], 0
    for rows, part_triangles in parts:
        triangles += [[first + k for k in triangle] for triangle in part_triangles]
        first += len(rows)

    def positions_at(t):
        hub_turn, blade_turn = spherical(spin_times, spin, t), unit(step_key(pitch_times, pitch, t))
        result = [plus(p, place) for p in mast] + [plus(turn(hub_turn, p), place) for p in hub]
        for b in range(blades):
            q = product(hub_turn, product(unit(mount[b]), blade_turn))
            result += [plus(turn(q, p), place) for p in blade]
        return result

    write_expected("propeller", spin_times[-1], triangles, positions_at)


def quantised_flag():
    """KHR_mesh_quantization: 16-bit normalised positions and 8-bit joints in one strided view, 16-bit weights, a sparse
    morph target with 8-bit weights of its curve, a pole of unsigned bytes, 8-bit rotations."""
    columns, rows, width, height = 21, 13, 3.0, 2.0
    stored = [[round(32767 * (2 * i / (columns - 1) - 1)), round(32767 * (2 * j / (rows - 1) - 1)), 0]
              for j in range(rows) for i in range(columns)]
    joint_rows = [[1, 0, 0, 0] for _ in stored]
    weight_rows = [[round(65535 * (k % columns) / (columns - 1)), 65535 - round(65535 * (k % columns) / (columns - 1)),
                    0, 0] for k in range(len(stored))]
    interleaved = b"".join(struct.pack("<3h2x4B", *p, *j) for p, j in zip(stored, joint_rows))
    places = [k for k in range(len(stored)) if k % columns >= columns // 2]
    ripple = f32([[0, 0, 0.4 * math.sin(0.9 * (k % columns))] for k in places])
    times = f32([0.0, 0.25, 0.5, 0.75, 1.0])
    ripple_weights = [0, 255, 80, 200, 0]
    swing = [[0, 0, 0, 127], [0, 45, 0, 119], [0, -20, 0, 125], [0, -50, 0, 117], [0, 0, 0, 127]]

    glb = Glb()
    glb.doc["extensionsUsed"] = glb.doc["extensionsRequired"] = ["KHR_mesh_quantization"]
    view = glb.view(interleaved, stride=12)
    cloth = {"POSITION": glb.accessor(stored, SHORT, True, view, bounds=True),
             "JOINTS_0": glb.accessor(joint_rows, UBYTE, False, view, offset=8),
             "WEIGHTS_0": glb.accessor(weight_rows, USHORT, True)}
    cloth_triangles = grid(columns, rows)
    glb.add("meshes", {"primitives": [{"attributes": cloth, "material": glb.material(0.7, 0.1, 0.15),
                                       "targets": [{"POSITION": glb.sparse(len(stored), places, ripple)}],
                                       "indices": glb.accessor(sum(cloth_triangles, []), USHORT)}]})
    pole = [[x, y, z] for y in (0, 255) for x, z in ((0, 0), (255, 0), (255, 255), (0, 255))]
    pole_view = glb.view(b"".join(struct.pack("<3Bx", *p) for p in pole), stride=4)
    pole_triangles = grid(4, 2, wrap=True)
    glb.add("meshes", {"primitives": [{
        "attributes": {"POSITION": glb.accessor(pole, UBYTE, False, pole_view, bounds=True)},
        "material": glb.material(0.6, 0.6, 0.55), "indices": glb.accessor(sum(pole_triangles, []), UBYTE)}]})
    # The inverse bind matrices undo the quantisation: [-1, 1] becomes 0 to width and -height to 0.
    bind = f32([width / 2, 0, 0, 0, 0, height / 2, 0, 0, 0, 0, 1, 0, width / 2, -height / 2, 0, 1])
    glb.add("skins", {"joints": [2, 3], "inverseBindMatrices": glb.accessor([bind, bind])})
    pole_scale, pole_place = f32([0.0005, 4.2 / 255, 0.0005]), f32([-0.13, 0, -0.06])
    top = f32([0, 4, 0])
    glb.add("nodes", {"name": "cloth", "mesh": 0, "skin": 0})
    glb.add("nodes", {"name": "pole", "mesh": 1, "scale": pole_scale, "translation": pole_place})
    glb.add("nodes", {"name": "hoist", "translation": top, "children": [3]})
    glb.add("nodes", {"name": "fly"})
    glb.doc["scenes"][0]["nodes"] = [0, 1, 2]
    glb.animate(0, "weights", times, ripple_weights, "LINEAR", UBYTE, True)
    glb.animate(3, "rotation", times, swing, "LINEAR", BYTE, True)
    glb.write("quantised_flag", "wave")

    triangles = cloth_triangles + [[len(stored) + k for k in t] for t in pole_triangles]
    ripple_of = dict(zip(places, ripple))

    def positions_at(t):
        q = spherical(times, swing, t)
        weight = linear(times, [[w / 255] for w in ripple_weights], t)[0]
        result = []
        for k, p in enumerate(stored):
            p = [max(x / 32767, -1) for x in p]
            p = plus(p, [weight * x for x in ripple_of.get(k, [0, 0, 0])])
            p = [bind[0] * p[0] + bind[12], bind[5] * p[1] + bind[13], p[2]]
            fly = weight_rows[k][0] / 65535
            moved = turn(q, p)
            result.append(plus(top, [(1 - fly) * a + fly * b for a, b in zip(p, moved)]))
        return result + [[s * x + o for s, x, o in zip(pole_scale, p, pole_place)] for p in pole]

    write_expected("quantised_flag", times[-1], triangles, positions_at)


if __name__ == "__main__":
    bending_tube()
    morphing_sphere()
    propeller()
    quantised_flag()
