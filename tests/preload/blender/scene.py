"""Run by Blender: a scene of deforming, moving and still objects through Cycles.

blender -b --factory-startup -P scene.py -- SCENE FRAMES MOTION_STEPS SIZE SAMPLES PICTURE-
or by a Python that has Blender as its module bpy.

SCENE: objects, or shadows that fall through moving transparent things. FRAMES: the first and the last, as 1-3, rendered by
one process with persistent data to PICTURE-0001.exr and so on. Cycles gives a mesh with n motion steps 2^n + 1 time
steps."""

import math
import sys
import time

import bpy

FRAME = 2  # in the middle of all that moves


def material(name, color, alpha=1.0, emission=0.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Alpha"].default_value = alpha
    shader.inputs["Roughness"].default_value = 0.3
    shader.inputs["Emission Color" if bpy.app.version >= (4, 0, 0) else "Emission"].default_value = (*color, 1)
    shader.inputs["Emission Strength"].default_value = emission
    return made


def stained_glass(name, color):
    """Half of the light goes through and takes on the color; what does not go through is scattered white."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    through, scattered = nodes.new("ShaderNodeBsdfTransparent"), nodes.new("ShaderNodeBsdfDiffuse")
    through.inputs["Color"].default_value = (*color, 1)
    mix, output = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeOutputMaterial")
    mix.inputs["Fac"].default_value = 0.5
    links.new(through.outputs["BSDF"], mix.inputs[1])
    links.new(scattered.outputs["BSDF"], mix.inputs[2])
    links.new(mix.outputs["Shader"], output.inputs["Surface"])
    return made


def finish(thing, made, motion_steps):
    thing.data.materials.append(made)
    thing.cycles.use_motion_blur = True
    thing.cycles.use_deform_motion = True
    thing.cycles.motion_steps = motion_steps
    return thing


def waving_cloth(motion_steps, made, height):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=120, y_subdivisions=120, size=4, location=(0, 0, height))
    cloth = bpy.context.object
    wave = cloth.modifiers.new("wave", "WAVE")
    wave.height, wave.width, wave.narrowness, wave.speed = 0.7, 1.2, 1.6, 1.1
    wave.time_offset = -30
    return finish(cloth, made, motion_steps)


def twisting_monkey(motion_steps, location, made):
    """Shape keys that are animated fast, so that the path of a vertex has bends."""
    bpy.ops.mesh.primitive_monkey_add(size=1.2, location=location)
    monkey = bpy.context.object
    subdivision = monkey.modifiers.new("subdivision", "SUBSURF")
    subdivision.render_levels = 2
    twist = monkey.modifiers.new("twist", "SIMPLE_DEFORM")
    twist.deform_method = "TWIST"
    for frame in range(FRAME - 4, FRAME + 5):
        twist.angle = 1.5 * math.sin(2.1 * frame)
        twist.keyframe_insert("angle", frame=frame)
    return finish(monkey, made, motion_steps)


def spinning_wheel(motion_steps):
    bpy.ops.mesh.primitive_torus_add(location=(0, 2, 1.5), major_segments=64, minor_segments=24)
    wheel = bpy.context.object
    wheel.scale = (0.6, 0.6, 1)
    for frame in (FRAME - 1, FRAME + 1):
        wheel.rotation_euler = (1.2, 0.8 * frame, 0)
        wheel.keyframe_insert("rotation_euler", frame=frame)
    return finish(wheel, material("wheel", (0.2, 0.4, 0.8)), motion_steps)


def add_floor():
    bpy.ops.mesh.primitive_plane_add(size=30, location=(0, 0, -0.5))
    bpy.context.object.data.materials.append(material("floor", (0.5, 0.5, 0.5)))


def make_objects(motion_steps):
    waving_cloth(motion_steps, material("cloth", (0.8, 0.3, 0.2)), 0.4)
    glass = material("veil", (0.3, 0.8, 0.4), alpha=0.5)
    monkey = twisting_monkey(motion_steps, (1.2, -1.2, 1.6), glass)
    other = max(1, motion_steps - 2)
    twisting_monkey(other, (-1.4, -0.6, 1.7), material("bronze", (0.7, 0.5, 0.2)))
    spinning_wheel(motion_steps)
    for i in range(3):  # share their mesh: instances of a scene of its own
        copy = monkey.copy()
        copy.location = (-2.0 + i, 1.5, 2.4 + 0.3 * i)
        copy.scale = (0.5, 0.5, 0.5)
        bpy.context.collection.objects.link(copy)
    add_floor()
    bpy.ops.mesh.primitive_plane_add(size=2, location=(2, -3, 5), rotation=(0.5, 0.3, 0))
    bpy.context.object.data.materials.append(material("lamp", (1, 0.95, 0.9), emission=12))


def make_shadows(motion_steps):
    """A lamp over a cloth over the floor, and the camera below the cloth: what it sees green got so on its way to the
    floor."""
    waving_cloth(motion_steps, stained_glass("veil", (0.05, 0.9, 0.05)), 2.6)
    twisting_monkey(motion_steps, (0, 0, 4.6), stained_glass("glass", (0.1, 0.9, 0.2)))
    add_floor()
    bpy.ops.object.light_add(type="POINT", radius=0.05, location=(0, 0, 8))
    bpy.context.object.data.energy = 6000
    camera = bpy.context.scene.camera
    camera.location, camera.rotation_euler, camera.data.lens = (0, -8, 1.8), (1.15, 0, 0), 35


def render(frames, size, samples, path):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = frames
    scene.render.use_persistent_data = True
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.seed = 1
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 1.0
    scene.render.resolution_x, scene.render.resolution_y = size, size * 9 // 16
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path
    start = time.monotonic()
    bpy.ops.render.render(animation=True)
    print(f"RENDER_SECONDS {time.monotonic() - start}")


def main():
    name, frames, motion_steps, size, samples, path = sys.argv[sys.argv.index("--") + 1:]
    for thing in ("Cube", "Light"):
        bpy.data.objects.remove(bpy.data.objects[thing])
    {"objects": make_objects, "shadows": make_shadows}[name](int(motion_steps))
    render(map(int, frames.split("-")), int(size), int(samples), path)


main()
