"""What the tests with foreign programs share: a clip that umax makes and exports, and caches read by nobody's code but this."""
import json
import struct
import subprocess
import sys
import zlib
from pathlib import Path

# a mesh whose corners have texture coordinates that no vertex order survives unless it is kept, paint, two materials,
# and two vertices of no triangle: one between its own, one behind them
CUBE = """mtllib cube.mtl
v -0.2 0 -0.2 1 0 0
v 0.2 0 -0.2 0 1 0
v 0.2 0 0.2 0 0 1
v -0.2 0 0.2 1 1 0
v 0.5 0.2 0 0.5 0.5 0.5
v -0.2 0.4 -0.2 0 1 1
v 0.2 0.4 -0.2 1 0 1
v 0.2 0.4 0.2 1 1 1
v -0.2 0.4 0.2 0.2 0.2 0.2
v 0.05 0.21 0.1 1 1 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl skin
f 1/1 2/2 3/3 4/4
f 9/4 8/3 7/2 6/1
usemtl lid
f 1/1 6/2 7/3 2/4
usemtl skin
f 2/1 7/2 8/3 3/4
f 3/1 8/2 9/3 4/4
f 4/1 9/2 6/3 1/4
"""
SCENE = """[clip]
frames = 24
fps = 30
substeps = 2
[body.cube]
mesh = "cube.obj"
position = [0, 0.34, 0]
rotation = [10, 0, 20]
cage.cells = [2, 2, 2]
material.young = "20 kPa"
limit.stretch = "10 %"
[body.ball]
shape = "sphere"
radius = 0.15
position = [0.6, 0.4, 0.1]
cage.cells = [2, 2, 2]
look.color = "#c03020"
[obstacle.plate]
shape = "box"
size = [0.3, 0.05, 0.3]
position = { keys = [[0, [0.6, 0.9, 0]], [0.8, [0.6, 0.7, 0]]] }
rotation = { keys = [[0, [0, 0, 0]], [0.8, [0, 90, 0]]] }
[obstacle.ground]
shape = "plane"
[camera]
position = [0.5, 1, 3]
target = [0.2, 0.3, 0]
vertical_fov = 30
[render]
size = [64, 36]
"""
FRAMES = 24
FPS = 30
LOOSE = (4, 9)  # vertices of the cube that no face has
MOVING = ["cube", "ball", "obstacle.plate"]


def png(width, height):
    """a picture of stripes"""
    return png_of(width, height, [(255, 64 * (x % 4), 32 * y % 256) for y in range(height) for x in range(width)])


def png_of(width, height, pixels):
    """of (r, g, b), 0 to 255, row by row"""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(c for p in pixels[y * width:(y + 1) * width] for c in p) for y in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Program:
    """umax, and the run in `folder` that it exports."""

    def __init__(self, path, folder):
        self.path = str(Path(path).resolve())
        self.folder = Path(folder)
        (self.folder / "cube.obj").write_text(CUBE)
        (self.folder / "cube.mtl").write_text("newmtl skin\nmap_Kd skin.png\nnewmtl lid\nKd 1 0 0\n")
        (self.folder / "skin.png").write_bytes(png(4, 4))
        (self.folder / "clip.toml").write_text(SCENE)
        self(["simulate", "clip.toml", "-o", "clip"])

    def __call__(self, words):
        subprocess.run([self.path, *words, "--quiet"], cwd=self.folder, check=True)

    def export(self, form, *words):
        self(["export", "clip", "--format", form, *words])
        return self.folder / "clip" / "export"


def read_pc2(path):
    """start, sampling, frames of (x, y, z)"""
    data = Path(path).read_bytes()
    signature, version, vertices, start, sampling, frames = struct.unpack_from("<12siiffi", data)
    assert signature == b"POINTCACHE2\0" and version == 1, path
    assert len(data) == 32 + 12 * vertices * frames, path
    return start, sampling, [list(struct.iter_unpack("<3f", data[32 + 12 * vertices * f:32 + 12 * vertices * (f + 1)]))
                             for f in range(frames)]


def read_mdd(path):
    """times, frames of (x, y, z)"""
    data = Path(path).read_bytes()
    frames, vertices = struct.unpack_from(">ii", data)
    times = struct.unpack_from(f">{frames}f", data, 8)
    start = 8 + 4 * frames
    assert len(data) == start + 12 * vertices * frames, path
    return times, [list(struct.iter_unpack(">3f", data[start + 12 * vertices * f:start + 12 * vertices * (f + 1)]))
                   for f in range(frames)]


def node(node_folder, script, files, folder):
    """what a script says of files, by their names"""
    answer = folder / "answer.json"
    copy = Path(node_folder) / script  # beside its node_modules
    if not copy.exists() or copy.read_text() != (Path(__file__).parent / script).read_text():
        copy.write_text((Path(__file__).parent / script).read_text())
    with open(answer, "w") as out:
        subprocess.run(["node", "--max-old-space-size=6000", str(copy), *map(str, files)], stdout=out, check=True)
    return json.loads(answer.read_text())


def farthest(a, b):
    """largest difference of a coordinate of two lists of points"""
    assert len(a) == len(b), f"{len(a)} points, not {len(b)}"
    return max(abs(p - q) for u, v in zip(a, b) for p, q in zip(u, v))


def size_of(points):
    return max(max(p[k] for p in points) - min(p[k] for p in points) for k in range(3))


def main(test):
    """Calls test(program, folder) with the words of the command line: PROGRAM [what the test needs more]"""
    import tempfile
    with tempfile.TemporaryDirectory() as folder:
        test(Program(sys.argv[1], folder), Path(folder), *sys.argv[2:])
    print("passed")
