#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the figures anew and compares them with those beside the METHOD documents: check.py FIGURE_DATA TOOLS ROOT

They may differ by what the last digits of a result do: by two pixels in a coordinate, by a little in a printed number."""
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
LARGEST = 60000  # bytes of a figure


def difference(drawn, kept):
    """What differs between two figures; empty if they show the same."""
    drawn, kept = (re.sub(r"base64,[^\"]*", "base64,", text) for text in (drawn, kept))
    if NUMBER.sub("N", drawn) != NUMBER.sub("N", kept):
        return "other shapes or words"
    pairs = [(float(a), float(b)) for a, b in zip(NUMBER.findall(drawn), NUMBER.findall(kept))]
    worst = max(pairs, key=lambda pair: abs(pair[0] - pair[1]), default=(0, 0))
    return "" if abs(worst[0] - worst[1]) <= 2 else f"{worst[0]:g} in the place of {worst[1]:g}"


def main():
    program, tools, root = sys.argv[1:]
    faults = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([sys.executable, HERE / "draw.py", program, tools, folder], check=True, stdout=subprocess.DEVNULL)
        figures = sorted(folder.rglob("*.svg"))
        for figure in figures:
            place = figure.relative_to(folder)
            if figure.stat().st_size > LARGEST:
                faults.append(f"{place} has {figure.stat().st_size} bytes")
            kept = pathlib.Path(root) / place
            fault = difference(figure.read_text("utf-8"), kept.read_text("utf-8")) if kept.exists() else "it is not there"
            if fault:
                faults.append(f"{place} is out of date: {fault}; draw it anew: cmake --build build --target figures")
            method = (pathlib.Path(root) / place.parent.parent / "METHOD.md").read_text("utf-8")
            if f"(pictures/{place.name})" not in method:
                faults.append(f"no METHOD.md shows {place}")
    print("\n".join(faults) or f"{len(figures)} figures are as they were drawn")
    return 1 if faults or not figures else 0


if __name__ == "__main__":
    sys.exit(main())
