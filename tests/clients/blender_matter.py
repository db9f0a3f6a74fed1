#!/usr/bin/python3
"""Cycles shows the same glass, gel and wax as umax: a bumpy body on a plate, under a lamp and an even sky, with all paths
that either can take. FLIP of both pictures, and what the means of both bodies are.

usage: blender_matter.py PROGRAM [SAMPLES]
"""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from clients import png_of  # noqa: E402
from exr import Exr  # noqa: E402

WIDTH, HEIGHT = 160, 120
MOST_FLIP = 0.05
CAMERA, TARGET, FOV = (0.3, 1.5, 3.6), (0, 0.55, 0), 28
LAMP, LAMP_TARGET, LAMP_SIZE, LAMP_POWER = (-2.0, 3.2, 1.6), (0, 0.4, 0), 1.8, 260
SKY = (0.35, 0.38, 0.45)
PLATE = 0.5

# what the bodies are made of: umax's keys, and what Cycles takes for them
LOOKS = {
    "glass": {"color": (0.6, 0.85, 0.75), "roughness": 0.0, "transmission": 1, "depth": 0.8},
    "frosted": {"color": (0.9, 0.6, 0.35), "roughness": 0.35, "transmission": 1, "depth": 0.8},
    "wax": {"color": (0.8, 0.55, 0.3), "roughness": 0.45, "ior": 1, "subsurface": 1, "radius": (0.06, 0.03, 0.015)},
    "skin": {"color": (0.75, 0.45, 0.35), "roughness": 0.4, "subsurface": 1, "radius": (0.02, 0.008, 0.004)},
}

# inside of Blender
INSIDE = r"""
import bpy, json, math, sys
from mathutils import Vector, Matrix
job = json.loads(sys.argv[sys.argv.index("--") + 1])
for thing in list(bpy.data.objects): bpy.data.objects.remove(thing)
scene = bpy.context.scene
bpy.ops.wm.obj_import(filepath=job["mesh"], forward_axis="Y", up_axis="Z")
body = bpy.context.selected_objects[0]
for face in body.data.polygons: face.use_smooth = True
body.data.materials.clear()

def material(name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    body_nodes = made.node_tree
    return made, body_nodes, body_nodes.nodes["Principled BSDF"], body_nodes.nodes["Material Output"]

def put(node, names, value):
    for name in names:
        if name in node.inputs:
            node.inputs[name].default_value = value
            return
    raise KeyError(names)

# The rough glass of Blender 3.4 asks Fresnel about the surface, not about its facets: what they throw back inside
# changes in a step at the critical angle. So each path gets a facet of smooth glass, drawn of those of GGX's distribution
# that the light sees (a cap of the sphere, as Dupuy and Benyoub have it), by the noise of the place that it meets.
def set_facets(tree, normal, alpha):
    def node(kind, operation, *values, out=0):
        made = tree.nodes.new(kind)
        made.operation = operation
        places = [place for place in made.inputs if place.enabled]
        for place, value in zip(places, values):
            if isinstance(value, bpy.types.NodeSocket): tree.links.new(value, place)
            else: place.default_value = value
        return made.outputs[out]
    number = lambda operation, *values: node("ShaderNodeMath", operation, *values)
    vector = lambda operation, *values, out="Vector": node("ShaderNodeVectorMath", operation, *values, out=out)
    met = tree.nodes.new("ShaderNodeNewGeometry")
    noise = tree.nodes.new("ShaderNodeTexWhiteNoise")
    tree.links.new(vector("SCALE", met.outputs["Position"], 1000), noise.inputs["Vector"])
    chance = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(noise.outputs["Color"], chance.inputs[0])
    n, light = met.outputs["Normal"], met.outputs["Incoming"]
    cosine = vector("DOT_PRODUCT", n, light, out="Value")
    flat = vector("SUBTRACT", light, vector("SCALE", n, cosine))
    x = vector("NORMALIZE", flat)
    y = vector("CROSS_PRODUCT", n, x)
    # the light in the space in which facets are a hemisphere
    across = number("MULTIPLY", vector("LENGTH", flat, out="Value"), alpha)
    length = number("SQRT", number("ADD", number("MULTIPLY", across, across), number("MULTIPLY", cosine, cosine)))
    light_x, light_z = number("DIVIDE", across, length), number("DIVIDE", cosine, length)
    z = number("SUBTRACT", number("MULTIPLY", number("SUBTRACT", 1, chance.outputs[1]), number("ADD", 1, light_z)), light_z)
    radius = number("SQRT", number("MAXIMUM", number("SUBTRACT", 1, number("MULTIPLY", z, z)), 0))
    angle = number("MULTIPLY", chance.outputs[0], 2 * math.pi)
    along = number("MULTIPLY", number("ADD", number("MULTIPLY", radius, number("COSINE", angle)), light_x), alpha)
    beside = number("MULTIPLY", number("MULTIPLY", radius, number("SINE", angle)), alpha)
    facet = vector("ADD", vector("ADD", vector("SCALE", x, along), vector("SCALE", y, beside)),
                   vector("SCALE", n, number("ADD", z, light_z)))
    tree.links.new(vector("NORMALIZE", facet), normal)

look = job["look"]
made, tree, shader, out = material("body")
if look.get("transmission"):
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.distribution = "SHARP"
    glass.inputs["Color"].default_value = (1, 1, 1, 1)
    glass.inputs["IOR"].default_value = 1.5
    tree.links.new(glass.outputs[0], out.inputs["Surface"])
    if look["roughness"] > 0: set_facets(tree, glass.inputs["Normal"], look["roughness"] ** 2)
    lost = [-math.log(c) / look["depth"] for c in look["color"]]
    inside = tree.nodes.new("ShaderNodeVolumeAbsorption")
    inside.inputs["Density"].default_value = max(lost)
    inside.inputs["Color"].default_value = [1 - s / max(lost) for s in lost] + [1]
    tree.links.new(inside.outputs[0], out.inputs["Volume"])
else:
    put(shader, ["Base Color"], (*look["color"], 1))
    put(shader, ["Roughness"], look["roughness"])
    put(shader, ["Subsurface Weight", "Subsurface"], 1)
    put(shader, ["Subsurface Radius"], [r * job["radius_factor"] for r in look["radius"]])
    if "Subsurface Color" in shader.inputs: put(shader, ["Subsurface Color"], (*look["color"], 1))
    if "Subsurface Scale" in shader.inputs: put(shader, ["Subsurface Scale"], 1)
    # its surface's gloss takes nothing from what is below it, where umax's takes a twentieth: without, both are to agree
    if look.get("ior") == 1: put(shader, ["Specular", "Specular IOR Level"], 0)
    shader.subsurface_method = "RANDOM_WALK_FIXED_RADIUS" if bpy.app.version < (4, 0, 0) else "RANDOM_WALK"
body.data.materials.append(made)

bpy.ops.mesh.primitive_plane_add(size=2 * 6)
plate = bpy.context.object
plate.matrix_world = Matrix.Rotation(-math.pi / 2, 4, "X")  # Y up
made, tree, shader, out = material("plate")
matt = tree.nodes.new("ShaderNodeBsdfDiffuse")
matt.inputs["Color"].default_value = [job["plate"]] * 3 + [1]
tree.links.new(matt.outputs[0], out.inputs["Surface"])
plate.data.materials.append(made)

def look_at(thing, position, target):
    forward = (Vector(target) - Vector(position)).normalized()
    right = forward.cross(Vector((0, 1, 0))).normalized()
    up = right.cross(forward)
    thing.matrix_world = Matrix([[right[i], up[i], -forward[i], position[i]] for i in range(3)] + [[0, 0, 0, 1]])

lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
# its radiance is power / (4 area), umax's is power / (pi area)
lamp.data.shape, lamp.data.size, lamp.data.energy = "SQUARE", job["lamp_size"], job["lamp_power"] * 4 / math.pi
lamp.visible_camera = False
scene.collection.objects.link(lamp)
look_at(lamp, job["lamp"], job["lamp_target"])
world = bpy.data.worlds.new("sky")
world.use_nodes = True
world.node_tree.nodes["Background"].inputs[0].default_value = (*job["sky"], 1)
scene.world = world
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera = camera
look_at(camera, job["camera"], job["target"])
camera.data.sensor_fit = "VERTICAL"
camera.data.angle_y = math.radians(job["fov"])
scene.render.engine = "CYCLES"
cycles = scene.cycles
cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", job["samples"], False, False
cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 32
cycles.sample_clamp_indirect = cycles.sample_clamp_direct = cycles.blur_glossy = 0
cycles.caustics_reflective = cycles.caustics_refractive = True
cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.5
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = job["width"], job["height"], 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.exr_codec = "ZIP"
scene.view_settings.view_transform = "Standard"
scene.render.filepath = job["out"]
bpy.ops.render.render(write_still=True)
"""


def body_mesh():
    """a closed bumpy ball, 1.1 m tall, that stands at height 0"""
    around, across, lines = 128, 64, []
    points = []
    for j in range(across + 1):
        polar = math.pi * j / across
        for i in range(around if 0 < j < across else 1):
            angle = 2 * math.pi * i / around
            bump = 1 + 0.16 * math.sin(polar) ** 2 * math.cos(3 * angle) * math.sin(2 * polar)
            r = 0.5 * bump
            points.append((r * math.sin(polar) * math.cos(angle), 1.1 * r * math.cos(polar),
                           r * math.sin(polar) * math.sin(angle)))
    low = min(p[1] for p in points) - 0.002
    lines += [f"v {x:.7f} {y - low:.7f} {z:.7f}" for x, y, z in points]
    row = lambda j, i: 1 if j == 0 else len(points) if j == across else 2 + (j - 1) * around + i % around
    for j in range(across):
        for i in range(around):
            a, b, c, d = row(j, i), row(j, i + 1), row(j + 1, i + 1), row(j + 1, i)
            if j > 0:
                lines.append(f"f {a} {b} {c}")
            if j < across - 1:
                lines.append(f"f {a} {c} {d}")
    middle = [(min(p[k] for p in points) + max(p[k] for p in points)) / 2 for k in range(3)]
    return "\n".join(lines) + "\n", (middle[0], middle[1] - low, middle[2])


def scene_of(look, samples, place):
    keys = [f"look.color = {list(look['color'])}", f"look.roughness = {look['roughness']}", f"look.ior = {look.get('ior', 1.5)}"]
    if "transmission" in look:
        keys += ["look.transmission = 1", f"look.transmission_depth = {look['depth']}"]
    else:
        keys += ["look.subsurface = 1", f"look.subsurface_radius = {list(look['radius'])}"]
    return f"""[clip]
frames = 2
[body.thing]
mesh = "body.obj"
up = "y"
unit = "m"
position = {list(place)}
cage.cells = [3, 3, 3]
{chr(10).join(keys)}
[obstacle.plate]
shape = "box"
size = [12, 0.2, 12]
position = [0, -0.1, 0]
look.color = {[PLATE] * 3}
look.ior = 1
[camera]
position = {list(CAMERA)}
target = {list(TARGET)}
vertical_fov = {FOV}
[light.lamp]
position = {list(LAMP)}
target = {list(LAMP_TARGET)}
size = {LAMP_SIZE}
power = {LAMP_POWER}
[render]
size = [{WIDTH}, {HEIGHT}]
samples = {samples}
bounces = 32
denoise = "none"
exr = true
sky.kind = "constant"
sky.color = {list(SKY)}
"""


def cycles_picture(folder, look, samples, name, factor=4 * math.pi):
    job = {"mesh": str(folder / "body.obj"), "look": look, "plate": PLATE, "lamp": LAMP, "lamp_target": LAMP_TARGET,
           "lamp_size": LAMP_SIZE, "lamp_power": LAMP_POWER, "sky": SKY, "camera": CAMERA, "target": TARGET, "fov": FOV,
           "samples": samples, "width": WIDTH, "height": HEIGHT, "out": str(folder / f"{name}-cycles.exr"),
           "radius_factor": factor}
    script = folder / "inside.py"
    script.write_text(INSIDE)
    subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "-P", str(script), "--",
                    json.dumps(job)], check=True, stdout=subprocess.DEVNULL)
    return Exr(folder / f"{name}-cycles.exr").layer("", "RGB")


def our_picture(program, folder, look, samples, name, place):
    (folder / f"{name}.toml").write_text(scene_of(look, samples, place))
    subprocess.run([program, "run", f"{name}.toml", "-o", name, "--frames", "1", "--quiet"], cwd=folder, check=True)
    return Exr(folder / name / "frames" / "0001.exr").layer("", "RGB")


def shown(pixels):
    """8-bit sRGB"""
    code = lambda v: round(255 * (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055))
    return [tuple(code(min(max(c, 0), 1)) for c in p) for p in pixels]


def main(program, samples=1024):
    program, failed = str(Path(program).resolve()), []
    with tempfile.TemporaryDirectory() as path:
        folder = Path(path)
        mesh, place = body_mesh()
        (folder / "body.obj").write_text(mesh)
        for name, look in LOOKS.items():
            theirs = cycles_picture(folder, look, samples, name)
            ours = our_picture(program, folder, look, 4 * samples, name, place)  # which takes as long
            for who, pixels in (("umax", ours), ("cycles", theirs)):
                (folder / f"{name}-{who}.png").write_bytes(png_of(WIDTH, HEIGHT, shown(pixels)))
            answer = subprocess.run([program, "compare", f"{name}-umax.png", f"{name}-cycles.png", "--max-flip",
                                     str(MOST_FLIP)], cwd=folder, capture_output=True, text=True)
            print(name, answer.stdout.strip().splitlines()[0])
            mean = [sum(p[c] for p in ours) / sum(p[c] for p in theirs) for c in range(3)]
            print(f"  umax over Cycles, mean of the picture: {mean[0]:.3f} {mean[1]:.3f} {mean[2]:.3f}")
            if answer.returncode:
                failed.append(name)
    assert not failed, f"{', '.join(failed)}: farther from Cycles than it may be"
    print("passed")


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
