#!/usr/bin/python3
"""The add-on bakes by `blender -b`: every vertex of every frame is where the states have it, whatever the objects' transforms,
unit and frame range; only what has changed is made again; errors are those of umax.

usage: blender_addon.py PROGRAM ZIP
"""
import struct
import sys
import tempfile
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
scene.umax.folder = job["folder"]
ball.umax.role = box.umax.role = "NONE"
told["nobody"] = error_of()
bpy.ops.umax.free()
told["left"] = os.path.exists(job["folder"])
told["freed"] = [m.name for thing in (ball, box) for m in thing.modifiers]
tell()
"""


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
    assert "no object takes part" in told["nobody"][1]
    assert not told["left"] and "umax" not in told["freed"]


def test(program, zip_file, folder):
    blender = addon.Blender(program, zip_file, folder)
    told = blender.run(INSIDE, "-b", first=str(folder / "first"),
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


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        test(sys.argv[1], sys.argv[2], Path(temporary))
    print("passed")
