#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Publishes the poses of a stream: facetloc_live --map office.flmap --headless --stream | read_stream.py [PORT]"""
import json
import socket
import sys

port = int(sys.argv[1]) if len(sys.argv) > 1 else 7501
out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

for line in sys.stdin:
    answer = json.loads(line)
    if "state" not in answer:  # of another kind, such as a finding
        continue
    if answer["state"] != "sure":  # a robot acts on nothing else
        print(f"{answer['stamp']:.3f} {answer['state']}: {answer['reason']}", file=sys.stderr)
        continue
    pose = answer["T_w_b"] or answer["T_w_c"]  # of the robot, where camera.ini tells how the camera is mounted
    x, y, z = pose["position"]
    message = {"stamp": answer["stamp"], "position": [x, y, z], "quaternion": pose["quaternion"]}
    out.sendto(json.dumps(message).encode(), ("127.0.0.1", port))  # in ROS: publisher.publish(...)
    print(f"{answer['stamp']:.3f} at {x:.3f} {y:.3f} {z:.3f}, probability {answer['probability']:.2f}")
