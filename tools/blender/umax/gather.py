"""From a scene of Blender to the input of umax: meshes, maps, colliders as they move, and the scene file."""
import os

import bpy
from mathutils import Matrix

from . import samples, scene_text, shapes

CACHE_NAME = "umax"  # of the modifier


class GatherError(Exception):
    pass


class Input:
    """What a simulation is made of. Coordinates are the world's, in units of the scene."""

    def __init__(self, scene, folder):
        self.scene, self.folder = scene, folder
        self.unit = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
        self.bodies = [thing for thing in scene.objects if thing.umax.role == "BODY"]
        self.colliders = [thing for thing in scene.objects if thing.umax.role == "COLLIDER"]
        pins = [(thing, pin) for thing in self.bodies for pin in thing.umax.pins]
        self.followed = list(dict.fromkeys(pin.target or thing for thing, pin in pins))
        # of all: their files are in one folder
        self.names = scene_text.plain_names(
            list(dict.fromkeys(thing.name for thing in self.bodies + self.colliders + self.followed)))
        self.matrices = {thing.name: [] for thing in self.bodies}  # of every frame
        self.files = []                                            # that were written
        self.text = ""

    def path(self, name):
        path = os.path.join(self.folder, name)
        self.files.append(name)
        return path

    def keep(self, sampler):
        """the name of a sampler's file"""
        name = os.path.basename(sampler.path)
        if name not in self.files:
            self.files.append(name)
        return name

    def write(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)
        return name


def require_sensible(scene):
    found = Input(scene, "")
    if not found.bodies:
        raise GatherError("no object takes part as a soft body: choose one in Properties > Physics > umax")
    for thing in found.bodies:
        if thing.type != "MESH":
            raise GatherError(f"{thing.name}: is no mesh: only meshes can be soft bodies")
        if len(thing.data.polygons) == 0:
            raise GatherError(f"{thing.name}: has no faces: a soft body needs a surface")
    for thing in dict.fromkeys(found.bodies + found.colliders + found.followed):
        if thing.mode in {"EDIT", "SCULPT"}:
            raise GatherError(f"{thing.name}: is being edited: go back to Object Mode first")
        if not thing.visible_get():
            raise GatherError(f"{thing.name}: is hidden in the viewport, where Blender does not evaluate it: show it, or let "
                              "it take part as nothing")
    if scene.frame_end <= scene.frame_start:
        raise GatherError(f"the scene has one frame: it begins at {scene.frame_start} and ends at {scene.frame_end}")


def gather(scene, folder):
    """A generator of (done, total); its value is an Input. Goes through the scene's frames; whoever calls puts the current
    frame back."""
    require_sensible(scene)
    found = Input(scene, folder)
    hidden = [shapes.OnlyDeforming(thing, CACHE_NAME) for thing in found.bodies]
    for each in hidden:
        each.switch(False)
    try:
        tables = clip_tables(found)
        scene.frame_set(scene.frame_start)
        surfaces = {thing: body_shape(found, thing) for thing in found.bodies}
        tables += [body_table(found, thing, shape) for thing, shape in surfaces.items()]
        taken = yield from sample_all(found)
        for thing, shape in surfaces.items():
            tables += [pin_table(found, thing, shape, index, taken) for index in range(len(thing.umax.pins))]
        tables += [collider_table(found, thing, taken[thing]) for thing in found.colliders]
    finally:
        for each in hidden:
            each.switch(True)
    found.text = scene_text.scene_text(tables)
    found.write("scene.toml", found.text.encode())
    return found


def clip_tables(found):
    scene = found.scene
    gravity = numbers(samples.Y_UP @ scene.gravity) if scene.use_gravity else [0.0, 0.0, 0.0]
    return [("clip", {
        "frames": scene.frame_end - scene.frame_start + 1,
        "fps": scene.render.fps / scene.render.fps_base,
        "substeps": scene.umax.substeps,
        "gravity": gravity,
        "allow_overlap": scene.umax.overlap or None,
    })]


def number(value):
    """a setting, which Blender holds in single precision, in the digits that the user sees"""
    return float(f"{value:.7g}")


def numbers(values):
    return [number(value) for value in values]


def body_shape(found, thing):
    """in the world's coordinates, at the first frame"""
    shape = shapes.evaluated_shape(thing)
    if shape.num_vertices != len(thing.data.vertices):
        raise GatherError(f"{thing.name}: its modifiers change the number of vertices, from {len(thing.data.vertices)} to "
                          f"{shape.num_vertices}, in front of where the cache goes: move them behind, or apply them")
    return shapes.moved(shape, shapes.matrix_of(thing))


def body_table(found, thing, shape):
    settings, name = thing.umax, found.names[thing.name]
    return f"body.{name}", {
        "mesh": found.write(f"{name}.ply", shapes.ply_bytes(shape)),
        "unit": number(found.unit),
        "up": "z",
        "friction": number(settings.friction),
        "contact": settings.touches,
        "velocity": numbers(samples.Y_UP @ settings.velocity) if any(settings.velocity) else None,
        "spin": numbers(samples.Y_UP @ settings.spin) if any(settings.spin) else None,
        "cage.cells": settings.cells,
        "material.young": number(1000 * settings.stiffness),
        "material.poisson": number(settings.poisson),
        "material.density": number(settings.density),
        "material.damping_stiffness": number(settings.damping / 1000) or None,
        "material.damping_mass": number(settings.drag) or None,
        "limit.stretch": number(settings.stretch / 100) if settings.limit != "none" else None,
        "limit.kind": settings.limit,
        **map_keys(found, thing, shape, "limit.map", settings.limit_group, settings.limit_range),
        **map_keys(found, thing, shape, "material.young_map", settings.stiffness_group, settings.stiffness_range),
    }


def map_keys(found, thing, shape, key, group, factors):
    if not group:
        return {}
    name = f"{found.names[thing.name]}.{key.split('.')[1]}.ply"
    found.write(name, shapes.ply_bytes(shape, shapes.weights_of(thing, group)))
    return {key: name, f"{key}_range": numbers(factors)}


def pin_table(found, thing, shape, index, taken):
    """What is in a vertex group follows what moves and turns, or the body's own animation; what is inside of an object
    follows that as it deforms."""
    pin, name = thing.umax.pins[index], found.names[thing.name]
    sampler = taken[pin.target or thing]
    if not pin.group and (pin.target is None or not shapes.has_surface(pin.target)):
        raise GatherError(f"{thing.name}: pin {index + 1} says neither which points it holds, by a vertex group, nor a mesh "
                          "that they are inside of: choose one of them")
    if pin.group and pin.target and not sampler.is_rigid:
        raise GatherError(f"{thing.name}: pin {index + 1} lets a vertex group follow {pin.target.name}, which deforms: leave "
                          "the vertex group out, so that what is inside of that object follows it")
    if pin.group:
        keys = {"map": found.write(f"{name}.pin{index + 1}.ply", shapes.ply_bytes(shape, shapes.weights_of(thing, pin.group)))}
    else:
        bones = shapes.moved(sampler.shape, sampler.matrices[0])
        keys = {"inside": found.write(f"{name}.pin{index + 1}.ply", shapes.ply_bytes(bones))}
    follows = samples.follow_keys(sampler, found.unit) if sampler.is_rigid else {"follow.cache": found.keep(sampler)}
    return f"body.{name}.pin.{index + 1}", {**keys, **follows, **hold_keys(found, thing, pin, index)}


def hold_keys(found, thing, pin, index):
    """when a pin holds, and how"""
    keys = {"stiffness": number(pin.spring)} if pin.is_spring else {}
    if not pin.is_timed:
        return keys
    if pin.last_frame < pin.first_frame:
        raise GatherError(f"{thing.name}: pin {index + 1} holds until frame {pin.last_frame}, before it begins at frame "
                          f"{pin.first_frame}: set a later one")
    fps, half = found.scene.render.fps / found.scene.render.fps_base, 0.5
    first, last = pin.first_frame - found.scene.frame_start, pin.last_frame - found.scene.frame_start
    return {**keys, "from": (first - half) / fps, "until": (last + half) / fps}


def cell_edge(found):
    """[units] about how long the edges of the smallest cells are"""
    edges = []
    for thing in found.bodies:
        x, y, z = (max(size, 1e-6) for size in thing.dimensions)
        edges.append((x * y * z / thing.umax.cells) ** (1 / 3))
    return min(edges)


def sample_all(found):
    """Goes through the frames once, and once more for what is too fast for one sample a frame. Samplers by object."""
    wanted = found.scene.umax.samples
    things = list(dict.fromkeys(found.colliders + found.followed))
    taken = yield from sample(found, things, wanted or 1, True)
    if wanted == 0:
        edge = cell_edge(found)
        by_count = {}
        for thing, sampler in list(taken.items()):
            each = min(samples.MOST_SAMPLES, int(sampler.fastest / edge) + 1)
            if each > 1:
                by_count.setdefault(each, []).append(thing)
        for each, things in by_count.items():
            taken.update((yield from sample(found, things, each, False)))
    return taken


def sample(found, things, each, with_bodies):
    """Samplers of things, by thing; of bodies, where they are in each frame."""
    instants = samples.Instants(found.scene, each)
    made = {thing: samples.Sampler(thing, instants, os.path.join(found.folder, found.names[thing.name] + ".pc2"))
            for thing in things}
    try:
        for index in range(instants.count):
            instants.go_to(found.scene, index)
            for sampler in made.values():
                sampler.take()
            for name, matrices in found.matrices.items() if with_bodies else ():
                matrices.append(shapes.matrix_of(bpy.data.objects[name]))
            yield index + 1, instants.count
        for sampler in made.values():
            sampler.finish()
    finally:
        for sampler in made.values():
            sampler.close()
    return made


def is_floor(thing, shape):
    if thing.umax.shape == "AUTO":
        heights = shape.positions[2::3]
        return max(heights) - min(heights) <= 1e-6 * max(map(abs, shape.positions), default=0)
    return thing.umax.shape == "PLANE"


def collider_table(found, thing, sampler):
    name = found.names[thing.name]
    keys = {"friction": number(thing.umax.friction)}
    first = sampler.matrices[0]
    if is_floor(thing, sampler.shape):
        # the plane is its object's own, of its first frame: what the mesh does is of no matter
        flat = [matrix.to_3x3().normalized().to_4x4() for matrix in sampler.matrices]
        for matrix, whole in zip(flat, sampler.matrices):
            matrix.translation = whole.to_translation()
        position, rotation = samples.rigid_keys(flat, sampler.instants, found.unit, Matrix.Identity(3))
        return f"obstacle.{name}", {"shape": "plane", **keys, "position": position, "rotation": rotation}
    keys.update({"shape": "mesh", "mesh": f"{name}.ply", "unit": number(found.unit), "up": "z"})
    if not sampler.is_rigid:
        found.write(f"{name}.ply", shapes.ply_bytes(shapes.moved(sampler.shape, first)))
        return f"obstacle.{name}", {**keys, "cache": found.keep(sampler)}
    # its own origin is what it turns about
    turned = first.to_3x3().to_4x4()
    found.write(f"{name}.ply", shapes.ply_bytes(shapes.moved(sampler.shape, turned)))
    position, rotation = samples.rigid_keys(sampler.matrices, sampler.instants, found.unit, first.to_3x3())
    return f"obstacle.{name}", {**keys, "position": position, "rotation": rotation}
