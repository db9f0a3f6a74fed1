"""What tools/bench measures of the Python module: prints [s] of its import, and [s] of a step of one hex.

usage: bench_python.py SCENE STEPS
"""
import sys
import time

import numpy  # what users have imported before

start = time.perf_counter()
import umax  # noqa: E402
imported = time.perf_counter() - start

simulation = umax.Simulation(sys.argv[1])
step = simulation.step
best = 1e9
for _ in range(10):
    state = simulation.state()
    start = time.perf_counter()
    for _ in range(int(sys.argv[2])):
        step()
    best = min(best, (time.perf_counter() - start) / int(sys.argv[2]))
    simulation.restore(state)
print(imported, best)
