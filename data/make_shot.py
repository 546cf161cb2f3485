#!/usr/bin/env python3
"""Makes tumbling_puppet.usda: a shot of 48 frames, whose meshes are sampled at times of their own.

    python3 data/make_shot.py        writes beside itself; the same bytes every time

A puppet leaps and turns over twice, a flag flutters in a gust that spins a pinwheel, a ball rolls through, and the camera
follows. Samples lie close to each other where things are fast, as exporters of simulations have them.
"""
import math
import pathlib

FILE = pathlib.Path(__file__).resolve().parent / "tumbling_puppet.usda"
FIRST, LAST = 1001, 1048
SIDES = 10  # of limbs


def smooth(x):
    x = min(max(x, 0.0), 1.0)
    return x * x * (3 - 2 * x)


def bump(time, begin, end):
    """Up and down again, in that time."""
    return math.sin(math.pi * min(max((time - begin) / (end - begin), 0.0), 1.0)) ** 2


def number(value):
    text = f"{value:.5f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def row(values):
    return "(" + ", ".join(number(v) for v in values) + ")"


def rows(points):
    return "[" + ", ".join(row(point) for point in points) + "]"


def times(*stretches):
    """Each stretch: where it ends, and how far its samples are from each other; from a frame before the first on."""
    found = [FIRST - 1.0]
    for end, apart in stretches:
        count = round((end - found[-1]) / apart)
        begin = found[-1]
        found += [begin + (end - begin) * i / count for i in range(1, count + 1)]
    return found


def samples(at, text):
    return "{\n" + "".join(f"            {number(time)}: {text(time)},\n" for time in at) + "        }"


# --- the puppet ---

# Name, parent, head and end in the pose that it is bound in, radius.
BONES = [
    ("hips", None, (0, 0.95, 0), (0, 1.15, 0), 0.15),
    ("chest", "hips", (0, 1.15, 0), (0, 1.5, 0), 0.17),
    ("head", "chest", (0, 1.58, 0), (0, 1.8, 0), 0.12),
    ("armL", "chest", (0, 1.45, 0.2), (0, 1.45, 0.85), 0.06),
    ("armR", "chest", (0, 1.45, -0.2), (0, 1.45, -0.85), 0.06),
    ("legL", "hips", (0, 0.92, 0.1), (0, 0.5, 0.1), 0.08),
    ("shinL", "legL", (0, 0.5, 0.1), (0, 0.03, 0.1), 0.06),
    ("legR", "hips", (0, 0.92, -0.1), (0, 0.5, -0.1), 0.08),
    ("shinR", "legR", (0, 0.5, -0.1), (0, 0.03, -0.1), 0.06),
]
NAMES = [bone[0] for bone in BONES]
TAKE_OFF, TOUCH_DOWN = 1014.0, 1034.0


def path(name):
    parent = BONES[NAMES.index(name)][1]
    return f"{path(parent)}/{name}" if parent else name


def turn(axis, degrees):
    half = math.radians(degrees) / 2
    return (math.cos(half), *(math.sin(half) if i == axis else 0.0 for i in range(3)))


def multiply(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def hips_at(time):
    if TAKE_OFF < time < TOUCH_DOWN:
        flight = (time - TAKE_OFF) / 24
        height = 9.81 / 2 * flight * ((TOUCH_DOWN - TAKE_OFF) / 24 - flight)
    else:
        height = -0.28 * (bump(time, 1004, TAKE_OFF) + bump(time, TOUCH_DOWN, 1044))
    return (-1.3 + 2.6 * smooth((time - 1010) / 28), 0.95 + height, 0.0)


def rotations_at(time):
    crouch = bump(time, 1004, TAKE_OFF) + bump(time, TOUCH_DOWN, 1044)
    tuck = bump(time, 1015, 1032)
    swing = math.sin(time / 3.1)
    bend = 55 * crouch + 105 * tuck  # of the hips and of the knees
    return {
        "hips": turn(2, -720 * smooth((time - 1017) / 12) - 18 * crouch),  # twice over, in half a second
        "chest": turn(2, -25 * crouch - 40 * tuck),
        "head": multiply(turn(1, 12 * swing), turn(2, -30 * tuck)),
        "armL": multiply(turn(0, 75 - 60 * tuck + 25 * bump(time, 1010, 1018)), turn(1, 30 * swing - 70 * tuck)),
        "armR": multiply(turn(0, -75 + 60 * tuck - 25 * bump(time, 1010, 1018)), turn(1, 30 * swing + 70 * tuck)),
        "legL": turn(2, bend + 6 * swing), "shinL": turn(2, -2 * bend),
        "legR": turn(2, bend - 6 * swing), "shinR": turn(2, -2 * bend),
    }


class Body:
    """A tube for each bone, closed by polygons of ten corners. Near a bone's head half of a vertex is its parent's."""

    def __init__(self):
        self.points, self.sizes, self.corners, self.joints, self.weights = [], [], [], [], []
        for bone in range(len(BONES)):
            self._add_tube(bone)

    def _add_tube(self, bone):
        _, parent, head, end, radius = BONES[bone]
        along_z = head[2] != end[2]
        first, rings = len(self.points), 7
        for ring in range(rings):
            part = ring / (rings - 1)
            wide = radius * (0.55 + 0.45 * math.sin(math.pi * (0.12 + 0.76 * part)))
            center = [h + part * (e - h) for h, e in zip(head, end)]
            follows = 0.0 if parent is None or parent == "chest" else max(0.0, 0.5 - 1.5 * part)
            for side in range(SIDES):
                angle = 2 * math.pi * side / SIDES
                across = (wide * math.cos(angle), wide * math.sin(angle))
                offset = (across[0], across[1], 0) if along_z else (across[0], 0, across[1])
                self.points.append([c + o for c, o in zip(center, offset)])
                self.joints += [bone, NAMES.index(parent) if parent else bone]
                self.weights += [1 - follows, follows]
        # Counterclockwise seen from outside, whichever way the bone points.
        forward = (end[2] > head[2]) if along_z else (end[1] < head[1])

        def face(corners):
            corners = [first + corner for corner in corners]
            self.sizes.append(len(corners))
            self.corners += corners if forward else corners[::-1]

        for ring in range(rings - 1):
            for side in range(SIDES):
                after = (side + 1) % SIDES
                face([SIDES * ring + side, SIDES * ring + after, SIDES * (ring + 1) + after, SIDES * (ring + 1) + side])
        face(list(range(SIDES))[::-1])
        face([SIDES * (rings - 1) + side for side in range(SIDES)])


def matrix(translation):
    return f"((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), {row((*translation, 1))})"


def offset(name):
    """From the parent's head."""
    _, parent, head, _, _ = BONES[NAMES.index(name)]
    above = BONES[NAMES.index(parent)][2] if parent else (0, 0, 0)
    return [h - a for h, a in zip(head, above)]


def puppet():
    body = Body()
    at = times((1015, 2.0), (1031, 0.125), (1049, 1.5))
    paths = ", ".join(f'"{path(name)}"' for name in NAMES)
    rest = [matrix(offset(name)) for name in NAMES]
    bind = [matrix(BONES[NAMES.index(name)][2]) for name in NAMES]
    translations = [offset(name) for name in NAMES]
    turned = samples(at, lambda time: rows([rotations_at(time)[name] for name in NAMES]))
    moved = samples(at, lambda time: rows([hips_at(time), *translations[1:]]))
    return f"""def SkelRoot "Puppet"
{{
    def Skeleton "Bones" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        uniform token[] joints = [{paths}]
        uniform matrix4d[] bindTransforms = [{", ".join(bind)}]
        uniform matrix4d[] restTransforms = [{", ".join(rest)}]
        rel skel:animationSource = </Puppet/Leap>
    }}

    def SkelAnimation "Leap"
    {{
        uniform token[] joints = [{paths}]
        half3[] scales = {rows([(1, 1, 1)] * len(NAMES))}
        quatf[] rotations.timeSamples = {turned}
        float3[] translations.timeSamples = {moved}
    }}

    def Mesh "Body" (
        prepend apiSchemas = ["SkelBindingAPI"]
    )
    {{
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = {body.sizes}
        int[] faceVertexIndices = {body.corners}
        point3f[] points = {rows(body.points)}
        color3f[] primvars:displayColor = [(0.8, 0.35, 0.2)]
        int[] primvars:skel:jointIndices = {body.joints} (
            elementSize = 2
            interpolation = "vertex"
        )
        float[] primvars:skel:jointWeights = [{", ".join(map(number, body.weights))}] (
            elementSize = 2
            interpolation = "vertex"
        )
        rel skel:skeleton = </Puppet/Bones>
    }}
}}
"""


# --- what is around it ---

FLAG = (13, 5)  # vertices


def flag_at(time):
    """Waves run along it; the gust makes them quick and high."""
    gust = bump(time, 1020, 1042)
    phase = 0.35 * (time - FIRST) + 9 * smooth((time - 1020) / 22)
    points = []
    for j in range(FLAG[1]):
        for i in range(FLAG[0]):
            along, down = 1.2 * i / (FLAG[0] - 1), 0.7 * j / (FLAG[1] - 1)
            sag = (1 - 0.8 * gust) * 0.35 * along * along
            wave = (0.05 + 0.13 * gust) * along * math.sin(5 * along - phase + 0.5 * down)
            points.append((-2.2 + along - 0.15 * sag, 2.6 - down - sag, -1.2 + wave))
    return points


def flag():
    width = FLAG[0]
    quads = [(j * width + i, (j + 1) * width + i, (j + 1) * width + i + 1, j * width + i + 1)
             for j in range(FLAG[1] - 1) for i in range(width - 1)]
    at = times((1020, 2.5), (1042, 0.75), (1049, 1.75))
    return f"""def Mesh "Flag"
{{
    uniform token subdivisionScheme = "none"
    uniform bool doubleSided = 1
    int[] faceVertexCounts = {[4] * len(quads)}
    int[] faceVertexIndices = {[corner for quad in quads for corner in quad]}
    point3f[] points.timeSamples = {samples(at, lambda time: rows(flag_at(time)))}
    color3f[] primvars:displayColor = [(0.15, 0.35, 0.7)]
}}
"""


def pinwheel():
    def angle(time):
        return 40 * (time - FIRST) / 47 + 1440 * smooth((time - 1021) / 14)

    at = times((1021, 7.0), (1035, 1.0), (1049, 4.666667))
    points, corners = [], []
    for blade in range(6):
        for radius, degrees in ((0.06, 0), (0.5, 4), (0.55, 26), (0.1, 48)):
            turned = math.radians(60 * blade + degrees)
            depth = 0.35 * radius * math.sin(math.radians(degrees))  # flat, and tilted
            points.append((radius * math.cos(turned), radius * math.sin(turned), depth))
        corners += range(4 * blade, 4 * blade + 4)
    points += [(0.09 * math.cos(math.pi * i / 3), 0.09 * math.sin(math.pi * i / 3), 0.11) for i in range(6)]
    corners += range(24, 30)
    return f"""def Xform "Pinwheel"
{{
    double3 xformOp:translate = (1.9, 1.5, -0.9)
    float xformOp:rotateZ.timeSamples = {samples(at, lambda time: number(angle(time)))}
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ"]

    def Mesh "Blades"
    {{
        uniform token subdivisionScheme = "none"
        uniform bool doubleSided = 1
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4, 6]
        int[] faceVertexIndices = {corners}
        point3f[] points = {rows(points)}
        color3f[] primvars:displayColor = [(0.85, 0.7, 0.1)]
    }}
}}
"""


def ball():
    at = times((1010, 1.0), (1030, 4.0), (1049, 1.9))

    def place(time):
        return 3.0 - 5.2 * smooth((time - 1000) / 60)

    moved = samples(at, lambda time: row((place(time), 0.25 + 0.5 * abs(math.sin((time - 1000) / 7.0)), 1.0)))
    rolled = samples(at, lambda time: number(math.degrees((3.0 - place(time)) / 0.25)))
    corners = "[0, 2, 3, 1, 2, 6, 7, 3, 6, 4, 5, 7, 4, 0, 1, 5, 1, 3, 7, 5, 4, 6, 2, 0]"
    points = rows([(x, y, z) for y in (-0.3, 0.3) for z in (0.3, -0.3) for x in (-0.3, 0.3)])
    return f"""def Mesh "Ball"
{{
    double3 xformOp:translate.timeSamples = {moved}
    float xformOp:rotateZ.timeSamples = {rolled}
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ"]
    uniform token subdivisionScheme = "catmullClark"
    int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
    int[] faceVertexIndices = {corners}
    point3f[] points = {points}
    color3f[] primvars:displayColor = [(0.2, 0.6, 0.3)]
}}
"""


def camera():
    at = times((1016, 5.333333), (1030, 1.75), (1049, 6.333333))

    def place(time):
        return -1.2 + 2.4 * smooth((time - 1008) / 32), 1.5 + 0.25 * bump(time, 1012, 1036), 5.6 - 0.5 * bump(time, 1008, 1044)

    def tilt(time):
        return -4 + 3 * bump(time, 1012, 1036), 6 - 12 * smooth((time - 1016) / 14), 0.6 * math.sin(time / 4)

    return f"""def Camera "Camera"
{{
    float focalLength = 24
    float horizontalAperture = 36
    float verticalAperture = 20.25
    float2 clippingRange = (0.1, 100)
    double shutter:open = -0.25
    double shutter:close = 0.25
    double3 xformOp:translate.timeSamples = {samples(at, lambda time: row(place(time)))}
    float3 xformOp:rotateXYZ.timeSamples = {samples(at, lambda time: row(tilt(time)))}
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}}
"""


STILL = """def Mesh "Ground"
{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-5, 0, 3), (5, 0, 3), (5, 0, -4), (-5, 0, -4)]
    color3f[] primvars:displayColor = [(0.5, 0.48, 0.45)]
}

def DistantLight "Sun"
{
    float inputs:angle = 1.5
    float inputs:intensity = 2.5
    bool inputs:normalize = 1
    color3f inputs:color = (1, 0.95, 0.85)
    float3 xformOp:rotateXYZ = (-50, 35, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}

def DomeLight "Sky"
{
    float inputs:intensity = 0.5
    color3f inputs:color = (0.75, 0.85, 1)
}
"""


def main():
    head = f"""#usda 1.0
(
    doc = "Made by make_shot.py."
    startTimeCode = {FIRST}
    endTimeCode = {LAST}
    framesPerSecond = 24
    timeCodesPerSecond = 24
    metersPerUnit = 1
    upAxis = "Y"
)
"""
    parts = [head, camera(), puppet(), flag(), pinwheel(), ball(), STILL]
    FILE.write_text("\n".join(parts), encoding="ascii")


if __name__ == "__main__":
    main()
