"""Soft bodies that stop deforming exactly where you say.

    import umax

    scene = umax.Scene("figure")                        # a built-in, a .toml, TOML text or a dict
    scene["body.figure.limit.stretch"] = "15 %"
    simulation = umax.Simulation(scene)                 # in memory
    report = simulation.step()
    positions = simulation.positions("figure")          # numpy, (nodes, 3) [m]

    run = umax.simulate(scene, "falling")               # into a folder, as the program does
    for frame in run:
        surface = frame.surface("figure")

Units are SI: metres, kilograms, seconds, newtons, pascals, joules; angles in degrees. Y is up.
What you can mend raises umax.Error, with where, what, value and remedy.
"""

from ._processor import flags as _needed


def _require_processor():
    """Built for some processors, the module would end Python by SIGILL on older ones."""
    try:
        with open("/proc/cpuinfo") as lines:
            found = next((line.split() for line in lines if line.startswith("flags")), [])
    except OSError:  # no telling
        return
    missing = [flag for flag in _needed if found and flag not in found]
    if missing:
        raise ImportError(f"this processor has no {', '.join(missing)}, which this build of umax needs (x86-64-v3); "
                          "run it on one from 2013 or later, or build it with -DUMAX_ARCH=x86-64")


if _needed:
    _require_processor()

from ._umax import (Difference, Error, Fit, Frame, Progress, Run, Scene, Simulation, StepReport,  # noqa: E402
                    __version__, compare, deform, fit, render, scenes, simulate)

__all__ = ["Difference", "Error", "Fit", "Frame", "Progress", "Run", "Scene", "Simulation", "StepReport", "compare",
           "deform", "fit", "render", "scenes", "simulate"]

for _thing in __all__:  # as users know them
    if isinstance(globals()[_thing], type):
        globals()[_thing].__module__ = "umax"
del _thing
