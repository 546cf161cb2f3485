#!/usr/bin/env python3
"""Writes the seeds of the readers' fuzz targets: tests/fuzz/make_reader_corpus.py FOLDER makes FOLDER/gltf, /xml and so on.

Small files that have every part which the readers know. The same seeds each time; found inputs that are kept as
regressions have names of their own.
"""
import base64
import json
import pathlib
import struct
import sys
import zlib

SQUARE = (0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
FLOAT, USHORT, UBYTE, UINT = 5126, 5123, 5121, 5125
FORMATS = {FLOAT: "f", USHORT: "H", UBYTE: "B", UINT: "I"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


# --- glTF ---


class Gltf:
    """A square in one node, and what is added to it."""

    def __init__(self):
        self.binary = b""
        self.root = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                     "meshes": [{"primitives": [{"attributes": {}}]}], "bufferViews": [], "accessors": []}
        self.attributes["POSITION"] = self.accessor("VEC3", FLOAT, SQUARE)
        self.primitive["indices"] = self.accessor("SCALAR", USHORT, (0, 1, 2, 0, 2, 3))

    @property
    def primitive(self):
        return self.root["meshes"][0]["primitives"][0]

    @property
    def attributes(self):
        return self.primitive["attributes"]

    def view(self, component, values):
        self.binary += bytes(-len(self.binary) % 4)
        data = struct.pack(f"<{len(values)}{FORMATS[component]}", *values)
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.root["bufferViews"]) - 1

    def accessor(self, kind, component, values, **more):
        view = self.view(component, values)
        self.root["accessors"].append({"bufferView": view, "componentType": component, "type": kind,
                                       "count": len(values) // WIDTHS[kind], **more})
        return len(self.root["accessors"]) - 1

    def animate(self, path, kind, times, values, interpolation="LINEAR", node=0):
        animation = self.root.setdefault("animations", [{"name": "a", "samplers": [], "channels": []}])[0]
        animation["samplers"].append({"input": self.accessor("SCALAR", FLOAT, times), "interpolation": interpolation,
                                      "output": self.accessor(kind, FLOAT, values)})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})

    def glb(self):
        self.root["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + bytes(-len(self.binary) % 4)
        return (b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(binary)) + struct.pack("<I", len(text)) + b"JSON" +
                text + struct.pack("<I", len(binary)) + b"BIN\0" + binary)

    def gltf(self, media="application/octet-stream"):
        uri = f"data:{media};base64," + base64.b64encode(self.binary).decode()
        self.root["buffers"] = [{"byteLength": len(self.binary), "uri": uri}]
        return json.dumps(self.root).encode()


def moving():
    g = Gltf()
    g.animate("translation", "VEC3", (0, 1), (0, 0, 0, 1, 0, 0))
    g.animate("rotation", "VEC4", (0, 0.5), (0, 0, 0, 1, 0, 0, 1, 0))
    g.animate("scale", "VEC3", (0, 1), (1, 1, 1, 2, 2, 2), "STEP")
    return g


def spline():
    g = Gltf()
    g.animate("translation", "VEC3", (0, 1), tuple(range(18)), "CUBICSPLINE")
    g.root["nodes"] = [{"mesh": 0, "children": [1]}, {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1]}]
    return g


def morphing():
    g = Gltf()
    g.primitive["targets"] = [{"POSITION": g.accessor("VEC3", FLOAT, SQUARE)}]
    g.root["accessors"].append({"componentType": FLOAT, "type": "VEC3", "count": 4, "sparse": {
        "count": 1, "indices": {"bufferView": g.view(USHORT, (2,)), "componentType": USHORT},
        "values": {"bufferView": g.view(FLOAT, (0, 0, 3))}}})
    g.primitive["targets"].append({"POSITION": len(g.root["accessors"]) - 1})
    g.root["meshes"][0]["weights"] = [0.5, 0]
    g.animate("weights", "SCALAR", (0, 1), (0, 0, 1, 1))
    return g


def skinned():
    g = Gltf()
    g.attributes["JOINTS_0"] = g.accessor("VEC4", UBYTE, (0, 1, 0, 0) * 4)
    g.attributes["WEIGHTS_0"] = g.accessor("VEC4", FLOAT, (0.5, 0.5, 0, 0) * 4)
    identity = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
    g.root["skins"] = [{"joints": [1, 2], "inverseBindMatrices": g.accessor("MAT4", FLOAT, identity * 2)}]
    g.root["nodes"] = [{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [0, 1, 0]}]
    g.root["scenes"][0]["nodes"] = [0, 1]
    g.animate("translation", "VEC3", (0, 1), (0, 0, 0, 0, 0, 1), node=2)
    return g


def extended():
    """Extensions that change geometry, motion or light."""
    g = Gltf()
    g.root["extensionsUsed"] = ["EXT_mesh_gpu_instancing", "KHR_node_visibility", "KHR_lights_punctual",
                                "KHR_materials_emissive_strength", "KHR_animation_pointer"]
    g.root["nodes"] = [
        {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": g.accessor("VEC3", FLOAT, (0, 0, 0, 2, 0, 0))}}}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": False}}}, {"camera": 0, "translation": [0, 0, 5]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}}]
    g.root["scenes"][0]["nodes"] = [0, 1, 2, 3]
    g.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5}}]
    g.root["extensions"] = {"KHR_lights_punctual": {"lights": [
        {"type": "directional", "color": [1, 1, 0.5], "intensity": 3}]}}
    g.root["materials"] = [{"emissiveFactor": [1, 0.5, 0], "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]},
                            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}}]
    g.primitive["material"] = 0
    g.animate("pointer", "VEC3", (0, 1), (0, 0, 0, 1, 0, 0))
    g.root["animations"][0]["channels"][0]["target"] = {
        "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0/translation"}}}
    return g


def gltf_seeds():
    yield "square.glb", Gltf().glb()
    yield "square.gltf", Gltf().gltf("application/gltf-buffer")
    for make in (moving, spline, morphing, skinned, extended):
        yield f"{make.__name__}.glb", make().glb()
        yield f"{make.__name__}.gltf", make().gltf()


# --- Embree's XML and ECS ---

TRIANGLE = "<positions>0 0 0 1 0 0 0 1 0</positions><triangles>0 1 2</triangles>"
CUBE_FACES = "0 1 3 2 4 6 7 5 0 4 5 1 2 3 7 6 0 2 6 4 1 5 7 3"
CUBE = " ".join(f"{x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1))


def xml(content, binary=None):
    text = f'<?xml version="1.0"?>\n<scene>\n{content}\n</scene>\n'.encode()
    return text if binary is None else text + b"\0" + binary


def xml_seeds():
    yield "triangle", xml(f'<TriangleMesh name="t">{TRIANGLE}</TriangleMesh>')
    yield "steps", xml("<TriangleMesh><animated_positions><positions>0 0 0 1 0 0 0 1 0</positions>"
                       "<positions>0 0 1 1 0 1 0 1 1</positions></animated_positions><triangles>0 1 2</triangles>"
                       "</TriangleMesh>")
    yield "quads", xml("<QuadMesh><positions>0 0 0 1 0 0 1 1 0 0 1 0</positions><positions2>0 0 1 1 0 1 1 1 1 0 1 1"
                       "</positions2><indices>0 1 2 3</indices></QuadMesh>")
    yield "cage", xml(f"<SubdivisionMesh><positions>{CUBE}</positions><position_indices subdiv_mode=\"pin_corners\">"
                      f"{CUBE_FACES}</position_indices><faces>4 4 4 4 4 4</faces><edge_creases>0 1</edge_creases>"
                      "<edge_crease_weights>2</edge_crease_weights><vertex_creases>7</vertex_creases>"
                      "<vertex_crease_weights>1</vertex_crease_weights><holes>1</holes></SubdivisionMesh>")
    yield "instances", xml(
        f'<assign type="scene" id="a"><TriangleMesh>{TRIANGLE}</TriangleMesh></assign>'
        '<Group><ref id="a"/><Transform><AffineSpace translate="1 2 3"/><ref id="a"/></Transform>'
        '<TransformAnimation><AffineSpace scale="1 1 2"/><AffineSpace rotate_y="90"/><ref id="a"/></TransformAnimation>'
        '<TransformAnimation time_range="0 0.5"><AffineSpace angle="30" axis="0 0 1" point="1 1 1"/>'
        '<AffineSpace>1 0 0 0 0 1 0 0 0 0 1 1</AffineSpace><ref id="a"/></TransformAnimation></Group>'
        '<Flatten><ref id="a"/></Flatten><TimeRange time="0.25 0.75"><ref id="a"/></TimeRange>')
    yield "lights", xml(
        '<PerspectiveCamera name="c" from="0 0 5" to="0 0 0" up="0 1 0" fov="40"/>'
        "<AmbientLight><L>1 1 1</L></AmbientLight>"
        '<DirectionalLight><AffineSpace rotate_x="90"/><E>3 3 3</E></DirectionalLight>'
        "<DistantLight><AffineSpace>1 0 0 0 0 1 0 0 0 0 1 0</AffineSpace><L>2 2 2</L><halfAngle>5</halfAngle></DistantLight>"
        "<QuadLight><AffineSpace scale=\"2 2 2\"/><L>9 9 9</L></QuadLight><PointLight><I>1 1 1</I></PointLight>"
        '<assign type="material" id="m"><material><code>"OBJ"</code><parameters><float3 name="Kd">1 0 0</float3>'
        '<float name="Ns">10</float></parameters></material></assign>'
        f'<TriangleMesh>{TRIANGLE}<material id="m"/></TriangleMesh>')
    arrays = struct.pack("<9f3I12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2, 1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 0)
    yield "binary", xml('<TriangleMesh><positions ofs="0" size="3"/><triangles ofs="36" size="1"/></TriangleMesh>', arrays)
    yield "many", xml('<MultiTransform><AffineSpaceArray ofs="48" size="1"/><TriangleMesh><positions ofs="0" size="3"/>'
                      '<triangles ofs="36" size="1"/></TriangleMesh></MultiTransform>', arrays)


def ecs_seeds():
    yield "scene", b"-i scene.xml\n-vp 0 0 5 -vi 0 0 0 -vu 0 1 0 -fov 40\n"
    yield "lights", b"# a comment\n-i scene.xml --camera c -ambientlight 1 1 1 -dirlight 0 -1 0 3 3 3\n"
    yield "disc", b"-i scene.xml -vd 0 0 1 --distantlight 0 -1 0 1 1 1 5 -righthanded --size 512 512\n"
    yield "obj", b"-i scene.obj -i scene.xml\n"


# --- OBJ ---


def obj_seeds():
    yield "triangle", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    yield "corners", b"# a comment\nmtllib m.mtl\no o\ng g\nv 0 0 0 1\nv 1 0 0 1 0 0\nv 0 1 0\nv +1 1e0 .5\nvt 0 0\nvn 0 0 1\n" \
                     b"usemtl m\ns off\nf 1/1/1 2//1 3/1\nf -1 -2 -3 -4\n"
    yield "concave", b"v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n"
    yield "continued", b"\xef\xbb\xbfv 0 0 \\\n0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 \\\n3\r\n"


# --- OpenEXR ---


def attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(data)) + data


def exr(channels="BGR", kind=2, window=(0, 0, 2, 1), display=None, compression=0, sampling=1, more=b"", version=2):
    """Scan lines; `kind` is 0 (32-bit ids), 1 (half) or 2 (float), `compression` 0 (none), 2 (ZIPS) or 3 (ZIP)."""
    size = 2 if kind == 1 else 4
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    names = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", kind, 0, sampling, sampling) for n in channels) + b"\0"
    header = (struct.pack("<II", 20000630, version) + attribute("channels", "chlist", names) +
              attribute("compression", "compression", bytes([compression])) +
              attribute("dataWindow", "box2i", struct.pack("<4i", *window)) +
              attribute("displayWindow", "box2i", struct.pack("<4i", *(display or window))) +
              attribute("lineOrder", "lineOrder", b"\0") +
              attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) +
              attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) +
              attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + more + b"\0")
    lines = 16 if compression == 3 else 1
    chunks = []
    for first in range(0, height, lines):
        count = min(lines, height - first)
        raw = bytes((i * 7 + first) % 60 for i in range(size * width * len(channels) * count))
        chunks.append(struct.pack("<i", window[1] + first) + packed(raw, compression))
    offset = len(header) + 8 * len(chunks)
    table = b""
    for chunk in chunks:
        table += struct.pack("<Q", offset)
        offset += len(chunk)
    return header + table + b"".join(chunks)


def packed(raw, compression):
    """A chunk's data behind its size: as OpenEXR's ZIP packs them, where that makes them smaller."""
    if compression:
        halves = raw[0::2] + raw[1::2]
        deltas = bytes([halves[0]] + [(b - a + 128) & 0xFF for a, b in zip(halves, halves[1:])])
        data = zlib.compress(deltas)
        if len(data) < len(raw):
            return struct.pack("<I", len(data)) + data
    return struct.pack("<I", len(raw)) + raw


def exr_seeds():
    yield "float", exr()
    yield "half", exr(kind=1, window=(-2, 3, 1, 6))
    yield "ids", exr(channels=["primitive.id"], kind=0)
    yield "zip", exr(window=(0, 0, 7, 7), compression=3)
    yield "zips", exr(window=(0, 0, 7, 3), compression=2)
    yield "display", exr(display=(-5, -5, 20, 20))
    chromaticities = struct.pack("<8f", 0.7, 0.29, 0.17, 0.8, 0.13, 0.05, 0.31, 0.33)
    yield "attributes", exr(more=attribute("chromaticities", "chromaticities", chromaticities) +
                            attribute("scene", "string", b"cloth"))
    yield "sampled", exr(channels=["BY"], kind=1, window=(0, 0, 3, 3), sampling=2)


# --- records ---

SPEED = {"kind": "speed", "scene": "s", "structure": "embree", "rays": "bounce", "ray_count": 10, "threads": 2, "repeats": 2,
         "mrays_per_s": 1.5, "mrays_per_s_min": 1, "mrays_per_s_max": 2, "ratio_to_embree": 1.0,
         "ratio_to_embree_min": 1.0, "ratio_to_embree_max": 1.0, "ratios_to_embree": [1.0, 1.0], "hits": 4}
HARD = {"kind": "hard", "family": "f", "structure": "stbvh", "traced": 30, "oracle_hits": 3, "leaks": None, "missed": 0,
        "false_hits": 0, "wrong_primitive": 0, "near_misses": 0, "any_hit_wrong": 0, "self_hits": None, "ties": 0,
        "within_rounding": 1, "near_edge": 0, "t_error_rel_p99": 1e-7, "t_error_rel_max": None}


def records_seeds():
    def file(records):
        return json.dumps({"machine": {"cpu": "c", "cores": 2, "memory_gb": 8.0, "instruction_set": "AVX2",
                                       "embree": "3.13.5"},
                           "commit": "abc", "command": "stbvh-ab bench", "records": records}).encode()
    yield "speed", file([SPEED])
    yield "hard", file([HARD, {**HARD, "leaks": 2}])
    yield "both", b"\xef\xbb\xbf" + file([SPEED, HARD])
    yield "escapes", file([{**SPEED, "scene": "\u00fc\n\ud83d\ude00", "ray_count": 1e300}])


def main():
    folder = pathlib.Path(sys.argv[1])
    for target, seeds in (("gltf", gltf_seeds), ("xml", xml_seeds), ("ecs", ecs_seeds), ("obj", obj_seeds),
                          ("exr", exr_seeds), ("records", records_seeds)):
        (folder / target).mkdir(parents=True, exist_ok=True)
        for name, data in seeds():
            (folder / target / f"seed_{name}").write_bytes(data)


if __name__ == "__main__":
    main()
