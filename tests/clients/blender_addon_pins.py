#!/usr/bin/python3
"""Pins that the add-on bakes hold: points that an empty leads, those that the body's own shape keys lead, and what is inside of
a mesh that turns or deforms.

usage: blender_addon_pins.py PROGRAM ZIP
"""
import math
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import addon  # noqa: E402
import clients  # noqa: E402

PINNED = r"""
install()
for thing in list(bpy.data.objects):
    bpy.data.objects.remove(thing)
scene = bpy.context.scene
scene.frame_start, scene.frame_end, scene.render.fps = 1, 16, 24
scene.umax.folder, scene.umax.substeps = job["folder"], 2

def ball_at(x, name):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.5, location=(x, 0, 2))
    ball = bpy.context.object
    ball.name, ball.umax.role, ball.umax.cells, ball.umax.stiffness = name, "BODY", 100, 50
    ball.umax.limit = "none"
    group = ball.vertex_groups.new(name="held")
    group.add([v.index for v in ball.data.vertices if v.co.z > 0.2], 1, "REPLACE")
    return ball

# points that an empty leads
led = ball_at(0, "led")
bpy.ops.object.empty_add(location=(0, 0, 2))
handle = bpy.context.object
handle.keyframe_insert("location", frame=1)
handle.keyframe_insert("rotation_euler", frame=1)
handle.location, handle.rotation_euler = (0.5, 0, 2.2), (0.2, 0.3, 0.6)
handle.keyframe_insert("location", frame=16)
handle.keyframe_insert("rotation_euler", frame=16)
pin = led.umax.pins.add()
pin.group, pin.target = "held", handle

# points that the body's own shape keys lead
posed = ball_at(3, "posed")
posed.shape_key_add(name="rest")
key = posed.shape_key_add(name="up")
for point, vertex in zip(key.data, posed.data.vertices):
    point.co = vertex.co * 1.1 + Vector((0, 0, 0.3))
key.value = 0
key.keyframe_insert("value", frame=1)
key.value = 1
key.keyframe_insert("value", frame=16)
posed.umax.pins.add().group = "held"

# what is inside of a mesh that turns
filled = ball_at(6, "filled")
bpy.ops.mesh.primitive_cube_add(size=0.4, location=(6, 0, 2))
bone = bpy.context.object
bone.name = "bone"
bone.keyframe_insert("rotation_euler", frame=1)
bone.rotation_euler = (0, 0, 1)
bone.keyframe_insert("rotation_euler", frame=16)
filled.umax.pins.add().target = bone

# what is inside of a mesh that deforms, and of which a vertex has no face
kneaded = ball_at(9, "kneaded")
mesh = bpy.data.meshes.new("core")
corners = [(x, y, z) for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (-0.2, 0.2)]
mesh.from_pydata([(0, 0, 0)] + corners, [], [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)])
core = bpy.data.objects.new("core", mesh)
scene.collection.objects.link(core)
core.location = (9, 0, 2)
core.shape_key_add(name="rest")
key = core.shape_key_add(name="raised")
for point, vertex in zip(key.data, mesh.vertices):
    point.co = vertex.co + Vector((0, 0, 0.3 if vertex.co.z > 0.1 else 0.2))
key.value = 0
key.keyframe_insert("value", frame=1)
key.value = 1
key.keyframe_insert("value", frame=16)
kneaded.umax.pins.add().target = core

# one that is let go after frame 6, and one that hangs on springs
dropped, hung = ball_at(12, "dropped"), ball_at(15, "hung")
pin = dropped.umax.pins.add()
pin.group, pin.is_timed, pin.first_frame, pin.last_frame = "held", True, 1, 6
pin = hung.umax.pins.add()
pin.group, pin.is_spring, pin.spring = "held", True, 2000

bodies = (led, posed, filled, kneaded, dropped, hung)
told["wanted"] = []
for frame in range(1, 17):
    scene.frame_set(frame)
    told["wanted"].append([world_points(posed), [list(row) for row in handle.matrix_world],
                           [list(row) for row in bone.matrix_world]])
bpy.ops.umax.bake()
told["message"] = scene.umax.message
told["held"] = [v.index for v in led.data.vertices if v.co.z > 0.2]
told["points"] = []
for frame in range(1, 17):
    scene.frame_set(frame)
    told["points"].append([world_points(body) for body in bodies])
filled.umax.pins[0].target = None
try:
    bpy.ops.umax.bake()
except RuntimeError as error:
    told["nothing"] = str(error)
tell()
"""


def along(now, start, point):
    """where a point goes that moves with a matrix; matrices turn and move only"""
    local = [sum(start[k][axis] * (point[k] - start[k][3]) for k in range(3)) for axis in range(3)]
    return [now[axis][3] + sum(now[axis][k] * local[k] for k in range(3)) for axis in range(3)]


def check_pinned(told):
    """what is held is where it is led; the rest lags behind"""
    assert told["message"].startswith("16 frames of 6 bodies"), told["message"]
    first_points, (_, first_handle, first_bone) = told["points"][0], told["wanted"][0]
    for number, ((led, posed, filled, kneaded, _, _), (own, handle, bone)) in enumerate(zip(told["points"], told["wanted"])):
        for v in told["held"]:
            error = clients.farthest([led[v]], [along(handle, first_handle, first_points[0][v])])
            assert error < 1e-5, f"led, frame {number + 1}: {error:.2g} m away"
            error = clients.farthest([posed[v]], [own[v]])
            assert error < 1e-3, f"posed, frame {number + 1}: {error:.2g} m away"
    free = [v for v in range(len(led)) if v not in told["held"]]
    moved = [math.dist(led[v], along(handle, first_handle, first_points[0][v])) for v in free]
    assert max(moved) > 0.01, "all of it is held"
    turned = clients.farthest(filled, [along(bone, first_bone, point) for point in first_points[2]])
    assert turned < 0.25 and clients.farthest(filled, first_points[2]) > 0.2, turned
    height = [sum(z for _, _, z in frame[3]) / len(kneaded) for frame in (told["points"][0], told["points"][-1])]
    assert 0.15 < height[1] - height[0] < 0.35, height  # without its pin it would fall by 1.9 m
    check_let_go([frame[4] for frame in told["points"]], [frame[5] for frame in told["points"]], told["held"])
    assert "pin 1 says neither" in told["nothing"], told["nothing"]


def check_let_go(dropped, hung, held):
    """the one falls from its last frame on, the other one is pulled up by springs that its weight stretches"""
    fallen = [max(math.dist(frame[v], dropped[0][v]) for v in held) for frame in dropped]
    assert max(fallen[:6]) < 1e-5, f"held, but {max(fallen[:6]):.2g} m away"
    assert fallen[7] > 1e-3 and fallen[15] > 0.4, fallen  # 9.5 frames of 1/24 s: 0.77 m
    sunk = [hung[0][held[0]][2] - frame[held[0]][2] for frame in hung]
    assert 1e-3 < max(sunk) < 0.2, sunk


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        check_pinned(addon.Blender(sys.argv[1], sys.argv[2], temporary).run(PINNED, "-b"))
    print("passed")
