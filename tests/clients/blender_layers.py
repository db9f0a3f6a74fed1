#!/usr/bin/python3
"""Blender takes the layers that umax renders for compositing: its Cryptomatte node picks bodies and materials, and Cycles,
which renders the exported meshes through the camera of the EXR's header, has the same depth, positions and motion.

usage: blender_layers.py PROGRAM
"""
import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import clients  # noqa: E402
from exr import Exr  # noqa: E402

FRAME, WIDTH, HEIGHT = 9, 96, 54

# inside of Blender: picks mattes from our picture, then renders the exported meshes with Cycles
INSIDE = r"""
import bpy, json, math, os, sys
from mathutils import Matrix
job = json.loads(sys.argv[sys.argv.index("--") + 1])
scene = bpy.context.scene
for thing in list(bpy.data.objects): bpy.data.objects.remove(thing)
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = job["width"], job["height"], 100
scene.render.fps = job["fps"]
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.exr_codec = "ZIP"
scene.view_settings.view_transform = "Standard"
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera = camera

# --- mattes
image = bpy.data.images.load(job["exr"])
image.size[0]  # makes Blender read it
assert image.type == "MULTILAYER", image.type
scene.use_nodes = True
tree = scene.node_tree
for layer, names in job["mattes"].items():
    for name in names:
        tree.nodes.clear()
        node = tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source = "IMAGE"
        node.image = image
        node.layer_name = layer
        node.matte_id = name
        out = tree.nodes.new("CompositorNodeComposite")
        tree.links.new(node.outputs["Matte"], out.inputs["Image"])
        scene.render.filepath = f"{job['folder']}/{layer}-{name}.exr"
        bpy.ops.render.render(write_still=True)

# --- the same with Cycles
tree.nodes.clear()
scene.use_nodes = False
camera.matrix_world = Matrix(job["camera_to_world"])
camera.data.sensor_fit, camera.data.angle_y = "VERTICAL", math.radians(job["fov"])
camera.data.sensor_fit = "VERTICAL"
for name in job["caches"]:
    ply = f"{job['caches_folder']}/{name}.ply"  # of meshes with vertices of no face, which the importer of OBJ leaves out
    if not os.path.exists(ply):
        bpy.ops.wm.obj_import(filepath=f"{job['caches_folder']}/{name}.obj", forward_axis="Y", up_axis="Z")
    elif bpy.app.version < (4, 0, 0):
        bpy.ops.import_mesh.ply(filepath=ply)
    else:
        bpy.ops.wm.ply_import(filepath=ply, forward_axis="Y", up_axis="Z")
    thing = bpy.context.selected_objects[0]
    cache = thing.modifiers.new("cache", "MESH_CACHE")
    cache.cache_format, cache.filepath = "PC2", f"{job['caches_folder']}/{name}.pc2"
    cache.forward_axis, cache.up_axis, cache.frame_start = "POS_Y", "POS_Z", 1
scene.render.engine = "CYCLES"
scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 1, False
scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
passes = bpy.context.view_layer
passes.use_pass_z = passes.use_pass_position = passes.use_pass_vector = True
scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
scene.frame_set(job["frame"])
scene.render.filepath = job["folder"] + "/cycles.exr"
bpy.ops.render.render(write_still=True)
"""


def inverse_of_rigid(rows):
    """of a matrix for row vectors, as one for column vectors: x, y right and up, and Blender's z against the view"""
    axes = [[rows[i][j] for i in range(3)] for j in range(3)]  # right, up, forward in the world
    position = [-sum(rows[3][j] * axes[j][i] for j in range(3)) for i in range(3)]
    return [[axes[0][i], axes[1][i], -axes[2][i], position[i]] for i in range(3)] + [[0, 0, 0, 1]]


def share_of(picture, layer, number):
    """of each pixel, what a name's number has"""
    shares = [0.0] * (picture.width * picture.height)
    for level in range(3):
        for i, (r, g, b, a) in enumerate(picture.layer(f"{layer}{level:02}", "rgba")):
            shares[i] += (g if r == number else 0) + (a if b == number else 0)
    return shares


def numbers_in(picture, key):
    """names and numbers of a manifest"""
    import struct
    return {name: struct.unpack(">f", bytes.fromhex(bits))[0]
            for name, bits in json.loads(picture.text(f"cryptomatte/{key}/manifest")).items()}


def check_mattes(ours, folder, mattes):
    for layer, names in mattes.items():
        key = {"CryptoObject": "3ae39a5", "CryptoMaterial": "be359d6"}[layer]
        assert ours.text(f"cryptomatte/{key}/name") == layer
        numbers = numbers_in(ours, key)
        for name in names:
            wanted = share_of(ours, layer, numbers[name])
            assert max(wanted) > 0.99 and any(0.05 < share < 0.95 for share in wanted), f"{name} has no inside or no edge"
            picked = Exr(folder / f"{layer}-{name}.exr").layer("", "R")
            error = max(abs(p[0] - w) for p, w in zip(picked, wanted))
            assert error <= 1e-5, f"{layer}, {name}: Blender picks {error:.3g} otherwise"
    total = [0.0] * (ours.width * ours.height)
    for number in numbers_in(ours, "3ae39a5").values():
        total = [t + s for t, s in zip(total, share_of(ours, "CryptoObject", number))]
    assert max(total) < 1 + 1e-5 and min(total) < 1e-5, "objects are more, or never less, than the picture"


def check_against_cycles(ours, theirs):
    """where both see the same object's inside"""
    depth, depth_there = ours.channels["Z"], theirs.channels["ViewLayer.Depth.Z"]
    inside = [i for i in range(len(depth)) if depth[i] < 1e9 and depth_there[i] < 1e9
              and abs(depth[i] - depth_there[i]) < 0.02]
    seen = sum(1 for z in depth if z < 1e9)
    assert seen > 250 and len(inside) > 0.97 * seen, f"Cycles sees {len(inside)} pixels where umax sees {seen}"
    assert max(depth) == max(depth_there) > 1e9, "nothing is at another depth in Cycles"
    error = sorted(abs(depth[i] - depth_there[i]) for i in inside)[int(0.98 * len(inside))]
    assert error < 2e-3, f"depths differ by {error:.3g} m"

    def worst(layer, theirs_name, letters):
        mine, other = ours.layer(layer, letters), theirs.layer(f"ViewLayer.{theirs_name}", letters)
        errors = sorted(max(abs(a - b) for a, b in zip(mine[i], other[i])) for i in inside)
        return errors[int(0.98 * len(errors))], max(max(map(abs, mine[i])) for i in inside)

    error, _ = worst("P", "Position", "XYZ")
    assert error < 2e-3, f"positions differ by {error:.3g} m"
    error, largest = worst("Vector", "Vector", "XYZW")
    assert largest > 1.5, f"nothing moves: {largest:.3g} pixels"
    assert error < 0.01, f"motion differs by {error:.3g} pixels of {largest:.3g}"
    print(f"motion up to {largest:.3g} pixels, 98 % within {error:.2g}")


def test(umax, folder):
    umax(["render", "clip", "--size", f"{WIDTH}x{HEIGHT}", "--samples", "64", "--frames", str(FRAME), "--set",
          "render.layers=all", "--set", "obstacle.ground.visible=false"])
    ours = Exr(folder / "clip" / "frames" / f"{FRAME:04}.exr")
    caches = umax.export("pc2")
    mattes = {"CryptoObject": ["cube", "ball", "obstacle.plate"], "CryptoMaterial": ["skin", "ball"]}
    job = dict(exr=str(folder / "clip" / "frames" / f"{FRAME:04}.exr"), folder=str(folder), width=WIDTH, height=HEIGHT,
               mattes=mattes, frame=FRAME, fps=clients.FPS, fov=30, caches=clients.MOVING, caches_folder=str(caches),
               camera_to_world=inverse_of_rigid(ours.matrix("worldToCamera")))
    (folder / "inside.py").write_text(INSIDE)
    subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(folder / "inside.py"),
                    "--", json.dumps(job)], check=True, stdout=subprocess.DEVNULL)
    check_mattes(ours, folder, mattes)
    check_against_cycles(ours, Exr(folder / "cycles.exr"))


if __name__ == "__main__":
    clients.main(test)
