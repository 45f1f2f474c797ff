#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""First steps in Python: first_steps.py [PICTURE.png]

A made-up room is driven through, its planes are drawn, a map is made of it, and a robot that comes back later is localized. Needs
python3-facetloc and python3-matplotlib."""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import facetloc

# The planes of a depth image.
drive = facetloc.simulate("room", run="map", seed=5, frames=40)
planes = facetloc.segment(drive[0].depth, drive.camera)
print(f"{len(planes.segments)} planes; the largest is {max(s.area for s in planes.segments):.1f} m^2")

# A map of what the robot sees on its way.
making = facetloc.MapMaking(drive.camera)
for frame in drive:
    making.add(frame.depth, frame.stamp, T_w_c=frame.T_w_c)
room = making.finish()
print(f"a map of {len(room)} local models and {len(room.links)} links")

# Where it is when it comes back, by single images.
later = facetloc.simulate("room", run="query", seed=5, frames=15)
localizer = facetloc.Localizer(room)
answers = [localizer.localize(frame.depth, later.camera) for frame in later]
for frame, answer in zip(later, answers):
    if answer.sure:
        error = np.linalg.norm(answer.T_w_c[:3, 3] - frame.T_w_c[:3, 3])
        print(f"{frame.name}: sure (p {answer.probability:.3f}), off by {1000 * error:.0f} mm")
    else:
        print(f"{frame.name}: {answer.state}: {answer.reason or 'no place is likely enough'}")

fig, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 4))
left.imshow(drive[0].depth, cmap="viridis")
left.set_title("depth [m]")
middle.imshow(np.where(planes.labels, planes.labels % 19 + 1, 0), cmap="tab20")
middle.set_title("planes")
models = np.array([model.T_w_m[:2, 3] for model in room.models])
right.plot(*models.T, "s", color="0.6", label="local models")
right.plot(*np.array([frame.T_w_c[:2, 3] for frame in later]).T, "k+", label="true")
sure = [answer.T_w_c[:2, 3] for answer in answers if answer.sure]
if sure:
    right.plot(*np.array(sure).T, "o", mfc="none", color="tab:green", label="sure")
right.axis("equal")
right.legend()
right.set_title("the map from above [m]")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "first_steps.png", bbox_inches="tight")
