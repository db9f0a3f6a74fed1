"""Gives damaged files to umax, and counts what becomes of them: read, refused, or what must not be.

Used by tools/reliability. Sound files of each kind are made by umax itself, or written here, damaged at random in one of
seven ways, and given to the program as a user would: a mesh to inspect, a picture to a scene that it covers. The program
must read the file or refuse it in words: no signal, no error of its own, no more than a minute, no more than 2 GiB. What
broke that stays in the folder hostile of --keep.
"""
import base64
import os
import pathlib
import random
import re
import shutil
import struct
import subprocess
import threading

SECONDS, BYTES = 60, 2 << 30
NUMBERS = [b"-1", b"0", b"nan", b"inf", b"1e308", b"-1e-320", b"4294967295", b"99999999999999999999", b'""', b"[]"]

BLOCK = """[clip]
frames = 2
substeps = 1
[body.block]
shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 0.34, 0]
cage.cells = [2, 2, 2]
[render]
size = [16, 16]
samples = 1
"""
TEXTURED = """[clip]
frames = 1
substeps = 1
[body.block]
mesh = "square.obj"
position = [0, 1, 0]
cage.cells = 8
look.texture = "{name}"
[render]
size = [16, 16]
samples = 1
"""
CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
HEX = (0, 4, 6, 2, 1, 5, 7, 3)  # as Gmsh and VTK number a hex's nodes


def lines(rows):
    return "".join(" ".join(map(str, row)) + "\n" for row in rows).encode()


def triangles():
    return [face for a, b, c, d in FACES for face in ((a, b, c), (a, c, d))]


def off():
    return b"OFF\n8 12 0\n" + lines(CUBE) + lines((3, *face) for face in triangles())


def stl():
    data = bytes(80) + struct.pack("<I", 12)
    for face in triangles():
        data += struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in CUBE[corner]), 0)
    return data


def msh():
    return (b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n" + lines((i + 1, *place) for i, place in enumerate(CUBE)) +
            b"$EndNodes\n$Elements\n1\n" + lines([(1, 5, 0, *(i + 1 for i in HEX))]) + b"$EndElements\n")


def vtk():
    return (b"# vtk DataFile Version 2.0\na hex\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n" + lines(CUBE) +
            b"CELLS 1 9\n" + lines([(8, *HEX)]) + b"CELL_TYPES 1\n12\n")


def hdr():
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([90, 80, 70, 129]) * 32


def square():
    return lines([("v", *place) for place in CUBE] + [("vt", x, y) for x in (0, 1) for y in (0, 1)] +
                 [("f", *(f"{corner + 1}/{i + 1}" for i, corner in enumerate(face))) for face in FACES])


def damaged(data, chance):
    """One of seven ways."""
    way, at = chance.randrange(7), chance.randrange(len(data))
    size = min(len(data) - at, chance.choice([1, 4, 16, 64, 256]))
    if way == 0:
        return data[:at]
    if way == 1:
        return data[:at] + bytes(chance.randrange(256) for _ in range(size)) + data[at + size:]
    if way == 2:
        return data[:at] + bytes([data[at] ^ (1 << chance.randrange(8))]) + data[at + 1:]
    if way == 3:
        return data[:at] + chance.choice([b"\0", b"\xff"]) * size + data[at + size:]
    if way == 4:
        return data[:at] + data[at + size:]
    if way == 5:
        return data[:at] + data[at:at + size] * chance.choice([2, 3, 50]) + data[at + size:]
    numbers = list(re.finditer(rb"-?\d+(\.\d+)?", data))
    if not numbers:
        return data[:at]
    number = chance.choice(numbers)
    return data[:number.start()] + chance.choice(NUMBERS) + data[number.end():]


class HostileFiles:
    """Makes sound files in a folder, and gives damaged ones to the program."""

    name = "hostile"

    def __init__(self, proof, files):
        self.proof, self.files = proof, files
        self.sound, self.folder, self.found = (proof.place / name for name in ("sound", "damaged", "hostile"))
        for folder in (self.sound, self.folder):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
        self.make_sound_files()

    def make_sound_files(self):
        for name, data in (("a.off", off()), ("a.stl", stl()), ("a.msh", msh()), ("a.vtk", vtk()), ("a.hdr", hdr()),
                           ("square.obj", square()), ("a.toml", BLOCK.encode()),
                           ("a.csv", b"strain [%],stress [kPa]\n0,0\n10,50\n20,110\n30,180\n40,260\n")):
            (self.sound / name).write_bytes(data)
        run = self.sound / "run"
        self.proof.call(["run", self.sound / "a.toml", "-o", run, "--no-clip", "--set", "render.layers=all"])
        for kind in ("ply", "obj", "gltf", "pc2", "mdd", "vtu"):
            self.proof.call(["export", run, "--format", kind])
        for target, source in (("a.png", "frames/0001.png"), ("a.exr", "frames/0001.exr"), ("a.state", "states/0002.state"),
                               ("a.ply", "export/block/0001.ply"), ("a.obj", "export/block/0001.obj"),
                               ("a.gltf", "export/block.gltf"), ("a.vtu", "export/block/0001.vtu"),
                               ("a.pc2", "export/block.pc2"), ("a.mdd", "export/block.mdd"), ("rest.obj", "export/block.obj")):
            shutil.copy(run / source, self.sound / target)
        buffer = base64.b64encode((run / "export/block.bin").read_bytes()).decode()
        gltf = self.sound / "a.gltf"  # in one file
        gltf.write_text(gltf.read_text().replace("block.bin", "data:application/octet-stream;base64," + buffer))
        subprocess.run(["ffmpeg", "-nostdin", "-loglevel", "error", "-y", "-i", self.sound / "a.png", self.sound / "a.jpg"], check=True)

    def words_for(self, path):
        """What is called to have the file read; writes what goes with it."""
        kind, scene, out = path.suffix[1:], self.folder / "scene.toml", self.folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        if kind in ("png", "jpg"):
            shutil.copy(self.sound / "square.obj", self.folder)
            scene.write_text(TEXTURED.format(name=path.name))
        elif kind in ("exr", "hdr"):
            scene.write_text(BLOCK.replace("frames = 2", "frames = 1") + f'sky.kind = "map"\nsky.map = "{path.name}"\n')
        elif kind in ("pc2", "mdd"):
            shutil.copy(self.sound / "rest.obj", self.folder)
            apart = BLOCK.replace("[0, 0.34, 0]", "[9, 0.34, 0]")  # what is read, not what it does to a body
            scene.write_text(apart + f'[obstacle.walker]\nshape = "mesh"\nmesh = "rest.obj"\ncache = "{path.name}"\n')
            return ["simulate", scene, "-o", out]
        elif kind == "state":
            shutil.copytree(self.sound / "run", out)
            shutil.copy(path, out / "states/0002.state")
            return ["render", out, "--overwrite", "--no-clip"]
        elif kind == "csv":
            return ["fit", path, "-o", out]
        else:
            return ["inspect", path]
        return ["run", scene, "-o", out, "--no-clip"]

    def give(self, path):
        """Exit code and what was said; none when it took too long. Memory [bytes] that it had at most."""
        words = [str(word) for word in [self.proof.program] + self.words_for(path)]
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, cwd=self.folder)
        late = threading.Timer(SECONDS, process.kill)
        late.start()
        said = process.stderr.read().decode(errors="replace")
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        in_time = late.is_alive()
        late.cancel()
        return process.returncode if in_time else None, said, usage.ru_maxrss * 1024

    def problem(self, code, said, memory):
        if code is None:
            return f"takes more than {SECONDS} s"
        if code < 0 or code >= 128:
            return f"ends it with signal {abs(code) % 128}"
        if code == 70 or "internal" in said:
            return f"is an error of its own (exit code {code})"
        if memory > BYTES:
            return f"takes {memory / (1 << 30):.1f} GiB"
        if code != 0 and "umax: error: " not in said:
            return f"is refused with {code} without a word"
        return None

    def give_kind(self, sound):
        counts, data = {"read": 0, "refused": 0}, sound.read_bytes()
        for number in range(self.files):
            path = self.folder / f"damaged{sound.suffix}"
            path.write_bytes(damaged(data, random.Random(f"{sound.suffix} {number}")))
            code, said, memory = self.give(path)
            problem = self.problem(code, said, memory)
            if problem:
                self.found.mkdir(exist_ok=True)
                shutil.copy(path, self.found / f"{number}{sound.suffix}")
                self.proof.fault(self, f"{number}{sound.suffix} {problem}: {said.strip()[-300:]}")
            else:
                counts["read" if code == 0 else "refused"] += 1
        print(f"{sound.suffix[1:]:<6} {counts['read']:4} read, {counts['refused']:4} refused", flush=True)
        return counts

    def give_all(self):
        kinds = sorted(path for path in self.sound.glob("a.*"))
        for sound in kinds:
            code, said, _ = self.give(pathlib.Path(shutil.copy(sound, self.folder)))
            if code != 0:
                raise SystemExit(f"{sound} is not read though it is sound: {said}")
        counts = [self.give_kind(sound) for sound in kinds]
        return (f"{len(kinds) * self.files} hostile files of {len(kinds)} kinds, {sum(c['read'] for c in counts)} read, "
                f"{sum(c['refused'] for c in counts)} refused in words")
