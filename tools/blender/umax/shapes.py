"""Meshes of Blender as plain arrays, in any frame; and as PLY files, which umax reads."""
from array import array

import bpy

from .point_cache import to_little_endian

# modifiers that leave number and order of vertices alone; the first other one ends what the simulation sees
DEFORMING = {
    "ARMATURE", "CAST", "CORRECTIVE_SMOOTH", "CURVE", "DATA_TRANSFER", "DISPLACE", "HOOK", "LAPLACIANDEFORM",
    "LAPLACIANSMOOTH", "LATTICE", "MESH_CACHE", "MESH_DEFORM", "MESH_SEQUENCE_CACHE", "NORMAL_EDIT", "SHRINKWRAP",
    "SIMPLE_DEFORM", "SMOOTH", "SURFACE_DEFORM", "UV_PROJECT", "UV_WARP", "VERTEX_WEIGHT_EDIT", "VERTEX_WEIGHT_MIX",
    "VERTEX_WEIGHT_PROXIMITY", "VOLUME_DISPLACE", "WARP", "WAVE", "WEIGHTED_NORMAL",
}


class ShapeError(Exception):
    pass


class Shape:
    """positions: 3 floats a vertex; triangles: 3 indices each"""

    def __init__(self, positions, triangles):
        self.positions, self.triangles = positions, triangles

    @property
    def num_vertices(self):
        return len(self.positions) // 3


class Selection:
    """The vertices of a shape that faces have: what touches can only be those."""

    def __init__(self, shape):
        used = sorted(set(shape.triangles))
        self.all = len(used) == shape.num_vertices
        self.places = used
        self.floats = None if self.all else [3 * vertex + axis for vertex in used for axis in range(3)]

    def positions(self, positions):
        return positions if self.all else array("f", [positions[place] for place in self.floats])

    def shape(self, shape):
        if self.all:
            return shape
        new = {vertex: index for index, vertex in enumerate(self.places)}
        return Shape(self.positions(shape.positions), array("i", [new[corner] for corner in shape.triangles]))


def has_surface(thing):
    return thing.type in {"MESH", "CURVE", "SURFACE", "FONT", "META"}


def numbers_of(collection, attribute, kind, each):
    numbers = array(kind, bytes(4 * each * len(collection)))
    collection.foreach_get(attribute, numbers)
    return numbers


def evaluated_shape(thing):
    """of an object in the current frame, with its modifiers, in its own coordinates"""
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        if mesh is None or len(mesh.vertices) == 0:
            raise ShapeError(f"{thing.name}: has no vertices")
        mesh.calc_loop_triangles()
        return Shape(numbers_of(mesh.vertices, "co", "f", 3), numbers_of(mesh.loop_triangles, "vertices", "i", 3))
    finally:
        evaluated.to_mesh_clear()


def evaluated_positions(thing):
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        return array("f") if mesh is None else numbers_of(mesh.vertices, "co", "f", 3)
    finally:
        evaluated.to_mesh_clear()


def matrix_of(thing):
    """from the object's coordinates to the world's, in the current frame"""
    return thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world.copy()


class Mover:
    """Applies matrices to arrays of points, at the speed of Blender's own meshes."""

    def __init__(self, num_vertices):
        self.mesh = bpy.data.meshes.new(".umax")
        self.mesh.vertices.add(num_vertices)

    def __call__(self, matrix, positions):
        self.mesh.vertices.foreach_set("co", positions)
        self.mesh.transform(matrix)
        return numbers_of(self.mesh.vertices, "co", "f", 3)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        bpy.data.meshes.remove(self.mesh)


def moved(shape, matrix):
    """the shape in other coordinates; its triangles still face outwards where the matrix mirrors"""
    with Mover(shape.num_vertices) as mover:
        positions = mover(matrix, shape.positions)
    triangles = shape.triangles[:]
    if matrix.determinant() < 0:
        triangles[1::3], triangles[2::3] = shape.triangles[2::3], shape.triangles[1::3]
    return Shape(positions, triangles)


def first_rebuilding(thing):
    """index of the first modifier that is on and changes the vertices' number: the cache stands before it"""
    for index, modifier in enumerate(thing.modifiers):
        if modifier.show_viewport and modifier.type not in DEFORMING:
            return index
    return len(thing.modifiers)


class OnlyDeforming:
    """While this lives, an object's modifiers are off from its first rebuilding one on, and so is a bake's cache."""

    def __init__(self, thing, cache_name):
        end = first_rebuilding(thing)
        self.name = thing.name
        self.off = [modifier.name for index, modifier in enumerate(thing.modifiers)
                    if modifier.show_viewport and (index >= end or modifier.name == cache_name)]

    def switch(self, is_on):
        thing = bpy.data.objects.get(self.name)
        for name in self.off if thing else []:
            if name in thing.modifiers:
                thing.modifiers[name].show_viewport = is_on

    def __enter__(self):
        self.switch(False)
        return self

    def __exit__(self, *_):
        self.switch(True)


def weights_of(thing, group_name):
    """of every vertex of the mesh its weight in a vertex group, 0 where it has none"""
    group = thing.vertex_groups.get(group_name)
    if group is None:
        raise ShapeError(f"{thing.name}: has no vertex group \"{group_name}\"; choose one, or leave the map out")
    weights = array("f", bytes(4 * len(thing.data.vertices)))
    for vertex in thing.data.vertices:
        for element in vertex.groups:
            if element.group == group.index:
                weights[vertex.index] = element.weight
    return weights


def srgb_from_linear(value):
    value = min(max(value, 0.0), 1.0)
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


def ply_bytes(shape, weights=None):
    """binary PLY; weights become grey paint, which umax reads as numbers from 0 (black) to 1 (white)"""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {shape.num_vertices}"]
    header += [f"property float {name}" for name in ("x", "y", "z")]
    vertices = shape.positions
    if weights is not None:
        header += [f"property float {name}" for name in ("red", "green", "blue")]
        grey = array("f", [srgb_from_linear(weight) for weight in weights])
        vertices = array("f", bytes(8 * len(shape.positions)))
        for axis in range(3):
            vertices[axis::6] = shape.positions[axis::3]
            vertices[3 + axis::6] = grey
    count = len(shape.triangles) // 3
    header += [f"element face {count}", "property list int int vertex_indices", "end_header", ""]
    faces = array("i", bytes(16 * count))
    faces[0::4] = array("i", [3]) * count
    for corner in range(3):
        faces[corner + 1::4] = shape.triangles[corner::3]
    return "\n".join(header).encode() + to_little_endian(vertices) + to_little_endian(faces)
