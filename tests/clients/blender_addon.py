#!/usr/bin/python3
"""The add-on bakes by `blender -b`: every vertex of every frame is where the states have it, whatever the objects' transforms,
unit and frame range; only what has changed is made again; errors are those of umax.

usage: blender_addon.py PROGRAM ZIP
"""
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import addon  # noqa: E402
import clients  # noqa: E402

INSIDE = r"""
import shutil, subprocess
module = install()
scene, ball, box = make_scene()
ball.umax.limit_group, ball.umax.limit_range = "firm", (0.5, 2)
ball.umax.stiffness_group = "firm"
assert bpy.ops.umax.preset.poll()
bpy.context.view_layer.objects.active = ball
bpy.ops.umax.preset(name="gel")
told["gel"] = [ball.umax.stiffness, ball.umax.density, ball.umax.stretch, ball.umax.damping]
scene.frame_set(7)
assert bpy.ops.umax.bake() == {"FINISHED"}
assert scene.frame_current == 7
told["message"] = scene.umax.message
told["modifiers"] = [m.type for m in ball.modifiers]
ball.modifiers["smooth"].show_viewport = False
told["points"] = []
for frame in range(5, 21):
    scene.frame_set(frame)
    told["points"].append([world_points(ball), world_points(box)])

def states():
    folder = job["folder"] + "/run/states"
    return {name: os.stat(folder + "/" + name).st_mtime_ns for name in sorted(os.listdir(folder))}

ball.modifiers["smooth"].show_viewport = True
subprocess.run([job["program"], "export", job["folder"] + "/run", "--format", "pc2", "-o", job["exported"], "--quiet"],
               check=True)  # y up, in metres
shutil.copytree(job["folder"] + "/input", job["first"])
told["states"] = [states()]
bpy.ops.umax.bake()  # nothing has changed
told["states"].append(states())
scene.frame_end = 22  # a longer clip goes on
bpy.ops.umax.bake()
told["states"].append(states())
ball.umax.stretch = 5  # another limit is another simulation
bpy.ops.umax.bake()
told["states"].append(states())
box.data.vertices[0].co.x -= 0.5
bpy.ops.umax.bake()
told["states"].append(states())

def error_of():
    try:
        bpy.ops.umax.bake()
    except RuntimeError as error:
        return [str(error), scene.umax.message, scene.umax.is_error]
    return None

ball.parent = None
ball.location = box.location
told["overlap"] = error_of()
told["scene"] = open(job["folder"] + "/input/scene.toml").read()
ball.umax.limit_group = "soft"
told["group"] = error_of()
ball.umax.limit_group = ""
preferences = bpy.context.preferences.addons[module.__name__].preferences
preferences.program = "/nowhere/umax"
told["program"] = error_of()
preferences.program = job["program"]
scene.umax.folder = "//umax"
told["unsaved"] = error_of()
scene.umax.folder = "/proc/umax"
told["unwritable"] = error_of()
scene.umax.folder = job["foreign"]
told["foreign"] = error_of()
told["kept"] = os.path.exists(job["foreign"] + "/run/mine")
scene.umax.folder = job["folder"]
ball.hide_set(True)
told["hidden"] = error_of()
ball.umax.role = box.umax.role = "NONE"
told["nobody"] = error_of()
bpy.ops.umax.free()
told["left"] = os.path.exists(job["folder"])
told["freed"] = [m.name for thing in (ball, box) for m in thing.modifiers]
tell()
"""

RIGGED = r"""
import subprocess
install()
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
scene = bpy.context.scene
scene.frame_start, scene.frame_end, scene.render.fps = 1, 24, 24
scene.umax.folder = job["folder"]

# a bar of two bones, whose far half lifts what lies on it; with a vertex of no face
bpy.ops.object.armature_add(location=(0, 0, 0))
rig = bpy.context.object
bpy.ops.object.mode_set(mode="EDIT")
bones = rig.data.edit_bones
bones[0].head, bones[0].tail = (-2, 0, 0), (0, 0, 0)
far = bones.new("far")
far.head, far.tail, far.parent = (0, 0, 0), (2, 0, 0), bones[0]
near_name, far_name = bones[0].name, far.name
bpy.ops.object.mode_set(mode="OBJECT")
bar_mesh = bpy.data.meshes.new("bar")
xs = [-2 + 0.5 * i for i in range(9)]
ring = [(-0.6, -0.2), (0.6, -0.2), (0.6, 0.2), (-0.6, 0.2)]
points = [(0, 0, 0)] + [(x, y, z) for x in xs for y, z in ring]
faces = [(4, 3, 2, 1), (33, 34, 35, 36)] + [(1 + 4 * i + k, 1 + 4 * i + (k + 1) % 4, 5 + 4 * i + (k + 1) % 4, 5 + 4 * i + k)
                                           for i in range(8) for k in range(4)]
bar_mesh.from_pydata(points, [], faces)
bar = bpy.data.objects.new("bar", bar_mesh)
scene.collection.objects.link(bar)
for name, is_far in ((near_name, False), (far_name, True)):
    group = bar.vertex_groups.new(name=name)
    group.add([v.index for v in bar_mesh.vertices if (v.co.x > 0.1) == is_far], 1, "REPLACE")
bar.modifiers.new("rig", "ARMATURE").object = rig
bar.umax.role = "COLLIDER"
pose = rig.pose.bones[far_name]
pose.rotation_mode = "XYZ"
pose.keyframe_insert("rotation_euler", frame=8)
pose.rotation_euler = (0, 0, 0)
pose.rotation_euler[0] = pose.rotation_euler[2] = 0.4
pose.keyframe_insert("rotation_euler", frame=16)

# a paddle that swings fast about an axis that is not its own, and is mirrored
bpy.ops.mesh.primitive_cube_add(size=1, location=(-4, 3, 1), rotation=(0.3, 0.1, 0.5))
paddle = bpy.context.object
paddle.name, paddle.scale, paddle.umax.role = "paddle", (0.2, -1, 2), "COLLIDER"
paddle.keyframe_insert("rotation_euler", frame=1)
paddle.keyframe_insert("location", frame=1)
paddle.rotation_euler, paddle.location = (0.3, 2.5, 7), (4, 3, 2)
paddle.keyframe_insert("rotation_euler", frame=10)
paddle.keyframe_insert("location", frame=10)

bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.4, location=(1.2, 0, 0.65))
ball = bpy.context.object
ball.name, ball.umax.role, ball.umax.cells, ball.umax.friction = "ball", "BODY", 60, 1
bpy.ops.umax.bake()
told["message"] = scene.umax.message
told["text"] = open(job["folder"] + "/input/scene.toml").read()
subprocess.run([job["program"], "export", job["folder"] + "/run", "--format", "pc2", "-o", job["exported"], "--quiet"],
               check=True)
told["points"] = []
for frame in range(1, 25):
    scene.frame_set(frame)
    told["points"].append([world_points(ball), world_points(bar)[1:], world_points(paddle)])
bar.modifiers.new("changing", "DECIMATE").ratio = 0.5
bar.modifiers["changing"].keyframe_insert("ratio", frame=1)
bar.modifiers["changing"].ratio = 1
bar.modifiers["changing"].keyframe_insert("ratio", frame=9)
try:
    bpy.ops.umax.bake()
except RuntimeError as error:
    told["changing"] = str(error)
tell()
"""

def check_rigged(told, folder):
    """bodies and colliders are in the run where Blender shows them; the arm lifts the ball"""
    assert told["message"].startswith("24 frames of 1 body"), told["message"]
    assert 'cache = "bar.pc2"' in told["text"] and "rotation = { keys" in told["text"]
    for index, (name, tolerance) in enumerate((("ball", 1e-6), ("obstacle.bar", 1e-5), ("obstacle.paddle", 1e-5))):
        frames = clients.read_pc2(folder / f"exported/{name}.pc2")[2]
        assert len(frames) == len(told["points"]) == 24
        for number, (wanted, things) in enumerate(zip(frames, told["points"])):
            error = clients.farthest([(x, z, -y) for x, y, z in things[index]], wanted)
            assert error <= tolerance, f"{name}, frame {number + 1}: {error:.2g} m away"
    samples = clients.read_pc2(folder / "bake/input/bar.pc2")[2]
    assert len(samples) > 24 and (len(samples) - 1) % 23 == 0, "what is fast is looked at more often"
    heights = [sum(z for _, _, z in ball) / len(ball) for ball, _, _ in told["points"]]
    assert max(heights) > heights[0] + 0.2, heights
    header, *rows = (line.split(",") for line in (folder / "bake/run/steps.csv").read_text().splitlines())
    deepest = max(float(row[header.index("max_penetration_m")]) for row in rows)
    assert deepest < 0.01, deepest
    assert "bar: has " in told["changing"] and "turn off the modifier" in told["changing"], told["changing"]


def check_points(told, folder):
    """against another export of the same states: y up, in metres"""
    for index, name in enumerate(("My_Ball", "box")):
        frames = clients.read_pc2(folder / f"exported/{name}.pc2")[2]
        assert len(frames) == len(told["points"]) == 16
        for number, (wanted, bodies) in enumerate(zip(frames, told["points"])):
            found = [(0.1 * x, 0.1 * z, -0.1 * y) for x, y, z in bodies[index]]
            error = clients.farthest(found, wanted)
            assert error <= 1e-6, f"{name}, frame {number + 1}: {error:.2g} m away"
        assert clients.farthest(frames[0], frames[-1]) > 0.05, "nothing moves"


def check_painted(path):
    """weights of 0 and 1 are black and white"""
    data = path.read_bytes()
    start = data.index(b"end_header\n") + 11
    count = int(data.split(b"element vertex ")[1].split()[0])
    values = [struct.unpack_from("<6f", data, start + 24 * i) for i in range(count)]
    greys = [v[3] for v in values]
    assert all(v[3] == v[4] == v[5] for v in values) and min(greys) == 0 and max(greys) == 1
    middle = [g for g in greys if 0.7 < g < 0.76]
    assert middle, "a weight of one half is 0.735 in sRGB"


def check_rebakes(told):
    first, same, longer, other, moved = told["states"]
    assert len(first) == 16 and first == same
    assert len(longer) == 18 and all(longer[name] == time for name, time in first.items())
    assert len(other) == 18 and all(other[name] != time for name, time in longer.items())
    assert len(moved) == 18 and all(moved[name] != time for name, time in other.items())


def check_errors(told):
    assert "umax: error: " in told["overlap"][1] and "My_Ball" in told["overlap"][1], told["overlap"]
    assert told["overlap"][1] in told["overlap"][0] and told["overlap"][2]
    assert 'My Ball: has no vertex group "soft"' in told["group"][1], told["group"]
    assert "/nowhere/umax" in told["program"][1] and "Preferences" in told["program"][1]
    assert "save it" in told["unsaved"][1]
    assert "/proc/umax" in told["unwritable"][1]
    assert "foreign/run: is there and of no bake" in told["foreign"][1] and told["kept"], told["foreign"]
    assert "My Ball: is hidden" in told["hidden"][1], told["hidden"]
    assert "no object takes part" in told["nobody"][1]
    assert not told["left"] and "umax" not in told["freed"]


def check_versions(program, zip_file):
    """the add-on has the program's version"""
    version = subprocess.run([program, "--version"], check=True, stdout=subprocess.PIPE, text=True).stdout.split()[1]
    with zipfile.ZipFile(zip_file) as packed:
        assert f'\nversion = "{version}"' in packed.read("umax/blender_manifest.toml").decode()
        assert f'"version": ({version.replace(".", ", ")}),' in packed.read("umax/__init__.py").decode()


def test(program, zip_file, folder):
    check_versions(program, zip_file)
    blender = addon.Blender(program, zip_file, folder)
    (folder / "foreign/run").mkdir(parents=True)
    (folder / "foreign/run/mine").write_text("no bake's")
    told = blender.run(INSIDE, "-b", first=str(folder / "first"), foreign=str(folder / "foreign"),
                       exported=str(folder / "exported"))
    assert told["message"].splitlines() == [
        "16 frames of 2 bodies", "umax: warning: body.box: 1 vertex belongs to no triangle: left out"], told["message"]
    assert told["modifiers"] == ["MESH_CACHE", "SUBSURF"]
    assert all(abs(a - b) < 1e-3 for a, b in zip(told["gel"], [8, 1050, 40, 1])), told["gel"]
    check_points(told, folder)
    check_painted(folder / "first/My_Ball.map.ply")
    text = (folder / "first/scene.toml").read_text()
    for line in ("frames = 16", "fps = 24.0", "gravity = [0.0, -9.81, 0.0]", "[body.My_Ball]", 'up = "z"', "unit = 0.1",
                 'limit.map = "My_Ball.map.ply"', "limit.map_range = [0.5, 2.0]",
                 'material.young_map = "My_Ball.young_map.ply"', "[obstacle.floor]", 'shape = "plane"'):
        assert line in text.splitlines(), (line, text)
    check_rebakes(told)
    check_errors(told)


def test_rigged(program, zip_file, folder):
    blender = addon.Blender(program, zip_file, folder)
    check_rigged(blender.run(RIGGED, "-b", exported=str(folder / "exported")), folder)


if __name__ == "__main__":
    for part in (test, test_rigged):
        with tempfile.TemporaryDirectory() as temporary:
            part(sys.argv[1], sys.argv[2], Path(temporary))
    print("passed")
