"""A bake from beginning to end, in small steps: look at the scene, simulate what has changed, export, attach.

FOLDER/input   the scene file and its meshes       FOLDER/run        states, as umax simulate leaves them
FOLDER/caches  NAME.pc2 of each body's object      FOLDER/bake.json  what all of this was made of
"""
import hashlib
import json
import os
import shutil
import struct

import bpy
from mathutils import Matrix

from . import attach, gather, point_cache, program, shapes

RECORD = "bake.json"
PARTS = ("input", "input.new", "run", "export", "caches")
EXPECTED = (gather.GatherError, shapes.ShapeError, point_cache.CacheError, program.ProgramError, attach.AttachError,
            OSError)


class Bake:
    """Call step() until it is done; close() ends it early. What goes wrong is an exception of EXPECTED."""

    def __init__(self, scene):
        self.scene_name = scene.name
        self.folder = folder_of(scene)
        self.stage, self.done, self.total, self.left = "Starting", 0, 1, None
        self.is_waiting = False  # for the program: there is nothing to do here
        self.is_done = False
        self.message = ""
        self.steps = self._steps()

    def step(self):
        try:
            next(self.steps)
        except StopIteration:
            self.is_done = True

    def close(self):
        self.steps.close()

    @property
    def fraction(self):
        return min(1.0, self.done / max(1, self.total))

    def _tell(self, stage, done, total, left=None):
        self.stage, self.done, self.total, self.left = stage, done, total, left

    def _steps(self):
        version = program.version()
        claim(self.folder)
        found = yield from self._gather()
        record = read_record(self.folder)
        digest = digest_of(version, found)
        last = found.scene.frame_end - found.scene.frame_start + 1
        if record.get("digest") != digest:
            write_record(self.folder, {})
            record = {"digest": digest, "frames": 0, "caches": {}}
        replace_folder(found.folder, os.path.join(self.folder, "input"))  # the length may be another one in any case
        warnings = []
        # a run knows its meshes by absolute paths: one that was moved along with its folder is looked at again
        if record["frames"] < last or record.get("folder") != self.folder or not os.path.isdir(self._run()):
            warnings = yield from self._simulate(record, last)
        yield from self._make_caches(record, found, last)
        self.message = "\n".join([f"{last} frames of {counted(len(found.bodies))}"] + warnings)

    def _gather(self):
        scene = bpy.data.scenes[self.scene_name]
        frame, part = scene.frame_current, scene.frame_subframe
        fresh = os.path.join(self.folder, "input.new")
        remove(fresh)
        os.makedirs(fresh)
        steps = gather.gather(scene, fresh)
        try:
            while True:
                done, total = next(steps)
                self._tell("Looking at colliders", done, total)
                yield
        except StopIteration as end:
            return end.value
        except BaseException:
            steps.close()
            remove(fresh)
            raise
        finally:
            bpy.data.scenes[self.scene_name].frame_set(frame, subframe=part)

    def _simulate(self, record, last):
        """The run goes on where one of the same input has stopped."""
        is_known = read_record(self.folder).get("digest") == record["digest"]
        write_record(self.folder, record)
        words = ["simulate", os.path.join("input", "scene.toml"), "-o", "run", "--resume" if is_known else "--overwrite"]
        warnings = yield from self._call("Simulating", words, last)
        record.update(frames=last, folder=self.folder)
        write_record(self.folder, record)
        return warnings

    def _call(self, stage, words, total):
        self._tell(stage, 0, total)
        run = program.Run(words, self.folder)
        self.is_waiting = True
        try:
            while run.is_running():
                for event in run.new_events():
                    if event.get("event") == "frame":
                        self._tell(stage, event["done"], event["total"], event.get("left_s"))
                yield
            return run.finish()
        finally:
            self.is_waiting = False
            run.stop()

    def _make_caches(self, record, found, last):
        """Of the bodies whose cache is missing or of something else."""
        wanted = {}
        for thing in found.bodies:
            name = found.names[thing.name]
            digest = hashlib.sha256(repr((last, name, found.unit)).encode())
            for matrix in found.matrices[thing.name]:
                digest.update(struct.pack("16d", *(number for row in matrix for number in row)))
            if record["caches"].get(thing.name) != digest.hexdigest() or not os.path.exists(self._cache(name)):
                wanted[thing.name] = digest.hexdigest()
        if wanted:
            names = ",".join(found.names[name] for name in wanted)
            yield from self._call("Exporting", ["export", "run", "--format", "pc2", "--bodies", names, "--frames",
                                                f"1-{last}", "--up", "z", "--scale", repr(1 / found.unit), "--overwrite",
                                                "-o", "export"], last)
            os.makedirs(os.path.join(self.folder, "caches"), exist_ok=True)
        for thing_name, digest in wanted.items():
            yield from self._localise(found, thing_name)
            record["caches"][thing_name] = digest
            write_record(self.folder, record)
        remove(os.path.join(self.folder, "export"))
        for thing_name in found.matrices:
            thing = bpy.data.objects.get(thing_name)
            if thing:
                attach.attach(thing, self._cache(found.names[thing_name]), found.scene)

    def _run(self):
        return os.path.join(self.folder, "run")

    def _cache(self, name):
        return os.path.join(self.folder, "caches", name + ".pc2")

    def _localise(self, found, thing_name):
        """From the world's coordinates to the object's, wherever it is in each frame."""
        name = found.names[thing_name]
        reader = point_cache.Reader(os.path.join(self.folder, "export", name + ".pc2"))
        writer = point_cache.Writer(self._cache(name), reader.num_vertices, reader.step)
        try:
            with shapes.Mover(reader.num_vertices) as mover:
                for index, matrix in enumerate(found.matrices[thing_name]):
                    positions = reader.read()
                    if matrix != Matrix.Identity(4):
                        positions = mover(matrix.inverted(), positions)
                    writer.append(positions)
                    self._tell(f"Writing {name}.pc2", index + 1, reader.count)
                    yield
            writer.finish()
        finally:
            reader.close()
            writer.discard()


def counted(bodies):
    return "1 body" if bodies == 1 else f"{bodies} bodies"


def folder_of(scene):
    """Throws GatherError where it has no place yet."""
    folder = scene.umax.folder
    if folder.startswith("//") and not bpy.data.filepath:
        raise gather.GatherError(f"the folder of the bake is {folder}, beside the .blend file, which is not saved yet: save "
                                 "it, or choose another folder")
    return os.path.realpath(bpy.path.abspath(folder))


def claim(folder):
    """Makes the folder, or sees to it that nothing is in the way that no bake has put there. Throws GatherError."""
    if os.path.exists(os.path.join(folder, RECORD)):
        return
    foreign = [part for part in PARTS if os.path.exists(os.path.join(folder, part))]
    if foreign:
        raise gather.GatherError(f"{os.path.join(folder, foreign[0])}: is there and of no bake: choose another folder")
    os.makedirs(folder, exist_ok=True)
    write_record(folder, {})


def digest_of(version, found):
    """of all that decides the states; how many frames there are does not"""
    digest = hashlib.sha256(version.encode())
    digest.update("\n".join(line for line in found.text.splitlines() if not line.startswith("frames = ")).encode())
    for name in sorted(set(found.files) - {"scene.toml"}):
        digest.update(name.encode())
        with open(os.path.join(found.folder, name), "rb") as file:
            digest.update(hashlib.sha256(file.read()).digest())
    return digest.hexdigest()


def read_record(folder):
    try:
        with open(os.path.join(folder, RECORD)) as file:
            return json.load(file)
    except (OSError, ValueError):
        return {}


def write_record(folder, record):
    path = os.path.join(folder, RECORD)
    with open(path + ".part", "w") as file:
        json.dump(record, file, indent=1)
    os.replace(path + ".part", path)


def remove(path):
    if os.path.isdir(path):
        shutil.rmtree(path)
    elif os.path.exists(path):
        os.remove(path)


def replace_folder(fresh, folder):
    remove(folder)
    os.rename(fresh, folder)


def free(scene):
    """Takes the caches off the objects and removes what bakes have put into the folder."""
    folder = folder_of(scene)
    count = attach.detach_all(scene)
    if not os.path.exists(os.path.join(folder, RECORD)):
        return count
    for part in (*PARTS, RECORD + ".part", RECORD):
        remove(os.path.join(folder, part))
    if not os.listdir(folder):
        os.rmdir(folder)
    return count
