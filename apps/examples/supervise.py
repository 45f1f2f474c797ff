#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Keeps a robot localized: supervise.py MAP.flmap [options of facetloc_live]

Makes the map if it is not there, follows the robot in it, and says for each image what it may do: go (its pose is sure),
slow (was sure a moment ago) or stop. Restarts facetloc_live where the robot was if that ends with an error."""
import json
import math
import os
import signal
import subprocess
import sys
import time

LIVE = os.environ.get("FACETLOC_LIVE", "facetloc_live")
MAP, OPTIONS = sys.argv[1], [*sys.argv[2:], "--headless"]
LAST = MAP + ".last"  # the last sure pose, also for the next start of this program
PATIENCE, FAILURES = 1.0, 5  # [s] without a sure pose until it stops; starts without any until somebody has to come

def near():  # the last sure pose, if there is one
    try:
        with open(LAST, encoding="utf-8") as file:
            return ["--near={:.3f},{:.3f},{:.3f},{:.1f}".format(*json.load(file))]
    except (OSError, ValueError, TypeError, IndexError):
        return []

def follow(stream):  # until it ends; was any pose sure?
    sure_at = None
    for line in stream:
        if not line.endswith("\n"):  # of a process that was killed
            break
        answer = json.loads(line)
        if "state" not in answer:  # of another kind, such as a finding
            continue
        stamp, what, command = answer["stamp"], answer["reason"] or "no place is likely enough", "stop"
        if answer["state"] == "sure" and answer["T_w_c"]:
            (x, y, z), (i, j, k, w) = answer["T_w_c"]["position"], answer["T_w_c"]["quaternion"]
            yaw = math.degrees(math.atan2(2 * (j * k - w * i), 2 * (i * k + w * j)))  # of the optical axis
            with open(LAST + ".new", "w", encoding="utf-8") as file:
                json.dump([x, y, z, yaw], file)
            os.replace(LAST + ".new", LAST)
            sure_at, command, what = stamp, "go", f"{x:.3f} {y:.3f} {z:.3f} {yaw:.1f}"
        elif sure_at is not None and stamp - sure_at < PATIENCE:
            command = "slow"
        if command != "go" and answer.get("next_look"):
            what += "; turn {yaw_deg:.0f} deg, drive {ahead:.1f} m".format(**answer["next_look"])
        print(f"{stamp:.3f} {command} {what}", flush=True)
    return sure_at is not None

signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
if not os.path.exists(MAP) and subprocess.run([LIVE, "--build", MAP, *OPTIONS], check=False).returncode:
    sys.exit(f"{MAP} could not be made")
failures = 0
while failures < FAILURES:
    with subprocess.Popen([LIVE, "--map", MAP, "--stream", *near(), *OPTIONS], stdout=subprocess.PIPE, text=True) as live:
        print("start", live.pid, *near(), flush=True)
        try:
            failures = 0 if follow(live.stdout) else failures + 1
        finally:
            live.terminate()
    if live.returncode in (0, 2):  # the end, or options that it does not know
        sys.exit(live.returncode)
    time.sleep(0.5)
sys.exit("facetloc_live does not find its way, or does not run: see its messages")
