"""What lies in a run's folder: files by what they hold and since when, and halves that should not be there.

Used by tools/reliability.
"""
import hashlib


def without_times(path):
    """A file's bytes, without the column of steps.csv that tells how long a step took."""
    data = path.read_bytes()
    if path.name != "steps.csv":
        return data
    rows = [line.split(b",") for line in data.split(b"\n")]
    return b"\n".join(b",".join(row[:17] + row[18:]) for row in rows)


def digests(folder):
    return {
        str(path.relative_to(folder)): hashlib.sha256(without_times(path)).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def stamps(folder, units):
    """Which file lies under each name, and since when."""
    found = {}
    for unit in units:
        for path in folder.rglob(unit) if "/" not in unit else folder.glob(unit):
            status = path.stat()
            found[str(path.relative_to(folder))] = (status.st_ino, status.st_mtime_ns)
    return found


def half_files(folder):
    return [str(path) for path in folder.rglob(".*part-*")] + [str(path) for path in folder.rglob(".umax*") if path.is_dir()]
