#!/usr/bin/python3
"""Blender takes what umax exports: PC2 and MDD by its Mesh Cache, OBJ and PLY by its importers; every vertex of every frame.

usage: blender_caches.py PROGRAM
"""
import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import clients  # noqa: E402

# inside of Blender: imports the mesh at rest, lets the cache move it, and tells where the vertices are
INSIDE = r"""
import bpy, json, sys
job = json.loads(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = job["fps"]

def the_import():
    objects = [o for o in bpy.data.objects if o.type == "MESH"]
    assert len(objects) == 1, objects
    return objects[0]

def clear():
    for o in list(bpy.data.objects): bpy.data.objects.remove(o)

def import_ply(path):
    if bpy.app.version < (4, 0):
        bpy.ops.import_mesh.ply(filepath=path)
    else:
        bpy.ops.wm.ply_import(filepath=path, forward_axis="Y", up_axis="Z")

def points(thing):
    mesh = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    return [list(v.co) for v in mesh.vertices]

told = {}
for name in job["caches"]:
    for kind in ("pc2", "mdd"):
        clear()
        bpy.ops.wm.obj_import(filepath=f"{job['folder']}/{name}.obj", forward_axis="Y", up_axis="Z")
        materials = [m.name for m in the_import().data.materials]
        if name in job["loose"]:  # the importer of OBJ leaves vertices of no face out
            clear()
            import_ply(f"{job['folder']}/{name}.ply")
        thing = the_import()
        cache = thing.modifiers.new("cache", "MESH_CACHE")
        cache.cache_format = kind.upper()
        cache.filepath = f"{job['folder']}/{name}.{kind}"
        cache.forward_axis, cache.up_axis, cache.frame_start = "POS_Y", "POS_Z", 1
        frames = []
        for frame in range(1, job["frames"] + 1):
            scene.frame_set(frame)
            frames.append(points(thing))
        cache.play_mode, cache.time_mode, cache.frame_start = "CUSTOM", "TIME", 0
        # Blender takes this for frames, which it makes seconds of, with PC2, and for seconds with MDD
        cache.eval_time = 7 if kind == "pc2" else 7 / job["fps"]
        told[f"{name}.{kind}"] = dict(frames=frames, after_seven=points(thing),
                                      materials=materials,
                                      uvs=len(thing.data.uv_layers), colors=len(thing.data.color_attributes))
for path in job["meshes"]:
    clear()
    if path.endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    else:
        import_ply(path)
    thing = the_import()
    told[path] = dict(points=points(thing), uvs=len(thing.data.uv_layers), colors=len(thing.data.color_attributes))
open(job["answer"], "w").write(json.dumps(told))
"""


def check_near(what, found, wanted):
    size = clients.size_of(wanted)
    error = clients.farthest(found, wanted) / size
    assert error <= 1e-6, f"{what}: {error:.2g} of the size away"


def test(umax, folder):
    export = umax.export("pc2")
    for form in ("mdd", "obj", "ply"):
        umax.export(form)
    meshes = [f"{export}/{name}/{frame:04}.{form}" for name in clients.MOVING for form in ("obj", "ply")
              for frame in (1, 9, clients.FRAMES)]
    job = dict(folder=str(export), caches=clients.MOVING, loose=["cube"], frames=clients.FRAMES, fps=clients.FPS, meshes=meshes,
               answer=str(folder / "answer.json"))
    (folder / "inside.py").write_text(INSIDE)
    subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python", str(folder / "inside.py"),
                    "--", json.dumps(job)], check=True, stdout=subprocess.DEVNULL)
    told = json.loads((folder / "answer.json").read_text())

    for name in clients.MOVING:
        start, sampling, frames = clients.read_pc2(export / f"{name}.pc2")
        assert start == 0 and abs(sampling * clients.FPS - 1) < 1e-6 and len(frames) == clients.FRAMES
        times, same = clients.read_mdd(export / f"{name}.mdd")
        assert same == frames and clients.farthest([[t] for t in times], [[f / clients.FPS] for f in range(24)]) < 1e-6
        assert clients.farthest(frames[0], frames[-1]) > 0.05, "nothing moves"
        for kind in ("pc2", "mdd"):
            seen = told[f"{name}.{kind}"]
            assert len(seen["frames"]) == clients.FRAMES
            for number, found in enumerate(seen["frames"]):
                check_near(f"{name}.{kind}, frame {number + 1}", found, frames[number])
            check_near(f"{name}.{kind} by its time", seen["after_seven"], frames[7])
            wanted = ["skin", "lid"] if name == "cube" else [name.split(".")[-1]]
            assert [m.split(".")[0] for m in seen["materials"]] == wanted, seen["materials"]
            assert seen["uvs"] == (1 if name == "cube" else 0) and seen["colors"] == (1 if name == "cube" else 0)
        for form in ("obj", "ply"):
            for frame in (1, 9, clients.FRAMES):
                seen = told[f"{export}/{name}/{frame:04}.{form}"]
                wanted = frames[frame - 1]
                if name == "cube" and form == "obj":
                    wanted = [p for v, p in enumerate(wanted) if v not in clients.LOOSE]
                check_near(f"{name}, {form} of frame {frame}", seen["points"], wanted)
                assert seen["uvs"] == (1 if name == "cube" else 0), (form, seen["uvs"])
                assert seen["colors"] == (1 if name == "cube" else 0), (form, seen["colors"])


if __name__ == "__main__":
    clients.main(test)
