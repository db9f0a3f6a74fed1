"""Scenes to test with, small enough for milliseconds."""
import math

BOX = {
    "clip": {"frames": 6},
    "body": {"box": {"shape": "box", "size": [0.3, 0.2, 0.2], "position": [0, 0.35, 0], "cage.cells": [3, 2, 2],
                     "material.young": "60 kPa", "limit.stretch": "10 %"}},
    "obstacle": {"ground": {"shape": "plane"}},
}

ONE_HEX = {
    "clip": {"gravity": [0, 0, 0], "frames": 3},
    "body": {"cube": {"shape": "box", "size": [1, 1, 1], "cage": {"cells": [1, 1, 1], "clip": "box"},
                      "material": {"density": "1 kg/m^3", "mass": "lattice"}}},
}

PAIR = {
    "clip": {"frames": 3},
    "body": {"left": {"shape": "box", "size": [0.2, 0.2, 0.2], "position": [-1, 1, 0], "cage.cells": [2, 2, 2]},
             "right": {"shape": "sphere", "radius": 0.1, "position": [1, 1, 0], "cage.cells": [2, 2, 2]}},
}


def is_close(a, b, tolerance=1e-9):
    return math.isclose(a, b, rel_tol=tolerance, abs_tol=tolerance)
