#!/usr/bin/python3
"""umax takes a camera that Blender has animated and exported as glTF: what a pixel of its picture shows is where Blender's
camera sees it, within a tenth of a pixel.

usage: blender_camera.py PROGRAM
"""
import json
import os
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import clients  # noqa: E402
from exr import Exr  # noqa: E402

FRAMES, WIDTH, HEIGHT = [1, 7, 20], 96, 54

# inside of Blender: a camera on a turning rail, exported; and where it sees points, given as y up
ANIMATE = r"""
import bpy, json, math, sys
job = json.loads(sys.argv[sys.argv.index("--") + 1])
scene = bpy.context.scene
for thing in list(bpy.data.objects): bpy.data.objects.remove(thing)
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = job["width"], job["height"], 100
scene.render.fps, scene.frame_start, scene.frame_end = job["fps"], 1, 24
rail = bpy.data.objects.new("rail", None)
camera = bpy.data.objects.new("shot", bpy.data.cameras.new("lens"))
camera.data.lens = 40
scene.collection.objects.link(rail)
scene.collection.objects.link(camera)
scene.camera, camera.parent = camera, rail
for frame, angle, place in ((1, 0, (0.3, -3, 0.5)), (24, 35, (0.2, -2.2, 0.9))):
    rail.rotation_euler = (0, math.radians(angle / 6), math.radians(angle))
    rail.keyframe_insert("rotation_euler", frame=frame)
    camera.location, camera.rotation_euler = place, (math.radians(85), 0, 0)
    camera.keyframe_insert("location", frame=frame)
    camera.keyframe_insert("rotation_euler", frame=frame)
"""
EXPORT = ANIMATE + r"""
bpy.ops.export_scene.gltf(filepath=job["file"], export_cameras=True, export_format=job["format"])
"""
LOOK = ANIMATE + r"""
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
seen = []
for frame, points in job["points"]:
    scene.frame_set(frame)
    places = [world_to_camera_view(scene, camera, Vector((x, -z, y))) for x, y, z in points]
    seen.append([[p.x * job["width"], (1 - p.y) * job["height"]] for p in places])
open(job["answer"], "w").write(json.dumps(seen))
"""


def blender(script, folder, job):
    (folder / "job.json").write_text(json.dumps(job))
    script_file = folder / "inside.py"
    script_file.write_text(script.replace('json.loads(sys.argv[sys.argv.index("--") + 1])',
                                          'json.load(open(sys.argv[sys.argv.index("--") + 1]))'))
    # the glTF exporter needs numpy, which is the system's: another Python first in PATH would hide it
    environment = dict(os.environ, PATH="/usr/bin:/bin:" + os.environ.get("PATH", ""))
    subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(script_file), "--",
                    str(folder / "job.json")], check=True, stdout=subprocess.DEVNULL, env=environment)


def test(umax, folder):
    job = dict(width=WIDTH, height=HEIGHT, fps=clients.FPS)
    for form, ending in (("GLB", "glb"), ("GLTF_SEPARATE", "gltf")):
        blender(EXPORT, folder, dict(job, file=str(folder / f"shot.{ending}"), format=form))
        umax(["render", "clip", "--size", f"{WIDTH}x{HEIGHT}", "--samples", "1", "--frames",
              ",".join(map(str, FRAMES)), "--overwrite", "--set", "render.layers=[\"depth\", \"position\"]",
              "--set", f"camera.file={folder}/shot.{ending}"])
        points, pixels = [], []
        for frame in FRAMES:
            picture = Exr(folder / "clip" / "frames" / f"{frame:04}.exr")
            depth, position = picture.channels["Z"], picture.layer("P", "XYZ")
            seen = [i for i in range(0, WIDTH * HEIGHT, 7) if depth[i] < 20]
            assert len(seen) > 100, f"frame {frame} shows {len(seen)} points"
            points.append([frame, [position[i] for i in seen]])
            pixels.append([(i % WIDTH + 0.5, i // WIDTH + 0.5) for i in seen])
        blender(LOOK, folder, dict(job, points=points, answer=str(folder / "answer.json")))
        worst = max(abs(a - b) for there, here in zip(json.loads((folder / "answer.json").read_text()), pixels)
                    for p, q in zip(there, here) for a, b in zip(p, q))
        assert worst < 0.1, f"{ending}: a point is {worst:.3g} pixels away"
        print(f"{ending}: within {worst:.2g} pixels")


if __name__ == "__main__":
    clients.main(test)
