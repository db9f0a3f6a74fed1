"""The result of a bake: a Mesh Cache modifier on the object, before the first modifier that changes its vertices."""
import bpy

from . import point_cache, shapes
from .gather import CACHE_NAME


class AttachError(Exception):
    pass


def attach(thing, path, scene):
    """Puts the cache onto the object, in place of one of an earlier bake."""
    reader = point_cache.Reader(path)
    reader.close()
    if reader.num_vertices != len(thing.data.vertices):
        raise AttachError(f"{thing.name}: has {len(thing.data.vertices)} vertices now, and had {reader.num_vertices} when it "
                          "was baked: bake again")
    modifier = thing.modifiers.get(CACHE_NAME)
    if modifier is None or modifier.type != "MESH_CACHE":
        modifier = thing.modifiers.new(CACHE_NAME, "MESH_CACHE")
        move_modifier(thing, modifier.name, shapes.first_rebuilding(thing))
        modifier = thing.modifiers[CACHE_NAME]
    modifier.cache_format = "PC2"
    modifier.filepath = relative(path)
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
    modifier.interpolation = "LINEAR"
    modifier.deform_mode = "OVERWRITE"
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    modifier.frame_start = scene.frame_start
    modifier.frame_scale = 1
    modifier.factor = 1
    modifier.show_viewport = modifier.show_render = True
    thing.umax.is_baked = True
    thing.data.update_tag()


def relative(path):
    """beside the .blend file where that is saved, so that both can move"""
    if not bpy.data.filepath:
        return path
    try:
        return bpy.path.relpath(path)
    except ValueError:  # another drive
        return path


def move_modifier(thing, name, index):
    start = thing.modifiers.find(name)
    index = min(index, len(thing.modifiers) - 1)
    if hasattr(thing.modifiers, "move"):
        thing.modifiers.move(start, index)
        return
    with bpy.context.temp_override(object=thing, active_object=thing):
        bpy.ops.object.modifier_move_to_index(modifier=name, index=index)


def detach_all(scene):
    """Returns how many there were."""
    count = 0
    for thing in scene.objects:
        if not thing.umax.is_baked:
            continue
        modifier = thing.modifiers.get(CACHE_NAME)
        if modifier is not None and modifier.type == "MESH_CACHE":
            thing.modifiers.remove(modifier)
        thing.umax.is_baked = False
        count += 1
    return count
