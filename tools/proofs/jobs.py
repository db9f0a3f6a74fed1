"""Calls of umax that proofs are made with: what is called, what it leaves, and how that is compared with what it should be.

Used by tools/reliability.
"""
import random
import shutil
import subprocess

from left_files import digests, half_files
from live_kills import SET_UP, SIMULATION, WRITING

SCENE = """[clip]
frames = 24
substeps = 4
[body.block]
shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 0.34, 0]
rotation = [10, 0, 20]
cage.cells = [6, 6, 6]
material.young = "20 kPa"
limit.stretch = "10 %"
[obstacle.ground]
shape = "plane"
[render]
size = [160, 90]
samples = 3
"""
RENDERING, ENCODING, REPORTS = "rendering", "encoding", "reports"


class Job:
    """What is called, what it leaves, and which of that must not be made twice."""

    first_phase = SET_UP
    phases = [SET_UP, SIMULATION, RENDERING, ENCODING, REPORTS]
    units = ("*.state", "frames/*.png", "clip.mp4")  # that are made once

    def __init__(self, proof):
        self.proof = proof

    def prepare(self, folder):
        pass

    def words(self, folder):
        raise NotImplementedError

    def output(self, folder):
        return folder / "run"


class Run(Job):
    name = "run"

    def words(self, folder):
        return ["run", self.proof.scene, "-o", self.output(folder), "--resume"]


class Render(Job):
    name = "render"
    phases = [SET_UP, RENDERING, ENCODING]

    def prepare(self, folder):
        shutil.copytree(self.proof.simulated, self.output(folder))

    def words(self, folder):
        return ["render", self.output(folder), "--resume"]


class Encode(Job):
    name = "encode"
    first_phase = ENCODING
    phases = [ENCODING]
    units = ("*.state", "frames/*.png")

    def prepare(self, folder):
        shutil.copytree(self.proof.rendered, self.output(folder))

    def words(self, folder):
        return ["encode", self.output(folder)]


class Export(Job):
    name = "export"
    phases = [SET_UP, WRITING]
    units = ("*.state",)

    def prepare(self, folder):
        shutil.copytree(self.proof.simulated, self.output(folder))

    def words(self, folder):
        return ["export", self.output(folder), "--format", "abc", "--overwrite"]


class Tune(Job):
    name = "tune"
    units = ("runs/*/states/*.state", "runs/*/frames/*.png")

    def words(self, folder):
        return ["tune", self.proof.scene, "--vary", "body.block.limit.stretch=5%,10%", "-o", self.output(folder), "--resume"]


class Aim(Job):
    name = "aim"
    phases = [SET_UP, SIMULATION, REPORTS]
    units = ("runs/*/states/*.state",)

    def words(self, folder):
        return ["aim", self.proof.scene, "--want", "min height(block) = 70 %", "--vary", "body.block.limit.stretch=1%..40%",
                "-o", self.output(folder), "--resume"]


class Reproduce(Job):
    name = "reproduce"
    phases = [SET_UP, SIMULATION, RENDERING]
    units = ("runs/*/states/*.state", "tiles/*.png")

    def words(self, folder):
        return ["reproduce", "figure4", "--quick", "-o", self.output(folder), "--resume"]


JOBS = (Run, Render, Tune, Aim, Reproduce, Export, Encode)


class Proof:
    """What all proofs share: the program, a folder to work in, sound runs in it, and what was found to be lost."""

    def __init__(self, program, place, seed):
        self.program, self.place = program, place
        self.random = random.Random(seed)
        self.faults = []
        self.scene = place / "block.toml"
        self.scene.write_text(SCENE)
        self.simulated, self.rendered = place / "simulated", place / "rendered"
        for folder in (self.simulated, self.rendered):
            shutil.rmtree(folder, ignore_errors=True)
        self.call(["simulate", self.scene, "-o", self.simulated])
        shutil.copytree(self.simulated, self.rendered)
        self.call(["render", self.rendered, "--no-clip"])

    def call(self, words):
        subprocess.run([str(word) for word in [self.program] + words + ["--quiet"]], check=True)

    def fault(self, job, text):
        self.faults.append(f"{job.name}: {text}")
        print(f"LOST  {job.name}: {text}", flush=True)

    def folder_of(self, job, name):
        folder = self.place / f"{job.name}-{name}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        job.prepare(folder)
        return folder

    def compare(self, job, output, whole, volatile):
        result = digests(output)
        for name in sorted(set(whole) | set(result)):
            if name not in volatile and whole.get(name) != result.get(name):
                self.fault(job, f"{name} is not as in peace" if name in result else f"{name} is missing")
        for name in half_files(output):
            self.fault(job, f"{name} stayed")


def volatile_files(whole, again):
    """What two calls in peace do not make alike, by their digests."""
    return {name for name in whole if again.get(name) != whole[name]} | (set(again) - set(whole))
