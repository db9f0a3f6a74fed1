#!/usr/bin/python3
"""three.js reads the USD that umax exports: axes, unit, times, every vertex of every frame, and, of what is large, the value
clips that hold it.

usage: usd_in_three.py PROGRAM NODE_FOLDER    NODE_FOLDER: whose node_modules has the reader
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import clients  # noqa: E402

LONG = """[clip]
frames = 260
fps = 50
[body.ball]
shape = "sphere"
radius = 0.15
position = [0, 0.4, 0]
cage.cells = [2, 2, 2]
[obstacle.ground]
shape = "plane"
"""


def points_of(numbers):
    return [tuple(numbers[i:i + 3]) for i in range(0, len(numbers), 3)]


def check_samples(name, surface, frames, numbers):
    """the samples of a layer at these frame numbers, against the cache's frames"""
    samples = surface("points")["timeSamples"]
    assert samples["times"] == numbers, (name, samples["times"])
    for attribute in ("velocities", "normals", "extent"):
        assert surface(attribute)["timeSamples"]["times"] == numbers
    for number, value, velocities, extent in zip(numbers, samples["values"], surface("velocities")["timeSamples"]["values"],
                                                 surface("extent")["timeSamples"]["values"]):
        found, wanted = points_of(value), frames[number - 1]
        assert clients.farthest(found, wanted) <= 1e-6 * clients.size_of(wanted), (name, number)
        assert len(velocities) == len(value)
        low, high = points_of(extent)
        assert all(abs(low[k] - min(p[k] for p in found)) < 1e-6 for k in range(3))
        assert all(abs(high[k] - max(p[k] for p in found)) < 1e-6 for k in range(3))


def check_short_clip(umax, folder, node_folder):
    export = umax.export("usd", "--scale", "100")
    umax.export("pc2", "--scale", "100")
    names = clients.MOVING + ["obstacle.ground", "scene"]
    told = clients.node(node_folder, "read_usda.mjs", [export / f"{name}.usda" for name in names], folder)
    for name in names:
        seen = told[str(export / f"{name}.usda")]
        root = seen["/"]
        assert root["upAxis"] == "Y" and abs(root["metersPerUnit"] - 0.01) < 1e-12
        assert root["timeCodesPerSecond"] == root["framesPerSecond"] == clients.FPS
        prim = "/" + name.split(".")[-1]
        assert root["defaultPrim"] == prim[1:]
        if name == "scene":
            check_stage(seen)
            continue

        def surface(attribute):
            return seen[f"{prim}/surface.{attribute}"]
        assert surface("subdivisionScheme")["default"] == "none" and surface("orientation")["default"] == "rightHanded"
        assert set(surface("faceVertexCounts")["default"]) == {3}
        if name == "cube":
            for part, faces in ("skin", [0, 1, 2, 3, 6, 7, 8, 9, 10, 11]), ("lid", [4, 5]):
                assert seen[f"{prim}/surface/{part}.material:binding"]["targetPaths"] == [f"{prim}/{part}"]
                assert seen[f"{prim}/surface/{part}.indices"]["default"] == faces
        else:
            assert seen[f"{prim}/surface.material:binding"]["targetPaths"] == [f"{prim}/material"]
        if name == "obstacle.ground":
            assert len(surface("points")["default"]) == 12
            continue
        check_samples(name, surface, clients.read_pc2(export / f"{name}.pc2")[2], list(range(1, clients.FRAMES + 1)))
        if name == "cube":
            assert len(surface("primvars:st:indices")["default"]) == 36
            assert points_of(surface("primvars:displayColor")["default"])[0] == (1, 0, 0)
            assert "cube.png" in str(seen[f"{prim}/skin/texture.inputs:file"]["default"])


def check_stage(seen):
    assert "@./cube.usda@" in str(seen["/scene/cube"]["references"])
    assert "@./obstacle.plate.usda@" in str(seen["/scene/obstacle_plate"]["references"])
    matrix = seen["/scene/camera.xformOp:transform"]["default"]
    place = re.findall(r"[-\d.e]+", str(matrix))[-4:]
    assert clients.farthest([[float(x) for x in place[:3]]], [(50, 100, 300)]) < 1e-4, place
    angle = seen["/scene/camera.verticalAperture"]["default"] / seen["/scene/camera.focalLength"]["default"] / 2
    assert abs(angle - 0.2679492) < 1e-6  # tan 15 degrees


def check_long_clip(umax, folder, node_folder):
    (folder / "long.toml").write_text(LONG)
    umax(["simulate", "long.toml", "-o", "long"])
    for form in ("usd", "pc2"):
        umax(["export", "long", "--format", form, "--bodies", "ball"])
    export = folder / "long/export"
    text = (export / "ball.usda").read_text()
    clips = re.findall(r"@\./ball\.clips/(\d+\.usda)@", text)
    active = [tuple(map(int, pair)) for pair in re.findall(r"\((\d+), (\d+)\)", re.search("active = (.*)", text)[1])]
    assert len(clips) >= 2 and [index for _, index in active] == list(range(len(clips)))
    assert "times = [(1, 1), (260, 260)]" in text and 'primPath = "/ball"' in text
    assert "points.timeSamples" not in text and "points =" not in text, "what is authored here would hide the clips"
    assert "point3f[] points" in (export / "ball.clips/manifest.usda").read_text()
    starts = [frame for frame, _ in active] + [260]
    frames = clients.read_pc2(export / "ball.pc2")[2]
    for index, clip in enumerate(clips):
        path = export / "ball.clips" / clip
        assert path.stat().st_size <= 200e6
        if 0 < index < len(clips) - 1:
            continue
        seen = clients.node(node_folder, "read_usda.mjs", [path], folder)[str(path)]
        # each holds the first frame of the next, so that nothing jumps where they meet
        check_samples(clip, lambda attribute: seen[f"/ball/surface.{attribute}"], frames,
                      list(range(starts[index], starts[index + 1] + 1)))


def test(umax, folder, node_folder):
    check_short_clip(umax, folder, node_folder)
    check_long_clip(umax, folder, node_folder)


if __name__ == "__main__":
    clients.main(test)
