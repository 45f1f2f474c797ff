#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody with a robot: the way from unboxing to driving, with the virtual camera of the package plugged in."""
import cmath
import re

from newcomer import Newcomer, check


def plug_in(user, recording):
    """Connects a camera that sees what a recording holds, at the speed at which it was taken."""
    user.env["FACETLOC_ANNOUNCE_CAMERA"] = str(user.folder / recording)


def check_drive(found, truth, what):
    """Positions on the floor by stamp are those of the drive, in a frame of their own: a turn and a shift are free."""
    stamps = sorted(found.keys() & truth.keys())
    check(len(stamps) >= 0.3 * len(truth), f"{what}: {len(stamps)} of {len(truth)} images have a sure pose")
    here, there = [complex(*found[s]) for s in stamps], [complex(*truth[s][:2]) for s in stamps]
    middle_here, middle_there = sum(here) / len(here), sum(there) / len(there)
    turn = sum((b - middle_there) * (a - middle_here).conjugate() for a, b in zip(here, there))
    check(abs(turn) > 0.1, f"{what}: the robot has moved")
    turn = cmath.rect(1, cmath.phase(turn))
    worst = max(abs(turn * (a - middle_here) + middle_there - b) for a, b in zip(here, there))
    check(worst < 0.2, f"{what}: positions are right to 0.2 m, the worst to {1000 * worst:.0f} mm")  # as in the paper


with Newcomer() as user:
    user.make_sample()
    truth = user.poses("walk/query/groundtruth.txt")
    user.type("cp walk/map/camera.ini camera.ini")  # of a calibrated camera
    # Two cameras that see the same.
    user.type("mkdir drive && cp -r walk/query drive/front && cp -r walk/query drive/rear && echo 'cameras = front rear' > drive/rig.ini")
    plug_in(user, "walk/map")
    commands = user.document("apps/ROBOT.md").commands("From unboxing to driving")
    for words in ("--record", "facetloc_check", "--build", "facetloc_map info", "--stream", "supervise.py"):
        check(any(words in command for command in commands), f"the document has {words}")
    for command in commands:
        if command.startswith("facetloc_live") and "--headless" not in command:
            command = command.replace("facetloc_live", "facetloc_live --headless")  # there is no screen
        printed = user.type(command)
        if "--build" in command:
            plug_in(user, "walk/query")  # the next drive
        if "facetloc_check" in command:
            height = re.search(r"([\d.]+) m below the camera", printed)
            check(height and abs(float(height[1]) - 1.0) < 0.03, "the check measures the mounting")
        if "facetloc_map info" in command:
            check(re.search(r"number +[1-9]\d", printed), "the map has local models")
        if "read_stream.py" in command:
            found = re.findall(r"^([\d.]+) at (\S+) (\S+) (\S+),", printed, re.MULTILINE)
            check_drive({round(float(s), 3): (float(x), float(y)) for s, x, y, _ in found}, truth, "the stream")
            check(all(abs(float(z)) < 0.05 for *_, z in found), "the stream: the robot stays on its floor")
        if command.startswith("facetloc_localize"):
            found = {stamp: (x, y) for stamp, (x, y, *_) in user.poses("results/poses_tum.txt").items()}
            check_drive(found, truth, "several cameras")
        if "supervise.py" in command:
            found = re.findall(r"^([\d.]+) go (\S+) (\S+) \S+ \S+$", printed, re.MULTILINE)
            check_drive({round(float(s), 3): (float(x), float(y)) for s, x, y in found}, truth, "the supervisor")
