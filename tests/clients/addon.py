"""What the tests of the Blender add-on share: a Blender of its own with the add-on's zip installed, and a scene in it."""
import json
import os
import subprocess
from pathlib import Path

# inside of Blender: installs and turns on the add-on as a user does; `job` is what the test handed over
START = r"""
import bpy, json, math, os, sys
from mathutils import Matrix, Vector
bpy.context.preferences.view.show_splash = False
job = json.loads(open(os.environ["UMAX_JOB"]).read())
told = {}

def tell():
    with open(job["answer"], "w") as file:
        json.dump(told, file)

def install():
    if bpy.app.version < (4, 2):
        bpy.ops.preferences.addon_install(filepath=job["zip"], overwrite=True)
        name = "umax"
        bpy.ops.preferences.addon_enable(module=name)
    else:
        import bl_ext  # noqa
        bpy.ops.extensions.package_install_files(filepath=job["zip"], repo="user_default", enable_on_install=True)
        name = "bl_ext.user_default.umax"
    bpy.context.preferences.addons[name].preferences.program = job["program"]
    return sys.modules[name]

def world_points(thing):
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return [list(evaluated.matrix_world @ v.co) for v in evaluated.to_mesh().vertices]

def make_scene():
    '''a turned, stretched ball on an animated parent and a box with a vertex of no face, above a floor; fps 24, frames 5
    to 20, a unit of 10 cm'''
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 5, 20, 24
    scene.unit_settings.scale_length = 0.1
    scene.umax.folder = job["folder"]
    bpy.ops.object.empty_add(location=(3, 1, 0))
    carrier = bpy.context.object
    carrier.keyframe_insert("location", frame=5)
    carrier.location = (5, 0, 1)
    carrier.rotation_euler = (0, 0, 1)
    carrier.keyframe_insert("location", frame=20)
    carrier.keyframe_insert("rotation_euler", frame=20)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=2, location=(0, 0, 4), rotation=(0.4, 0.2, 1))
    ball = bpy.context.object
    ball.name, ball.scale, ball.parent = "My Ball", (1, 1.2, 0.8), carrier
    ball.umax.role, ball.umax.cells = "BODY", 40
    group = ball.vertex_groups.new(name="firm")
    for vertex in ball.data.vertices:
        group.add([vertex.index], (vertex.co.z + 2) / 4, "REPLACE")
    ball.modifiers.new("smooth", "SUBSURF")
    mesh = bpy.data.meshes.new("box")
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    mesh.from_pydata(corners[:3] + [(4, 0, 0)] + corners[3:], [],
                     [(0, 1, 4, 2), (5, 7, 8, 6), (0, 5, 6, 1), (2, 4, 8, 7), (0, 2, 7, 5), (1, 6, 8, 4)])
    box = bpy.data.objects.new("box", mesh)
    scene.collection.objects.link(box)
    box.location, box.umax.role, box.umax.cells = (-6, 0, 1.5), "BODY", 8
    bpy.ops.mesh.primitive_plane_add(size=60)
    bpy.context.object.name, bpy.context.object.umax.role = "floor", "COLLIDER"
    return scene, ball, box
"""


class Blender:
    """Blender with settings of its own in `folder`, so that nobody's are touched."""

    def __init__(self, program, zip_file, folder):
        self.folder = Path(folder)
        self.job = dict(program=str(Path(program).resolve()), zip=str(Path(zip_file).resolve()),
                        folder=str(self.folder / "bake"), answer=str(self.folder / "answer.json"))
        self.environment = dict(os.environ, UMAX_JOB=str(self.folder / "job.json"))
        for name in ("CONFIG", "SCRIPTS", "DATAFILES", "EXTENSIONS", "RESOURCES"):
            path = self.folder / name.lower()
            path.mkdir(exist_ok=True)
            self.environment[f"BLENDER_USER_{name}"] = str(path)

    def run(self, script, *words, environment=None, **more):
        """what the script told, in a Blender with these words on its command line"""
        (self.folder / "job.json").write_text(json.dumps(dict(self.job, **more)))
        (self.folder / "inside.py").write_text(START + script)
        done = subprocess.run(["blender", *words, "--factory-startup", "--python-exit-code", "1", "--python",
                               str(self.folder / "inside.py")], env=dict(self.environment, **(environment or {})),
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        if done.returncode != 0:
            raise AssertionError(f"Blender ended with {done.returncode}:\n{done.stdout[-4000:]}")
        return json.loads(Path(self.job["answer"]).read_text())


class Screen:
    """A screen in memory; its value is what DISPLAY should be."""

    def __enter__(self):
        reader, writer = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(writer), "-screen", "0", "1600x1200x24", "-nolisten",
                                        "tcp"], pass_fds=[writer], stderr=subprocess.DEVNULL)
        os.close(writer)
        with os.fdopen(reader) as answer:
            number = answer.readline().strip()
        assert number, "Xvfb did not start"
        return f":{number}"

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()
