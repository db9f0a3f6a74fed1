"""A live session that is steered and killed, and what it must have left: the job live of tools/reliability.

Nothing of a session repeats itself, so there is no undisturbed one to compare with. What was saved must be simulated again
to the states that the session had, bit for bit; a session that became a run's folder must be that run; every state that is
kept must be whole; and the folder must take the next session, which finds what was saved as it was.
"""
import hashlib
import http.client
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import threading
import time

from left_files import digests, half_files, without_times

SCENE = """[clip]
frames = 10
substeps = 2
[body.block]
shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 0.24, 0]
rotation = [10, 0, 20]
cage.cells = [2, 2, 2]
material.young = "20 kPa"
limit.stretch = "10 %"
[obstacle.ground]
shape = "plane"
"""
SET_UP, SIMULATION, SAVING, WRITING = "set-up", "simulation", "saving", "writing"
PHASES = [SET_UP, SIMULATION, SAVING, WRITING]
MOST_KILLS_A_FOLDER = 6
PATIENCE = 60  # [s] for anything that the program must do


class Steering:
    """A WebSocket to a session that says what its page would, and hears the scene alone."""

    def __init__(self, address):
        port, target = re.fullmatch(r"http://127\.0\.0\.1:(\d+)(/\S+)", address).groups()
        door = http.client.HTTPConnection("127.0.0.1", int(port), timeout=PATIENCE)
        door.request("GET", target)
        answer = door.getresponse()
        cookie = answer.getheader("Set-Cookie").split(";")[0]
        door.close()
        host = f"127.0.0.1:{port}"
        self.socket = socket.create_connection(("127.0.0.1", int(port)), timeout=PATIENCE)
        self.socket.sendall((f"GET /live HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nCookie: {cookie}\r\n"
                             "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n").encode())
        self.file = self.socket.makefile("rb")
        while self.file.readline() not in (b"\r\n", b""):
            pass
        text = b""
        while not text.startswith(b"{") or b'"keys"' not in text:
            text = self.hear()
        self.keys = [key["path"] for key in json.loads(text)["keys"]]

    def hear(self):
        _, length = self.file.read(2)
        if length == 126:
            (length,) = struct.unpack(">H", self.file.read(2))
        elif length == 127:
            (length,) = struct.unpack(">Q", self.file.read(8))
        return self.file.read(length)

    def say(self, **message):
        text = json.dumps(message).encode()
        length = struct.pack(">B", 0x80 | len(text)) if len(text) < 126 else struct.pack(">BH", 0x80 | 126, len(text))
        self.socket.sendall(b"\x81" + length + b"\0\0\0\0" + text)  # a mask of zeros changes nothing

    def close(self):
        self.file.close()
        self.socket.close()


class Session:
    """A call of umax live and what it has said."""

    def __init__(self, program, scene, folder):
        words = [program, "live", scene, "-o", folder, "--overwrite", "--no-browser", "--progress", "json"]
        self.process = subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.notes, self.heard = [], threading.Condition()
        self.messages, self.ended = "", False
        self.readers = [threading.Thread(target=work, daemon=True) for work in (self.listen, self.hear_messages)]
        for reader in self.readers:
            reader.start()

    def listen(self):
        for line in self.process.stdout:
            event = json.loads(line)
            with self.heard:
                if event["event"] == "note":
                    self.notes.append(event["text"])
                    self.heard.notify_all()
        with self.heard:
            self.ended = True
            self.heard.notify_all()

    def hear_messages(self):
        self.messages = self.process.stderr.read()

    def wait_for(self, pattern):
        """The match in the first note that has one; none when the process ended without."""
        def found():
            return next((match for match in map(re.compile(pattern).search, list(self.notes)) if match), None)
        with self.heard:
            self.heard.wait_for(lambda: found() or self.ended, PATIENCE)
        return found()

    def end(self, how):
        self.process.send_signal(how)
        code = self.process.wait(PATIENCE)
        for reader in self.readers:
            reader.join()
        return code


def body_of_state(path):
    """A state without the digest of the scene that it was made by; none when its checksum does not fit."""
    data = path.read_bytes()
    if hashlib.sha256(data[:-64]).hexdigest().encode() != data[-64:]:
        return None
    return data[80:-64]


def digest_of(path):
    return digests(path) if path.is_dir() else hashlib.sha256(path.read_bytes()).hexdigest()


class Live:
    """Sessions in one folder after another, each session killed, and looked at."""

    name = "live"

    def __init__(self, proof):
        self.proof = proof
        self.random = random.Random(proof.random.random())
        self.scene = proof.place / "live.toml"
        self.scene.write_text(SCENE)
        self.spans = {SET_UP: 0.5, SAVING: 0.02, WRITING: 0.1}  # [s] as they turn out

    def kill_all(self, kills):
        began, counts, folders, twice = time.monotonic(), {phase: 0 for phase in PHASES}, 0, 0
        while sum(counts.values()) < kills:
            folders += 1
            folder = self.proof.place / "live-killed"
            shutil.rmtree(folder, ignore_errors=True)
            self.saved = {}  # what the folder must keep: name -> digest
            for _ in range(self.random.randint(2, MOST_KILLS_A_FOLDER)):
                if sum(counts.values()) >= kills:
                    break
                phase = min(PHASES, key=lambda name: (counts[name], self.random.random()))
                killed_in = self.kill_session(folder, phase)
                if killed_in:
                    counts[killed_in] += 1
            self.end_in_peace(folder)
        return {"counts": counts, "runs": folders, "twice": twice, "volatile": [], "seconds": time.monotonic() - began}

    def fault(self, text):
        self.proof.fault(self, text)

    def begin(self, folder):
        """A session that is steered; none when it does not begin."""
        began = time.monotonic()
        session = Session(self.proof.program, self.scene, folder)
        address = session.wait_for(r"umax live is at (\S+)")
        if not address:
            session.end(signal.SIGKILL)
            self.fault(f"does not begin in the folder of one that was killed: {session.messages.strip()}")
            return session, None
        self.spans[SET_UP] = time.monotonic() - began
        self.look_at_saved(folder)
        return session, Steering(address.group(1))

    def play(self, steering, seconds):
        """Turns and pulls at random for so long, and goes back to an earlier frame now and then."""
        say, value = steering.say, self.random.uniform
        until = time.monotonic() + seconds
        say(wish="play")
        while (left := until - time.monotonic()) > 0:
            time.sleep(min(left, value(0.02, 0.15)))
            wish = self.random.choice(["stretch", "young", "grab", "move", "move", "release", "rewind"])
            if wish == "stretch":
                say(wish="set", key=steering.keys.index("body.block.limit.stretch"), value=value(0.05, 0.2))
            elif wish == "young":
                say(wish="set", key=steering.keys.index("body.block.material.young"), value=value(1e4, 4e4))
            elif wish == "grab":
                say(wish="grab", body=0, vertex=3, place=[value(-1, 1), value(0.2, 1), value(-1, 1)])
            elif wish == "rewind":
                say(wish="rewind", frame=self.random.randint(2, 10))
                say(wish="play")
            else:
                say(wish=wish, **({"place": [value(-1, 1), value(0.2, 1), value(-1, 1)]} if wish == "move" else {}))

    def kill_session(self, folder, phase):
        """Begins a session, kills it in that phase; looks at what is left. The phase in which it was killed, none if it was not."""
        if phase == SET_UP:
            session = Session(self.proof.program, self.scene, folder)
            time.sleep(self.random.random() * self.spans[SET_UP])
            is_killed = self.kill(session)
            self.look_at(folder, session)
            return phase if is_killed else None
        session, steering = self.begin(folder)
        if not steering:
            return None
        self.play(steering, self.random.uniform(0.2, 0.8))
        if self.random.random() < 0.5:
            steering.say(wish=self.random.choice(["save", "render"]))
            session.wait_for(r"umax (simulate|render)")
            self.play_on(steering)
        told = len(session.notes)
        if phase == SIMULATION:
            time.sleep(self.random.uniform(0, 0.2))
        else:
            self.wish_and_wait(session, steering, phase)
        is_killed = self.kill(session)
        steering.close()
        self.look_at(folder, session)
        return None if not is_killed else phase if len(session.notes) == told else SIMULATION

    def play_on(self, steering):
        """A little further: nothing is turned, so that what was saved is a part of what follows."""
        steering.say(wish="play")
        time.sleep(self.random.uniform(0, 0.2))

    def wish_and_wait(self, session, steering, phase):
        """Wishes for a scene or a run, or ends the session, which saves it, too; and waits for a moment in the midst of it."""
        if phase == SAVING and self.random.random() < 0.5:
            session.process.send_signal(signal.SIGTERM)
            time.sleep(self.random.random() * 0.3)
        else:
            steering.say(wish="render" if phase == WRITING else "save")
            time.sleep(self.random.random() * self.spans[phase])

    def kill(self, session):
        """Whether it was there to be killed."""
        code = session.end(signal.SIGKILL)
        if code not in (-signal.SIGKILL, 128 + signal.SIGTERM):
            self.fault(f"ended with {code}: {session.messages.strip()}")
        return code == -signal.SIGKILL

    # ---- what is left

    def look_at(self, folder, session):
        if not folder.exists():
            return
        kept = {}
        for path in sorted((folder / "states").glob("*.state")):
            kept[int(path.stem)] = body_of_state(path)
            if kept[int(path.stem)] is None:
                self.fault(f"{path} is not whole")
        if kept and list(kept) != list(range(1, len(kept) + 1)):
            self.fault(f"states are missing between {min(kept)} and {max(kept)}")
        told = [re.search(r"(session-\d+)", note).group(1) for note in session.notes if "session-" in note]
        for name in told:
            if not (folder / f"{name}.toml").exists():
                self.fault(f"{name} was said to be saved, and is not there")
        runs = [re.search(r"(session-\d+)$", note).group(1) for note in session.notes if "umax render" in note]
        for scene in sorted(folder.glob("session-*.toml")):
            if scene.name not in self.saved:
                self.look_at_session(folder, scene, kept, scene.stem in runs)
                self.saved.update({path.name: digest_of(path) for path in folder.glob(f"{scene.stem}*")})

    def look_at_session(self, folder, scene, kept, is_run):
        """What was saved is the session; a run's folder is the run of it, or becomes it."""
        again = self.proof.place / "live-again"
        shutil.rmtree(again, ignore_errors=True)
        if not self.call(["simulate", scene, "-o", again]):
            return
        states = sorted((again / "states").glob("*.state"))
        if len(states) > len(kept):
            self.fault(f"{scene} has {len(states)} frames, but only {len(kept)} states were kept")
        for path in states:
            if int(path.stem) in kept and kept[int(path.stem)] != body_of_state(path):
                self.fault(f"{scene} is not the session: {path.name} has other bytes")
                break
        run = scene.with_suffix("")
        if run.exists():
            if not is_run and not self.call(["simulate", scene, "-o", run, "--resume"]):
                return
            for path in states + [again / "steps.csv"]:
                other = run / path.relative_to(again)
                if not other.exists() or without_times(other) != without_times(path):
                    self.fault(f"{other} is not what umax simulate makes of {scene.name}")
                    break

    def look_at_saved(self, folder):
        for name, files in self.saved.items():
            path = folder / name
            if not path.exists() or digest_of(path) != files:
                self.fault(f"{path} was saved, and is not what it was after the next session began")

    def end_in_peace(self, folder):
        """The next session begins and ends; one that was saved is opened; nothing half stays."""
        session, steering = self.begin(folder)
        if steering:
            self.play(steering, 0.3)
            began = time.monotonic()
            steering.say(wish="save")
            session.wait_for("umax simulate")
            self.spans[SAVING] = time.monotonic() - began
            began = time.monotonic()
            steering.say(wish="render")
            session.wait_for("umax render")
            self.spans[WRITING] = time.monotonic() - began
            steering.close()
            code = session.end(signal.SIGTERM)
            if code != 128 + signal.SIGTERM:
                self.fault(f"ended with {code} when asked to: {session.messages.strip()}")
            self.look_at(folder, session)
        for name in half_files(folder):
            if not pathlib.Path(name).is_dir() or os.listdir(name):
                self.fault(f"{name} stayed")
        # one in which something was pulled can be simulated, but not steered
        scenes = [path for path in sorted(folder.glob("session-*.toml")) if not path.with_suffix(".pulls").exists()]
        if scenes:
            opened = Session(self.proof.program, self.random.choice(scenes), self.proof.place / "live-opened")
            is_open = opened.wait_for("umax live is at")
            opened.end(signal.SIGTERM)
            if not is_open:
                self.fault(f"a saved session is not opened: {opened.messages.strip()}")
            shutil.rmtree(self.proof.place / "live-opened", ignore_errors=True)

    def call(self, words):
        done = subprocess.run([str(word) for word in [self.proof.program] + words + ["--quiet"]], stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            self.fault(f"umax {' '.join(map(str, words))} ends with {done.returncode}: {done.stderr.strip()}")
        return done.returncode == 0
