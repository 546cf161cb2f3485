"""Small scenes in Embree's XML, for its pathtracer and viewers: what moves in them, and how."""

import math

CAMERA = '<PerspectiveCamera name="default" from="0 3 9" to="0 0 0" up="0 1 0" fov="40"/>'
LIGHTS = ('<AmbientLight><L>0.4 0.4 0.5</L></AmbientLight>'
          '<DirectionalLight><AffineSpace>1 0 0 0  0 1 0 0  0 0 1 0</AffineSpace><E>2 2 2</E></DirectionalLight>')


def document(*elements):
    return '<?xml version="1.0"?>\n<scene>\n' + "\n".join((CAMERA, LIGHTS) + elements) + "\n</scene>\n"


def material(red, green, blue, opacity=1.0):
    return (f'<material><code>"OBJ"</code><parameters><float name="d">{opacity:.1f}</float>'
            f'<float3 name="Kd">{red:.1f} {green:.1f} {blue:.1f}</float3></parameters></material>')


def numbers(points):
    return "  ".join(" ".join(f"{x:.6f}" for x in point) for point in points)


def positions(steps):
    """`steps`: one list of points for each time step."""
    if len(steps) == 1:
        return f"<positions>{numbers(steps[0])}</positions>"
    return ("<animated_positions>" + "".join(f"<positions>{numbers(step)}</positions>" for step in steps) +
            "</animated_positions>")


def triangle_mesh(steps, triangles, look):
    indices = "  ".join(" ".join(map(str, t)) for t in triangles)
    return f"<TriangleMesh>{look}{positions(steps)}<triangles>{indices}</triangles></TriangleMesh>"


def quad_mesh(steps, quads, look):
    indices = "  ".join(" ".join(map(str, q)) for q in quads)
    return f"<QuadMesh>{look}{positions(steps)}<indices>{indices}</indices></QuadMesh>"


def cage(steps, faces, look):
    indices = " ".join(str(i) for face in faces for i in face)
    sizes = " ".join(str(len(face)) for face in faces)
    block = positions(steps)
    return (f'<SubdivisionMesh>{look}{block}<position_indices subdiv_mode="smooth">{indices}</position_indices>'
            f"<faces>{sizes}</faces></SubdivisionMesh>")


def split_quads(quads):
    return [t for a, b, c, d in quads for t in ((a, b, d), (c, d, b))]


class Torus:
    """A closed torus around the origin; at time t it is turned by `turn` * t and moved along a curve."""

    def __init__(self, around=24, across=12, turn=2.0, radius=1.6, tube=0.6, center=(0, 0, 0), sway=0.8):
        self.around, self.across, self.turn, self.sway = around, across, turn, sway
        self.radius, self.tube, self.center = radius, tube, center

    def quads(self):
        n, m = self.around, self.across
        return [(i * m + j, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m)
                for i in range(n) for j in range(m)]

    def points(self, t):
        cos, sin = math.cos(self.turn * t), math.sin(self.turn * t)
        dx, dy = self.sway * math.sin(3 * t), self.sway * math.cos(4 * t) - self.sway
        result = []
        for i in range(self.around):
            for j in range(self.across):
                a, b = 2 * math.pi * i / self.around, 2 * math.pi * j / self.across
                r = self.radius + self.tube * math.cos(b)
                x, y, z = r * math.cos(a), self.tube * math.sin(b), r * math.sin(a)
                y, z = y * cos - z * sin, y * sin + z * cos
                result.append((x + dx + self.center[0], y + dy + self.center[1], z + self.center[2]))
        return result

    def steps(self, count):
        return [self.points(s / max(count - 1, 1)) for s in range(count)]

    def mesh(self, count, look):
        return triangle_mesh(self.steps(count), split_quads(self.quads()), look)


GROUND = triangle_mesh([[(-9, -2.5, -9), (9, -2.5, -9), (9, -2.5, 9), (-9, -2.5, 9)]], [(0, 2, 1), (0, 3, 2)],
                       material(0.6, 0.6, 0.6))
RED, GREEN, BLUE = material(0.9, 0.3, 0.2), material(0.3, 0.8, 0.3), material(0.2, 0.3, 0.9)
CUBE_POINTS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def moved(points, x, y, z):
    return [(px + x, py + y, pz + z) for px, py, pz in points]


def time_range(begin, end, content):
    return f'<TimeRange time="{begin} {end}">{content}</TimeRange>'


def instances():
    """One mesh with steps of its own below instances, one of which moves as well."""
    shared = '<assign type="scene" id="torus">' + Torus(radius=0.9, tube=0.3).mesh(5, RED) + "</assign>"
    placed = "".join(f'<Transform><AffineSpace translate="{x} {y} 0"/><ref id="torus"/></Transform>'
                     for x, y in ((-2.5, 1), (2.5, 1), (-2.5, -1)))
    moving = ('<TransformAnimation><AffineSpace translate="2.5 -1 0"/><AffineSpace translate="2 0 1"/>'
              '<AffineSpace translate="2.5 -1 2"/><ref id="torus"/></TransformAnimation>')
    return document(shared, placed, moving, GROUND)


def transparent():
    """Panes that light goes through in part: the pathtracer's filters decide on each hit."""
    panes = [triangle_mesh([moved([(-3, -2, z), (3, -2, z), (3, 2, z), (-3, 2, z)], 0.3 * s, 0.1 * s * s, 0)
                            for s in range(5)], [(0, 1, 2), (0, 2, 3)], material(0.8, 0.8, 0.3, opacity))
             for z, opacity in ((2, 0.3), (1.5, 0.7), (1, 0.5))]
    return document(*panes, Torus().mesh(7, RED), GROUND)


def subdivision():
    steps = [moved(CUBE_POINTS, 2.2, 0.4 * s, 0) for s in range(3)]
    return document(cage(steps, CUBE_FACES, GREEN), Torus(radius=1.0, tube=0.4, center=(-1.8, 0, 0)).mesh(9, RED),
                    GROUND)


def kinds_of_geometry():
    """Moving triangles, moving quads and resting triangles in one scene."""
    quads = Torus(radius=1.0, tube=0.4, center=(2, 0, 0))
    return document(Torus(radius=1.0, tube=0.4, center=(-2, 0, 0)).mesh(4, RED),
                    quad_mesh(quads.steps(4), quads.quads(), BLUE), Torus(radius=0.5, tube=0.2).mesh(1, GREEN), GROUND)


def different_steps():
    return document(*(Torus(radius=0.7, tube=0.3, center=(1.5 * i - 3, 0, 0)).mesh(count, look)
                      for i, (count, look) in enumerate(((2, RED), (3, GREEN), (8, BLUE), (33, RED), (129, GREEN)))),
                    GROUND)


def ranges():
    def torus(i, count, look):
        return Torus(radius=0.7, tube=0.3, center=(2 * i - 3, 0, 0)).mesh(count, look)
    return document(time_range(0, 0.5, torus(0, 3, RED)), time_range(0.25, 1, torus(1, 5, GREEN)),
                    time_range(-0.5, 1.5, torus(2, 9, BLUE)), torus(3, 2, RED), GROUND)


def at_rest():
    return document(Torus().mesh(1, RED), GROUND)


# Name -> the XML, whether moving triangles are in it, and more options of the tool.
SCENES = {
    "torus": (lambda: document(Torus().mesh(9, RED), GROUND), True, ()),
    "different-steps": (different_steps, True, ()),
    "time-ranges": (ranges, True, ()),
    "instances-of-geometries": (instances, True, ("--instancing", "geometry")),
    "instances-of-groups": (instances, True, ("--instancing", "group")),
    "flattened-instances": (instances, True, ("--instancing", "none")),
    "transparent": (transparent, True, ()),
    "subdivision": (subdivision, True, ()),
    "quads-and-triangles": (kinds_of_geometry, True, ()),
    "turning": (lambda: document(Torus(turn=6.0).mesh(17, BLUE), GROUND), True, ()),
    "at-rest": (at_rest, False, ()),
}

# Scenes of the harness that `stbvh-ab convert` writes: name and scale.
CONVERTED = {"crowd": 0.02, "dancer": 0.02, "train": 0.02, "wheels": 0.02, "cloth": 0.02}

# Scenes that Embree comes with, with lights and cameras for them.
MODELS = {
    "mblur_time_range_triangle.xml": ("--ambientlight", "1", "1", "1"),
    "cornell_box_mblur.xml": ("--ambientlight", "1", "1", "1", "--vp", "278", "273", "-800", "--vi", "278", "273", "0",
                              "--vu", "0", "1", "0", "--fov", "37"),
}
