#!/usr/bin/python3
"""The glTF that umax exports has neither errors nor warnings for the official validator, and its morph targets, weighted as
its animation says, put every vertex of every frame where the cache has it.

usage: gltf_validated.py PROGRAM NODE_FOLDER    NODE_FOLDER: whose node_modules has the readers
"""
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import clients  # noqa: E402


def points_of(numbers):
    return [tuple(numbers[i:i + 3]) for i in range(0, len(numbers), 3)]


def posed(seen, frame):
    """the positions, by all targets and their weights"""
    count = len(seen["targets"])
    points = seen["positions"][:]
    for weight, target in zip(seen["weights"][frame * count:(frame + 1) * count], seen["targets"]):
        if weight != 0:
            points = [p + weight * d for p, d in zip(points, target)]
    return points_of(points)


def check_copies(seen, frames):
    """behind the surface's own vertices come copies of some, for texture coordinates: each where its original is"""
    own = len(frames[0])
    assert len(seen["positions"]) // 3 > own, "the cube's corners have several texture coordinates"
    places = [{p: v for v, p in enumerate(points_of(seen["positions"])[:own])}[p]
              for p in points_of(seen["positions"])[own:]]
    for frame in (5, clients.FRAMES - 1):
        shape = posed(seen, frame)
        for copy, original in enumerate(places):
            assert shape[own + copy] == shape[original]
    corners = {(seen["coordinates"][2 * i], 1 - seen["coordinates"][2 * i + 1]) for i in seen["indices"]}
    assert corners == {(0, 0), (1, 0), (1, 1), (0, 1)}, corners


def test(umax, folder, node_folder):
    export = umax.export("gltf")
    umax.export("pc2")
    names = clients.MOVING + ["obstacle.ground"]
    told = clients.node(node_folder, "read_gltf.mjs", [export / f"{name}.gltf" for name in names], folder)
    for name in names:
        seen = told[str(export / f"{name}.gltf")]
        assert seen["numErrors"] == 0 and seen["numWarnings"] == 0, (name, seen["messages"])
        assert seen["name"] == name.split(".")[-1]
        assert abs(seen["camera"]["yfov"] - math.radians(30)) < 1e-6
        assert clients.farthest([seen["camera"]["translation"]], [(0.5, 1, 3)]) < 1e-6
        if name == "obstacle.ground":
            assert not seen["targets"] and not seen["times"]
            continue
        frames = clients.read_pc2(export / f"{name}.pc2")[2]
        assert clients.farthest([[t] for t in seen["times"]], [[f / clients.FPS] for f in range(clients.FRAMES)]) < 1e-6
        size = clients.size_of(frames[0])
        for number, frame in enumerate(frames):
            error = clients.farthest(posed(seen, number)[:len(frame)], frame)
            assert error <= 1e-6 * size, (name, number, error / size)
        if name == "cube":
            check_copies(seen, frames)
            assert seen["texture"] == (export / "cube.png").stat().st_size == (folder / "skin.png").stat().st_size
            assert points_of(seen["colors"])[0] == (1, 0, 0)
            assert seen["materials"] == ["skin", "lid"]
        else:
            assert seen["coordinates"] is None and seen["colors"] is None
    assert clients.farthest([told[str(export / "ball.gltf")]["baseColor"][:3]], [(0.5271, 0.0296, 0.0144)]) < 1e-3


if __name__ == "__main__":
    clients.main(test)
