#!/usr/bin/env python3
"""umax farm on a real scheduler: a process that is killed in the middle, a chunk that reaches past the clip, two variants, a
job that is cancelled and gone on with, one that goes back into the queue at its deadline. The result must be the bytes of one machine.

usage: farm_on_slurm.py PROGRAM"""
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True
from slurm_cluster import Cluster

SCENE = """[clip]
frames = 20
substeps = 8
[body.block]
shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 0.34, 0]
rotation = [10, 0, 20]
cage.cells = [9, 9, 9]
material.young = "20 kPa"
limit.stretch = "10 %"
[obstacle.ground]
shape = "plane"
[render]
size = [160, 90]
samples = 12
"""
FRAMES = 20
CHUNK = 8  # 20 frames: the third chunk reaches past the clip
VARY = ["--vary", "body.block.limit.stretch=5%,10%"]


class Farm:
    """A farm in a folder of its own, whose name has blanks and signs."""

    def __init__(self, program, cluster, folder, words=()):
        self.program, self.cluster, self.folder = program, cluster, folder
        self.words = ["farm", "block.toml", "-o", folder.name, "--frames-per-job", str(CHUNK), "--threads", "1", "--set",
                      "clip.frames=20", *words]

    def __call__(self, *words):
        result = subprocess.run([self.program, *words], cwd=self.folder.parent, env=self.cluster.environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        return result.returncode, result.stdout, result.stderr

    def done(self, *words):
        code, output, errors = self(*words)
        assert code == 0, f"{words}: exit code {code}\n{output}{errors}"
        return output

    def submit(self, *words):
        return self.done(*self.words, *words)

    def status(self):
        return json.loads(self.done("farm", "status", self.folder.name, "--json"))

    def wait_until_whole(self, seconds=240):
        end = time.monotonic() + seconds
        while (status := self.status())["tasks"]:
            assert time.monotonic() < end, f"{status}\n{self.cluster.report()}"
            time.sleep(0.3)
        logs = "".join(f"--- {log.name}\n{log.read_text()}" for log in sorted((self.folder / "farm/logs").iterdir()))
        assert status["whole"], f"{status}\n{logs}{self.cluster.report()}"
        return status

    def kill_one(self, verb):
        """kills a call of umax in the middle, once a first frame of it is there"""
        what = "*.state" if verb == "simulate" else "frames/*.png"
        self.cluster.wait_for(lambda: any(self.folder.rglob(what)), 120, f"frame of umax {verb}")
        for process in Path("/proc").glob("[0-9]*"):
            try:
                words = (process / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if words[:2] == [self.program.encode(), verb.encode()] and any(str(self.folder).encode() in w for w in words):
                os.kill(int(process.name), signal.SIGKILL)
                return
        raise AssertionError(f"no call of umax {verb} to kill")


def without_time(steps):
    """steps.csv without its column wall_ms"""
    return [row.split(",")[:17] + row.split(",")[18:] for row in steps.read_text().splitlines()]


def require_same_run(run, reference, frames=FRAMES):
    files = sorted(p.relative_to(reference) for p in reference.rglob("*") if p.is_file())
    same = [f for f in files if f.parts[0] in ("states", "frames", "scene.toml", "clip.mp4", "motion.json")]
    assert len(same) == 2 * frames + 3, same
    for file in same:
        assert (run / file).read_bytes() == (reference / file).read_bytes(), f"{run / file} has other bytes"
    assert without_time(run / "steps.csv") == without_time(reference / "steps.csv")


def reference_run(program, folder, name, *words):
    subprocess.run([program, "run", "block.toml", "-o", name, "--quiet", *words], cwd=folder, check=True)
    return folder / name


def is_killed_and_goes_on(program, cluster, folder):
    farm = Farm(program, cluster, folder / "one run, 50 %")
    farm.submit()
    code, _, errors = farm(*farm.words, "--resume")
    assert code == 75 and "in the queue" in errors, (code, errors)
    farm.kill_one("simulate")
    farm.kill_one("render")
    status = farm.wait_until_whole()
    assert status["lost"] == 2 and status["recovered"] == 2, status
    chunks = sorted(p.name for p in (farm.folder / "farm/calls").glob("render-*"))
    assert chunks == ["render-1-1", "render-1-2", "render-1-3"], chunks
    require_same_run(farm.folder, reference_run(program, folder, "one"))
    assert "all is there" in farm.done("farm", "status", farm.folder.name)
    return status


def variants_wait_for_their_own(program, cluster, folder):
    farm = Farm(program, cluster, folder / "variants", VARY)
    farm.submit()
    # a task that is taken away takes with it only what waits for the same variant; the same command goes on
    jobs = {job["name"]: job["id"] for job in json.loads((farm.folder / "farm/farm.json").read_text())["jobs"]}
    cluster.wait_for(lambda: any(farm.folder.rglob("runs/stretch=5%/states/*")), 120, "state")
    cluster.call("scancel", f"{jobs['simulate']}_1")
    end = time.monotonic() + 240
    while (status := farm.status())["tasks"]:
        assert time.monotonic() < end, f"{status}\n{cluster.report()}"
        time.sleep(0.3)
    assert [run["clip"] for run in status["runs"]] == [False, True], status
    assert "--resume" in farm.done("farm", "status", farm.folder.name)
    farm.submit("--resume")
    status = farm.wait_until_whole()
    for stretch in ("5%", "10%"):
        require_same_run(farm.folder / f"runs/stretch={stretch}",
                         reference_run(program, folder, f"alone {stretch}", "--set", f"body.block.limit.stretch={stretch}"))
    return status


def goes_back_at_its_deadline(program, cluster, folder):
    """A simulation that takes several times as long as a task may go on: each time it goes on where it was."""
    frames = 2 * FRAMES
    harder = ["--set", "body.block.cage.cells=[11, 11, 11]", "--set", "clip.substeps=8", "--set", f"clip.frames={frames}"]
    began = time.monotonic()
    reference = reference_run(program, folder, "in time", *harder)
    deadline = 3 + round(0.3 * (time.monotonic() - began))  # [s] whatever else the machine does
    farm = Farm(program, cluster, folder / "deadline", ["--deadline", f"{deadline}s", *harder])
    farm.submit()
    end = time.monotonic() + 400
    waited = set()
    while (status := farm.status())["tasks"]:
        assert time.monotonic() < end, f"{status}\n{cluster.report()}"
        time.sleep(3)
        queue = cluster.call("squeue", "--noheader", "--array", "--states=PENDING", "--format=%i %r").splitlines()
        # what goes back into Slurm's queue waits for two minutes
        waiting = {task for task, reason in (line.split(maxsplit=1) for line in queue) if reason == "BeginTime"}
        for task in waiting & waited:  # seen 3 s ago too: a node loses what starts in the second in which it ended
            cluster.call("scontrol", "update", f"JobId={task}", "StartTime=now")
        waited = waiting
    calls = [line.split()[-1] for line in (farm.folder / "farm/calls/simulate-1").read_text().splitlines()]
    assert status["whole"] and status["lost"] == 0, (status, calls, cluster.report())
    assert calls.count("75") >= 1 and calls[-1] == "0", calls
    require_same_run(farm.folder, reference, frames)
    return calls.count("75")


def is_cancelled(program, cluster, folder):
    farm = Farm(program, cluster, folder / "cancelled")
    farm.submit()
    cluster.wait_for(lambda: any(farm.folder.rglob("*.state")), 120, "state")
    assert re.match(r"[1-9]\d* tasks? taken out", farm.done("farm", "cancel", farm.folder.name))
    cluster.wait_for(lambda: not farm.status()["tasks"], 60, "empty queue")
    assert not farm.status()["whole"]


def a_refused_job_leaves_none(program, cluster, folder):
    farm = Farm(program, cluster, folder / "refused", ["--memory", "4000G"])  # more than any node has
    code, _, errors = farm(*farm.words)
    assert code == 69 and "is not taken by the queue" in errors, (code, errors)
    assert not cluster.call("squeue", "--noheader"), cluster.report()


def a_task_knows_its_time_and_goes_back_alone(cluster, folder):
    """The last task of an array, whose number is that of the whole array."""
    queue = Path(__file__).resolve().parents[2] / "tools/farm/slurm.sh"
    script = folder / "task.sh"
    script.write_text(f"#!/bin/bash\n#SBATCH --output={folder}/task-%a.log\n. '{queue}'\ntask_seconds_left\n"
                      f"until [ -e '{folder}/go' ]; do sleep 0.1; done\n"
                      "[ $SLURM_ARRAY_TASK_ID = 1 ] && sleep 100\nrequeue_task\n")
    array = cluster.call("sbatch", "--parsable", "--requeue", "--array=1-2", "--time=7", str(script)).strip()
    logs = [folder / f"task-{task}.log" for task in (1, 2)]
    cluster.wait_for(lambda: all(log.exists() and log.read_text() for log in logs), 60, "time that is left")
    for log in logs:
        assert 390 <= int(log.read_text()) <= 420, log.read_text()
    (folder / "go").touch()
    states = lambda: dict(line.split() for line in cluster.call("squeue", "--noheader", "--array", "--format=%K %T").splitlines())
    cluster.wait_for(lambda: states().get("2") == "PENDING", 60, "task in the queue again")
    assert states()["1"] == "RUNNING", states()
    cluster.call("scancel", array)
    cluster.wait_for(lambda: not states(), 60, "empty queue")


def main():
    program = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory(prefix="umax-farm-") as folder:
        folder = Path(folder)
        (folder / "block.toml").write_text(SCENE)
        with Cluster(folder / "slurm") as cluster:
            statuses = [is_killed_and_goes_on(program, cluster, folder),
                        variants_wait_for_their_own(program, cluster, folder)]
            times = goes_back_at_its_deadline(program, cluster, folder)
            is_cancelled(program, cluster, folder)
            a_refused_job_leaves_none(program, cluster, folder)
            a_task_knows_its_time_and_goes_back_alone(cluster, folder)
    print(f"passed: {sum(s['lost'] for s in statuses)} calls lost in jobs, "
          f"{sum(s['recovered'] for s in statuses)} recovered, {times} times back into the queue, the bytes those of one machine")


if __name__ == "__main__":
    main()
