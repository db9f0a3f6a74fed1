"""What must stay as it is however long umax runs: memory, time a frame, open files, and the invariants of the physics.

Used by tools/reliability long. A run of thousands of frames is watched from outside, frame by frame, in /proc; what runs of
tens of thousands of steps must keep is read from steps.csv and from the states.
"""
import csv
import json
import os
import pathlib
import struct
import subprocess

MOST_MEMORY_GROWTH = 1.02  # peak of the last quarter over that of the first
MOST_TIME_GROWTH = 1.1  # of the processor, in the last quarter over that in the first
MOST_LIMIT_RATIO = 1.001
MOST_ENERGY_RISE = 1e-4  # above the least so far, of the most that there was
MOST_MOMENTUM_DRIFT = 1e-8  # of the momentum at first
MOST_PENETRATION = 1e-3  # of a cell, as solver.tolerance has it

# shaken for ever, so that contacts and limits come and go
SHAKEN = """[clip]
frames = {frames}
[body.block]
shape = "box"
size = [0.4, 0.3, 0.4]
position = [0, 0.3, 0]
rotation = [10, 0, 20]
cage.cells = [3, 2, 3]
material.young = "20 kPa"
limit.stretch = "10 %"
[obstacle.ground]
shape = "plane"
friction = 0.5
position = {{ keys = [{keys}], interpolation = "smooth" }}
[render]
size = [48, 32]
samples = 1
"""

# a body alone: nothing may change its momentum, and its energy only falls
FLIGHT = """[clip]
frames = {frames}
substeps = 100
fps = 60
gravity = [0, 0, 0]
[solver]
tolerance = 1e-8
[body.block]
shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 1, 0]
velocity = [0.01, 0.02, -0.015]
spin = [200, -90, 300]
cage.cells = [2, 2, 2]
cage.clip = "box"
material.mass = "lattice"
material.young = "20 kPa"
limit.stretch = "4 %"
"""

# a ball that falls, lands, and rolls to and fro on the hexes that give way
ROLLING = """[clip]
frames = {frames}
substeps = 100
fps = 60
[body.ball]
shape = "sphere"
radius = 0.3
position = [0, 0.6, 0]
cage.cells = [3, 3, 3]
cage.clip = "box"
material.young = "20 kPa"
limit.stretch = "5 %"
[obstacle.ground]
shape = "plane"
friction = 0.5
"""


class Watched:
    """A call of the program, with what it has of the machine at each of its frames."""

    def __init__(self, words):
        self.stages = {}  # stage -> list of (seconds of the processor, memory [kB], open files)
        process = subprocess.Popen([str(word) for word in words + ["--progress", "json"]], stdout=subprocess.PIPE, text=True)
        for line in process.stdout:
            event = json.loads(line)
            if event["event"] == "frame":
                self.stages.setdefault(event["stage"], []).append(self.look_at(process.pid))
        self.code = process.wait()

    @staticmethod
    def look_at(number):
        try:
            status = pathlib.Path(f"/proc/{number}/status").read_text()
            memory = int(status.split("VmRSS:")[1].split()[0])
            times = pathlib.Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()
            seconds = (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")
            return seconds, memory, len(os.listdir(f"/proc/{number}/fd"))
        except (OSError, IndexError):  # it has just ended
            return 0, 0, 0


def quarters(values):
    quarter = max(1, len(values) // 4)
    return values[:quarter], values[-quarter:]


def steps_of(folder):
    with open(folder / "steps.csv", newline="") as file:
        return list(csv.DictReader(file))


def energy(row):
    return sum(float(row[name]) for name in ("kinetic_energy_J", "elastic_energy_J", "potential_energy_J"))


def momentum(path):
    """Of a lattice of 2 x 2 x 2 cubes of one mass, in that of a cube's eighth: nodes count by the cubes that have them."""
    data = path.read_bytes()
    at = 8 + 4 + 4 + 64 + 8 + 8 + 8  # magic, version, nothing, digest, time, step, been feasible
    (count,) = struct.unpack_from("<Q", data, at)
    at += 8 + 24 * count
    (again,) = struct.unpack_from("<Q", data, at)
    if count != 27 or again != 27:
        raise SystemExit(f"{path} is no state of 27 nodes: {count}, {again}")
    velocities = struct.unpack_from(f"<{3 * count}d", data, at + 8)
    shares = [x * y * z for x in (1, 2, 1) for y in (1, 2, 1) for z in (1, 2, 1)]
    return [sum(share * velocities[3 * node + axis] for node, share in enumerate(shares)) for axis in range(3)]


def length(vector):
    return sum(x * x for x in vector) ** 0.5


class LongRuns:
    """Makes them below a folder, prints a line a finding, and counts what does not hold."""

    def __init__(self, program, place, frames, steps):
        self.program, self.place, self.frames, self.steps, self.faults = program, place, frames, steps, 0

    def tell(self, what, value, bound):
        holds = value <= bound
        self.faults += not holds
        print(f"{'holds' if holds else 'FAILS'}  {what}: {value:.6g} (at most {bound:g})", flush=True)

    def simulate(self, name, text):
        scene, folder = self.place / f"{name}.toml", self.place / name
        scene.write_text(text.format(frames=self.steps // 100 + 1))
        subprocess.run([str(word) for word in (self.program, "simulate", scene, "-o", folder, "--quiet", "--overwrite")], check=True)
        return folder

    def frame_after_frame(self):
        scene = self.place / "shaken.toml"
        keys = ", ".join(f"[{0.5 * i}, [0, {0.1 * (i % 2)}, 0]]" for i in range(self.frames // 30 + 2))
        scene.write_text(SHAKEN.format(frames=self.frames, keys=keys))
        watched = Watched([self.program, "run", scene, "-o", self.place / "shaken", "--overwrite"])
        self.tell("exit code of the run", watched.code, 0)
        for stage, samples in watched.stages.items():
            first, last = quarters(samples[:-1])  # after the last frame the process may be gone
            seconds = [part[-1][0] - part[0][0] for part in (first, last)]
            print(f"-- {stage}: {len(samples)} frames")
            self.tell("memory, peak of the last quarter over that of the first",
                      max(s[1] for s in last) / max(s[1] for s in first), MOST_MEMORY_GROWTH)
            # the fewest: one more is open at times, which is being written
            self.tell("open files, fewest in the last quarter less fewest in the first",
                      min(s[2] for s in last) - min(s[2] for s in first), 0)
            self.tell("time a frame in the last quarter over that in the first", seconds[1] / seconds[0], MOST_TIME_GROWTH)
        rows = steps_of(self.place / "shaken")
        self.tell("steps that did not converge", sum(row["status"] != "converged" for row in rows), 0)
        self.tell("energy of a hex over its limit", max(float(row["max_energy_ratio"]) for row in rows), MOST_LIMIT_RATIO)

    def flight(self):
        folder = self.simulate("flight", FLIGHT)
        rows = steps_of(folder)
        print(f"-- flight: {len(rows)} steps")
        self.tell("steps that did not converge", sum(row["status"] != "converged" for row in rows), 0)
        states = sorted((folder / "states").glob("*.state"))
        first = momentum(states[0])
        drift = max(length([a - b for a, b in zip(momentum(path), first)]) for path in states)
        self.tell("drift of the momentum, of what there was", drift / length(first), MOST_MOMENTUM_DRIFT)
        self.tell_energy(rows)

    def rolling(self):
        rows = steps_of(self.simulate("rolling", ROLLING))
        print(f"-- rolling: {len(rows)} steps")
        self.tell("steps that did not converge", sum(row["status"] != "converged" for row in rows), 0)
        self.tell_energy(rows)
        cell = 0.2  # [m]
        self.tell("penetration, of a cell", max(float(row["max_penetration_m"]) for row in rows) / cell, MOST_PENETRATION)

    def tell_energy(self, rows):
        energies = [energy(row) for row in rows]
        least, rise = energies[0], 0
        for now in energies:
            rise, least = max(rise, now - least), min(least, now)
        self.tell("energy above the least so far, of the most there was", rise / max(energies), MOST_ENERGY_RISE)
        self.tell("energy of a hex over its limit", max(float(row["max_energy_ratio"]) for row in rows), MOST_LIMIT_RATIO)

    def run(self):
        self.flight()
        self.rolling()
        self.frame_after_frame()
        return self.faults
