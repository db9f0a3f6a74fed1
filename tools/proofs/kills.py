"""Kills umax anywhere, goes on, and compares what comes out with what an undisturbed call makes.

Used by tools/reliability. Each job is done in peace first. Then it is begun again and again, killed by SIGKILL in a phase that
is chosen in turn, at a random moment of it, up to six times, and gone on with to its end. The files must be those of the one
in peace, byte for byte; no file that was finished before a kill may be made anew; no half file may stay. The job live,
sessions that are steered and killed, is in live_kills.py.
"""
import json
import re
import signal
import subprocess
import threading
import time

from jobs import ENCODING, RENDERING, REPORTS, volatile_files
from left_files import digests, stamps
from live_kills import SAVING, SET_UP, SIMULATION, WRITING

MOST_KILLS_A_RUN = 6
PHASES = [SET_UP, SIMULATION, RENDERING, ENCODING, REPORTS, WRITING, SAVING]


class Call:
    """A process, and in which phase it is, by what it says."""

    def __init__(self, words, log, first_phase):
        self.words, self.log = words, log
        self.phase, self.phase_began = first_phase, time.monotonic()
        self.durations = {}
        self.changed = threading.Condition()
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.messages = ""
        self.readers = [threading.Thread(target=self.listen), threading.Thread(target=self.hear_messages)]
        for reader in self.readers:
            reader.start()

    def listen(self):
        for line in self.process.stdout:
            try:
                event = json.loads(line)
            except ValueError:
                continue
            self.log.append(event)
            phase = self.phase_after(event)
            if phase and phase != self.phase:
                self.enter(phase)
        self.enter("ended")

    def hear_messages(self):
        self.messages = self.process.stderr.read()

    def enter(self, phase):
        with self.changed:
            now = time.monotonic()
            self.durations[self.phase] = self.durations.get(self.phase, 0) + now - self.phase_began
            self.phase, self.phase_began = phase, now
            self.changed.notify_all()

    @staticmethod
    def phase_after(event):
        stage, detail = event.get("stage", ""), event.get("detail", "")
        if event["event"] == "frame" and stage == "tune":
            return SIMULATION if detail.endswith("simulate") else RENDERING
        if event["event"] == "begin" and stage == "aim":
            return SIMULATION
        if event["event"] == "begin" and stage != "tune":
            return SIMULATION if stage == "simulate" else WRITING if stage.startswith("export") else RENDERING
        if event["event"] == "end":
            return ENCODING if stage in ("render", "mosaic") else REPORTS
        if event["event"] == "note" and (event["text"].startswith("clip:") or event["text"].endswith(".mp4")):
            return REPORTS
        return None

    def wait_for_phase(self, phase):
        with self.changed:
            while self.phase not in (phase, "ended"):
                self.changed.wait(60)
        return self.phase == phase

    def kill(self):
        """The phase in which it was killed; none when it had ended before."""
        phase = self.phase
        self.process.send_signal(signal.SIGKILL)
        return phase if self.wait() == -signal.SIGKILL else None

    def wait(self):
        code = self.process.wait()
        for reader in self.readers:
            reader.join()
        return code


class Kills:
    """Kills jobs so often each."""

    def __init__(self, proof, kills):
        self.proof, self.kills, self.random = proof, kills, proof.random

    def start(self, job, folder, log):
        words = [str(word) for word in [self.proof.program] + job.words(folder) + ["--progress", "json"]]
        return Call(words, log, job.first_phase)

    def in_peace(self, job, name):
        folder = self.proof.folder_of(job, name)
        call = self.start(job, folder, [])
        if call.wait() != 0:
            raise SystemExit(f"{job.name} fails without a kill: {call.messages}")
        return digests(job.output(folder)), call.durations

    def finish(self, job, folder, log):
        """Goes on to the end; a folder that those who are dying hold for another moment is waited for."""
        for _ in range(100):
            call = self.start(job, folder, log)
            code = call.wait()
            if code != 75:
                break
            time.sleep(0.1)
        if code != 0:
            self.proof.fault(job, f"went on with exit code {code}: {call.messages.strip()}")
        return code == 0

    def kill_job(self, job):
        began = time.monotonic()
        whole, durations = self.in_peace(job, "whole")
        again, _ = self.in_peace(job, "again")
        volatile = volatile_files(whole, again)
        counts = {phase: 0 for phase in PHASES}
        runs = twice = 0
        while sum(counts.values()) < self.kills:
            runs += 1
            twice += self.kill_run(job, whole, volatile, durations, counts)
        return {"counts": counts, "runs": runs, "twice": twice, "volatile": sorted(volatile), "seconds": time.monotonic() - began}

    def kill_run(self, job, whole, volatile, durations, counts):
        """Begins a run, kills it several times, goes on to its end; counts what was made twice."""
        folder, log, twice, finished = self.proof.folder_of(job, "killed"), [], 0, {}
        output = job.output(folder)
        for _ in range(self.random.randint(2, MOST_KILLS_A_RUN)):
            if sum(counts.values()) >= self.kills:
                break
            phase = min(job.phases, key=lambda name: (counts[name], self.random.random()))
            call = self.start(job, folder, log)
            if call.wait_for_phase(phase):
                time.sleep(self.random.random() * durations.get(phase, 0.2))
            killed_in = call.kill()
            if killed_in in (None, "ended"):
                if call.process.returncode not in (0, 75, -signal.SIGKILL):
                    self.proof.fault(job, f"ended with {call.process.returncode}: {call.messages.strip()}")
                continue
            counts[killed_in] += 1
            now = stamps(output, job.units)
            twice += sum(finished[name] != now.get(name) for name in finished)
            finished = now
        if not self.finish(job, folder, log):
            return twice
        now = stamps(output, job.units)
        twice += sum(finished[name] != now.get(name) for name in finished)
        self.proof.compare(job, output, whole, volatile)
        return twice + self.said_twice(log)

    @staticmethod
    def said_twice(log):
        """Frames of a run's own stages that were said to be done more than once."""
        done = [(event["stage"], event["frame"], event.get("detail", "").split(",")[0]) for event in log
                if event["event"] == "frame" and event["stage"] == "render"]
        return len(done) - len(set(done))


def print_table(rows):
    columns = ["job", "kills"] + PHASES + ["runs", "made twice", "seconds"]
    lines = [columns]
    for name, row in rows.items():
        counts = row["counts"]
        lines.append([name, sum(counts.values())] + [counts.get(phase) or "" for phase in PHASES] +
                     [row["runs"], row["twice"], round(row["seconds"])])
    widths = [max(len(str(line[i])) for line in lines) for i in range(len(columns))]
    for line in lines:
        print("  ".join(str(cell).ljust(width) if i == 0 else str(cell).rjust(width)
                        for i, (cell, width) in enumerate(zip(line, widths))))
    for name, row in rows.items():
        if row["volatile"]:
            names = sorted({re.sub(r"runs/[^/]*", "runs/*", path) for path in row["volatile"]})
            print(f"{name}: not compared, as two calls in peace differ there: {', '.join(names)}")
