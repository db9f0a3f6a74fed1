"""Fills a small disk under umax, gives it room again, and compares what comes out with what a large disk gets.

Used by tools/reliability. Each job works on a file system of its own in a file, which has room for a part of what the job
writes. It must end with 73 or 74 and say that there is no space, leave no half file, and, once there is room, go on to the
files that it makes in peace, byte for byte. Only root may mount such a disk.
"""
import ctypes
import os
import shutil
import subprocess
import time

from jobs import volatile_files
from left_files import digests, half_files

DISK_BYTES = 64 << 20
BLOCK_BYTES = 4096
SHARES = (0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95)  # of what a job writes, that there is room for
CLONE_NEWNS = 0x20000


class CannotMount(Exception):
    pass


def run(*words):
    try:
        result = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    except OSError as error:
        raise CannotMount(f"{words[0]}: {error.strerror}") from error
    if result.returncode != 0:
        raise CannotMount(f"{words[0]}: {result.stdout.strip()}")


class SmallDisk:
    """A file system in a file, which this process and its children alone see, and which goes with them."""

    def __init__(self, place):
        self.folder, self.ballast = place / "disk", place / "disk" / "ballast"
        self.folder.mkdir(exist_ok=True)
        image = place / "disk.image"
        with open(image, "wb") as file:
            file.truncate(DISK_BYTES)
        if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNS) != 0:
            raise CannotMount(f"unshare: {os.strerror(ctypes.get_errno())}")
        run("mount", "--make-rprivate", "/")
        run("mkfs.ext4", "-q", "-F", "-m", "0", "-O", "^has_journal", image)
        run("mount", "-o", "loop", image, self.folder)

    def used(self):
        status = os.statvfs(self.folder)
        return (status.f_blocks - status.f_bfree) * status.f_frsize

    def clear(self):
        for path in self.folder.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    def leave_room(self, room):
        """So many bytes, or a little less."""
        with open(self.ballast, "wb", buffering=0) as file:
            try:
                while (left := self.room()) > room + BLOCK_BYTES:
                    file.write(bytes(max(BLOCK_BYTES, (left - room) // 2)))
            except OSError:  # the file system needs a little for what it knows of the file
                pass
            os.fsync(file.fileno())

    def room(self):
        status = os.statvfs(self.folder)
        return status.f_bavail * status.f_frsize

    def give_room(self):
        self.ballast.unlink()


class FullDisks:
    """Fills the disk under jobs, so often each as there are shares."""

    def __init__(self, proof, shares=SHARES):
        self.proof, self.shares, self.disk = proof, shares, SmallDisk(proof.place)

    def call(self, job, folder):
        words = [self.proof.program] + job.words(folder) + ["--quiet"]
        return subprocess.run([str(word) for word in words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def begin(self, job):
        self.disk.clear()
        folder = self.disk.folder / job.name
        folder.mkdir()
        job.prepare(folder)
        return folder

    def in_peace(self, job):
        """What is left, and how many bytes that took."""
        folder = self.begin(job)
        before = self.disk.used()
        result = self.call(job, folder)
        if result.returncode != 0:
            raise SystemExit(f"{job.name} fails on a disk with room: {result.stderr}")
        return digests(job.output(folder)), self.disk.used() - before

    def fill(self, job):
        began = time.monotonic()
        whole, size = self.in_peace(job)
        volatile = volatile_files(whole, self.in_peace(job)[0])
        filled = 0
        for share in self.shares:
            folder = self.begin(job)
            self.disk.leave_room(int(share * size))
            filled += self.is_told(job, self.call(job, folder), share)
            for name in half_files(self.disk.folder):
                self.proof.fault(job, f"a full disk left {name}")
            self.disk.give_room()
            again = self.call(job, folder)
            if again.returncode != 0:
                self.proof.fault(job, f"with room again it ends with {again.returncode}: {again.stderr.strip()}")
            else:
                self.proof.compare(job, job.output(folder), whole, volatile)
        print(f"{job.name}: {filled} of {len(self.shares)} times the disk was full, {time.monotonic() - began:.0f} s", flush=True)
        return filled

    def is_told(self, job, result, share):
        """Whether the disk was full; a job that needs no more than there is ends well."""
        if result.returncode == 0:
            return False
        if result.returncode not in (73, 74) or "space" not in result.stderr or "internal" in result.stderr:
            self.proof.fault(job, f"with room for {share:.0%} it ends with {result.returncode}: {result.stderr.strip()}")
        return True
