#!/usr/bin/env python3
"""Which lines of the physics and of the embedding the tests run, room by room: what tools/test --coverage prints.

usage: coverage.py SUMMARY [--least PERCENT]     SUMMARY: of gcovr --json-summary

Exit code 1 when a top folder's share of lines is below PERCENT."""
import argparse
import json
import sys
from pathlib import PurePath


def rooms(files):
    """[covered, all] lines by room, a folder, and by the top folder that it stands in"""
    by_room, by_top = {}, {}
    for file in files:
        path = PurePath(file["filename"])
        for table, name in ((by_room, str(path.parent)), (by_top, path.parts[0])):
            counts = table.setdefault(name, [0, 0])
            counts[0] += file["line_covered"]
            counts[1] += file["line_total"]
    return by_room, by_top


def line(name, counts):
    return f"{name:28} {counts[0]:6} of {counts[1]:6} lines  {100 * counts[0] / max(1, counts[1]):5.1f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("summary")
    parser.add_argument("--least", type=float, default=90, help="percent of a top folder's lines (default: 90)")
    options = parser.parse_args()
    with open(options.summary) as file:
        files = json.load(file)["files"]
    by_room, by_top = rooms(files)
    for name in sorted(by_room):
        print(line(name, by_room[name]))
    print("least covered files:")
    for file in sorted(files, key=lambda f: f["line_covered"] - f["line_total"])[:10]:
        print("  " + line(file["filename"], [file["line_covered"], file["line_total"]]))
    for name in sorted(by_top):
        print(line(name, by_top[name]))
    if not by_top:
        print("coverage: error: no file of ours was counted; are the tests built by the preset coverage?", file=sys.stderr)
        return 70
    low = [name for name, counts in by_top.items() if 100 * counts[0] < options.least * counts[1]]
    if low:
        print(f"coverage: error: below {options.least:g} %: {', '.join(low)}; test what stands above", file=sys.stderr)
    return 1 if low else 0


if __name__ == "__main__":
    sys.exit(main())
