# SPDX-License-Identifier: BSD-3-Clause
"""A drive through a hotel of equal rooms, by the command-line tools."""
import csv
import math
import os
import pathlib
import subprocess
import tempfile


def belief_facts(tools):
    """For each image of a drive: time, true position, and the places with their probabilities."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run = lambda *command: subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                              env=dict(os.environ, PATH=f"{tools}:{os.environ['PATH']}"))
        run("facetloc_simulate", "hotel", "-o", "hotel", "--width", "320", "--map-frames", "200", "--query-frames", "46", "--quiet")
        run("facetloc_map", "build", "hotel/map", "-o", "hotel.flmap", "--quiet")
        run("facetloc_localize", "hotel.flmap", "hotel/query", "-o", "results", "--sequence", "--quiet")
        truth = {}
        for line in (folder / "hotel/query/groundtruth.txt").read_text(encoding="utf-8").splitlines():
            if not line.startswith("#"):
                stamp, *pose = line.split()
                truth[round(float(stamp), 3)] = [float(value) for value in pose[:3]]
        images = {}
        with open(folder / "results/hypotheses.csv", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                stamp = round(float(row["frame"]), 3)
                image = images.setdefault(stamp, {"time": stamp, "at": truth[stamp], "right": 0.0, "others": 0.0, "state": row["state"],
                                                  "not_in_map": float(row["not_in_map"])})
                if int(row["rank"]) > 0:
                    off = math.dist([float(row[axis]) for axis in ("w_tx", "w_ty", "w_tz")], truth[stamp])
                    image["right" if off < 0.5 else "others"] += float(row["probability"])
    return sorted(images.values(), key=lambda image: image["time"])
