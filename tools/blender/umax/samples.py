"""Animated objects, evaluated frame by frame: as a shape that moves rigidly, or as the positions of all its vertices.

A sampler is fed whenever the scene stands at one of its instants. What it takes goes to a file at once.
"""
import hashlib
import math
import os

import bpy
from mathutils import Matrix

from . import point_cache, shapes

MOST_SAMPLES = 8        # per frame, of what is fast
WATCHED_VERTICES = 500  # whose speed is looked at


class Instants:
    """When things are evaluated: `each` times a frame."""

    def __init__(self, scene, each):
        self.each = each
        self.first = scene.frame_start
        self.num_frames = scene.frame_end - scene.frame_start + 1
        self.count = (self.num_frames - 1) * each + 1
        self.fps = scene.render.fps / scene.render.fps_base

    def go_to(self, scene, index):
        frame, part = divmod(index, self.each)
        scene.frame_set(self.first + frame, subframe=part / self.each)

    def time(self, index):
        return index / self.each / self.fps


class Sampler:
    """Of a collider, of what a pin follows, of a body's own animation: writes its vertices in world coordinates, and finds
    out whether it moves rigidly. What has no vertices is its axes alone."""

    def __init__(self, thing, instants, path):
        self.name, self.instants, self.path = thing.name, instants, path
        self.matrices = []
        self.digest = None       # of the vertices in the object's own coordinates
        self.is_rigid = True
        self.fastest = 0.0       # [units] between two instants
        self.num_vertices = None  # of the object
        self.shape = self.selection = self.writer = self.mover = self.watched = None

    def take(self):
        thing = bpy.data.objects[self.name]
        matrix = shapes.matrix_of(thing)
        if not shapes.has_surface(thing):
            self._take_axes(matrix)
            return
        if self.shape is None:
            self._begin(shapes.evaluated_shape(thing))
            positions = self.shape.positions
        else:
            positions = shapes.evaluated_positions(thing)
            if len(positions) != 3 * self.num_vertices:
                raise shapes.ShapeError(
                    f"{self.name}: has {len(positions) // 3} vertices in frame {bpy.context.scene.frame_current}, and "
                    f"{self.num_vertices} in the first one; turn off the modifier that changes their number")
            positions = self.selection.positions(positions)
        digest = hashlib.sha256(positions).digest()
        self.is_rigid = self.is_rigid and digest == self.digest and is_rigid_motion(self.matrices[:1], matrix)
        self.digest = digest if self.digest is None else self.digest
        self.matrices.append(matrix)
        moved = self.mover(matrix, positions)
        self.writer.append(moved)
        self._watch(moved)

    def _take_axes(self, matrix):
        self.matrices.append(matrix.to_3x3().normalized().to_4x4())
        self.matrices[-1].translation = matrix.to_translation()
        if len(self.matrices) > 1:
            self.fastest = max(self.fastest, math.dist(self.matrices[-1].translation, self.matrices[-2].translation))

    def _begin(self, shape):
        self.num_vertices = shape.num_vertices
        self.selection = shapes.Selection(shape)
        if not self.selection.places:
            raise shapes.ShapeError(f"{self.name}: has no faces: nothing can touch it")
        shape = self.selection.shape(shape)
        self.shape = shape
        self.digest = hashlib.sha256(shape.positions).digest()
        self.mover = shapes.Mover(shape.num_vertices)
        self.writer = point_cache.Writer(self.path, shape.num_vertices, 1 / self.instants.fps / self.instants.each)

    def _watch(self, positions):
        stride = 3 * max(1, self.shape.num_vertices // WATCHED_VERTICES)
        points = list(zip(positions[0::stride], positions[1::stride], positions[2::stride]))
        if self.watched:
            self.fastest = max(self.fastest, max(math.dist(a, b) for a, b in zip(points, self.watched)))
        self.watched = points

    def moves(self):
        return not self.is_rigid or any(matrix != self.matrices[0] for matrix in self.matrices)

    def finish(self):
        """Keeps the file only where it is needed."""
        if not self.writer:
            return
        self.writer.finish()
        if self.is_rigid:
            os.remove(self.path)
        self.close()

    def close(self):
        if self.writer:
            self.writer.discard()
        if self.mover:
            self.mover.__exit__()
        self.writer = self.mover = None


def is_rigid_motion(first, matrix):
    """whether a matrix turns and moves what the first one of the list has scaled, and nothing else"""
    if not first:
        return True
    change = matrix.to_3x3() @ inverted(first[0].to_3x3())
    return max(abs(number) for row in (change @ change.transposed() - Matrix.Identity(3)) for number in row) < 1e-5


def inverted(matrix):
    try:
        return matrix.inverted()
    except ValueError:
        raise shapes.ShapeError("an object is scaled to nothing along an axis: give it a scale other than 0") from None


Y_UP = Matrix(((1, 0, 0), (0, 0, 1), (0, -1, 0)))  # from Blender's axes to those of umax


def rigid_tracks(matrices, instants, unit, rest):
    """place [m] and angles [deg] at each instant, as (time, value) pairs; rest: what counts as not turned"""
    start = inverted(rest)
    positions, rotations, before = [], [], None
    for index, matrix in enumerate(matrices):
        turn = Y_UP @ (matrix.to_3x3() @ start) @ Y_UP.transposed()
        angles = turn.to_euler("XYZ", before) if before else turn.to_euler("XYZ")
        before = angles
        positions.append([instants.time(index), [unit * number for number in Y_UP @ matrix.to_translation()]])
        rotations.append([instants.time(index), [math.degrees(angle) for angle in angles]])
    return positions, rotations


def rigid_keys(matrices, instants, unit, rest):
    """position and rotation as keys of a scene, constants where nothing moves; rest: what the mesh was turned and scaled by
    already"""
    positions, rotations = rigid_tracks(matrices, instants, unit, rest)
    return keyed(positions), keyed(rotations)


def follow_keys(sampler, unit):
    """how a pin goes along with what moves rigidly: by how much it is moved, and turned about the object's origin"""
    if not sampler.moves():
        return {}
    positions, rotations = rigid_tracks(sampler.matrices, sampler.instants, unit, sampler.matrices[0].to_3x3())
    start = positions[0][1]
    shifts = [[time, [now - then for now, then in zip(place, start)]] for time, place in positions]
    return {"follow.position": keyed(shifts), "follow.rotation": keyed(rotations), "follow.pivot": start}


def keyed(keys):
    """without the keys between equal ones"""
    kept = [key for i, key in enumerate(keys)
            if i in (0, len(keys) - 1) or not keys[i - 1][1] == key[1] == keys[i + 1][1]]
    if all(key[1] == kept[0][1] for key in kept):
        return kept[0][1]
    return {"keys": kept, "interpolation": "linear"}
