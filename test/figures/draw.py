#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the figures of the METHOD documents: draw.py FIGURE_DATA TOOLS FOLDER

FIGURE_DATA is the program that computes what they show, TOOLS the folder of the command-line tools. The figures are written to
where they lie below FOLDER, the root of the project or a copy of its folders."""
import json
import pathlib
import subprocess
import sys

import figures
from belief import belief_facts

PLACES = {
    "pipeline": "registration", "split": "segmentation", "segment": "features", "tree": "registration", "verdicts": "registration",
    "direction": "registration", "belief": "registration/localization",
}


def main():
    if len(sys.argv) != 4:
        sys.exit(f"usage: {sys.argv[0]} FIGURE_DATA TOOLS FOLDER")
    program, tools, root = (pathlib.Path(path).resolve() for path in sys.argv[1:])
    for name, module in PLACES.items():
        if name == "belief":
            facts = belief_facts(tools)
        else:
            facts = json.loads(subprocess.run([program, name], check=True, stdout=subprocess.PIPE).stdout)
        folder = root / module / "pictures"
        folder.mkdir(parents=True, exist_ok=True)
        figure, title = getattr(figures, name)(facts)
        figure.write(folder / f"{name}.svg", title)
        print(folder / f"{name}.svg")


if __name__ == "__main__":
    main()
