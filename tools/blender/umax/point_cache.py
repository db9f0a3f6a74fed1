"""PC2 point caches, little-endian: a header of 32 bytes, then float32 x, y, z of every vertex in every sample."""
import os
import struct
import sys
from array import array

HEADER = struct.Struct("<12siiffi")  # signature, version, vertices, start, sampling [s], samples
SIGNATURE = b"POINTCACHE2\0"


class CacheError(Exception):
    pass


def to_little_endian(numbers):
    """the bytes of an array of 4-byte numbers"""
    if sys.byteorder == "big":
        numbers = numbers[:]
        numbers.byteswap()
    return numbers.tobytes()


class Writer:
    """Writes samples as they come; the file has its name once it is whole. step: time from one sample to the next [s]"""

    def __init__(self, path, num_vertices, step):
        self.path, self.num_vertices, self.step = path, num_vertices, step
        self.count = 0
        self.part = path + ".part"
        self.file = open(self.part, "wb")
        self.file.write(bytes(HEADER.size))

    def append(self, positions):
        """positions: array of 3 floats a vertex"""
        if len(positions) != 3 * self.num_vertices:
            raise CacheError(f"{self.path}: {len(positions) // 3} vertices, not {self.num_vertices}")
        self.file.write(to_little_endian(positions))
        self.count += 1

    def finish(self):
        self.file.seek(0)
        self.file.write(HEADER.pack(SIGNATURE, 1, self.num_vertices, 0.0, self.step, self.count))
        self.file.close()
        os.replace(self.part, self.path)

    def discard(self):
        self.file.close()
        if os.path.exists(self.part):
            os.remove(self.part)


class Reader:
    """Reads samples one after the other."""

    def __init__(self, path):
        self.path = path
        self.file = open(path, "rb")
        header = self.file.read(HEADER.size)
        size = os.path.getsize(path)
        if len(header) < HEADER.size:
            raise CacheError(f"{path}: is no PC2 file")
        signature, version, self.num_vertices, self.start, self.step, self.count = HEADER.unpack(header)
        if signature != SIGNATURE or version != 1 or size != HEADER.size + 12 * self.num_vertices * self.count:
            raise CacheError(f"{path}: is damaged, or no PC2 file")

    def read(self):
        """the next sample"""
        positions = array("f")
        positions.fromfile(self.file, 3 * self.num_vertices)
        if sys.byteorder == "big":
            positions.byteswap()
        return positions

    def close(self):
        self.file.close()
