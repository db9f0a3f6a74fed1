"""The program umax as a process: its answers, its progress line by line, its errors as they are."""
import json
import queue
import shutil
import signal
import subprocess
import threading

import bpy

from .settings import preferences


class ProgramError(Exception):
    """The message is what the program said."""


def path():
    """of the program. Throws ProgramError where there is none."""
    wanted = bpy.path.abspath(preferences().program)
    found = shutil.which(wanted)
    if not found:
        raise ProgramError(f"umax: error: the program \"{wanted}\" is not there; "
                           "name it in Edit > Preferences > Add-ons > umax > Program")
    return found


def answer(words):
    """what the program prints"""
    done = subprocess.run([path(), *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
    if done.returncode != 0:
        raise ProgramError(done.stderr.strip() or f"umax ended with exit code {done.returncode}")
    return done.stdout


class Run:
    """A call of the program that goes on while Blender does other things."""

    def __init__(self, words, folder):
        self.process = subprocess.Popen([path(), *words, "--progress", "json"], cwd=folder, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace")
        self.events = queue.Queue()
        self.messages = []
        self.readers = [threading.Thread(target=self._read_events, daemon=True),
                        threading.Thread(target=self._read_messages, daemon=True)]
        for reader in self.readers:
            reader.start()

    def _read_events(self):
        for line in self.process.stdout:
            try:
                self.events.put(json.loads(line))
            except ValueError:
                pass  # no event

    def _read_messages(self):
        for line in self.process.stderr:
            self.messages.append(line.rstrip())

    def is_running(self):
        return self.process.poll() is None

    def new_events(self):
        """those that came since the last call"""
        found = []
        while not self.events.empty():
            found.append(self.events.get())
        return found

    def finish(self):
        """Waits for the end and returns the warnings. Throws ProgramError with what the program said of its failure."""
        code = self.process.wait()
        for reader in self.readers:
            reader.join()
        for stream in (self.process.stdout, self.process.stderr):
            stream.close()
        if code == 0:
            return self.messages
        if code < 0 and not self.messages:
            raise ProgramError(f"umax ended by signal {signal.Signals(-code).name}")
        raise ProgramError("\n".join(self.messages) or f"umax ended with exit code {code}")

    def stop(self):
        """Ends it; what it has finished is kept."""
        if self.is_running():
            self.process.terminate()
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()


def version():
    return answer(["--version"]).strip().splitlines()[0]
