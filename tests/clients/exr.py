"""Reads OpenEXR files of float channels, uncompressed or ZIP, by nobody's code but this: attributes and channels."""
import array
import struct
import sys
import zlib


def attributes_of(data):
    """name: (type, bytes), and where the line offsets start"""
    assert data[:4] == b"\x76\x2f\x31\x01", "no OpenEXR file"
    found, at = {}, 8

    def word():
        nonlocal at
        end = data.index(0, at)
        text, at = data[at:end].decode(), end + 1
        return text

    while data[at]:
        name, kind = word(), word()
        size = struct.unpack_from("<i", data, at)[0]
        found[name] = (kind, data[at + 4:at + 4 + size])
        at += 4 + size
    return found, at + 1


def channel_names(data):
    """in the order in which they are stored"""
    names, at = [], 0
    while data[at]:
        end = data.index(0, at)
        names.append(data[at:end].decode())
        kind = struct.unpack_from("<i", data, end + 1)[0]
        assert kind == 2, f"{names[-1]} is not of 32-bit floats"
        at = end + 17
    return names


def unpacked(block, size):
    """what ZIP compression of OpenEXR means: differences of bytes, the low halves of which come first"""
    if len(block) == size:
        return block
    raw = bytearray(zlib.decompress(block))
    for i in range(1, len(raw)):
        raw[i] = (raw[i - 1] + raw[i] - 128) & 255
    half = (len(raw) + 1) // 2
    mixed = bytearray(len(raw))
    mixed[0::2], mixed[1::2] = raw[:half], raw[half:]
    return bytes(mixed)


class Exr:
    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        self.attributes, at = attributes_of(data)
        left, top, right, bottom = struct.unpack("<4i", self.attributes["dataWindow"][1])
        self.width, self.height = right - left + 1, bottom - top + 1
        compression = self.attributes["compression"][1][0]
        lines = {0: 1, 2: 1, 3: 16}[compression]
        names = channel_names(self.attributes["channels"][1])
        self.channels = {name: array.array("f", bytes(4 * self.width * self.height)) for name in names}
        for offset in struct.unpack_from(f"<{-(-self.height // lines)}Q", data, at):
            first, size = struct.unpack_from("<ii", data, offset)
            rows = min(lines, bottom + 1 - first)
            self._take(first - top, rows, unpacked(data[offset + 8:offset + 8 + size], 4 * rows * self.width * len(names)))

    def _take(self, first, rows, block):
        values = array.array("f", block)
        if sys.byteorder == "big":
            values.byteswap()
        at = 0
        for y in range(first, first + rows):
            for name in self.channels:
                self.channels[name][y * self.width:(y + 1) * self.width] = values[at:at + self.width]
                at += self.width

    def text(self, name):
        kind, data = self.attributes[name]
        assert kind == "string", kind
        return data.decode()

    def matrix(self, name):
        """rows of four; for row vectors, as OpenEXR has it"""
        kind, data = self.attributes[name]
        assert kind == "m44f", kind
        numbers = struct.unpack("<16f", data)
        return [numbers[4 * i:4 * i + 4] for i in range(4)]

    def layer(self, name, letters):
        """a list of tuples, one a pixel"""
        return list(zip(*(self.channels[f"{name}.{letter}" if name else letter] for letter in letters)))
