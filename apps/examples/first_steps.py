#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""First steps in Python: first_steps.py [PICTURE.png], or cell by cell in an editor that knows # %%.

A simulated room is driven through, its planes are drawn, a map is made of it, and a robot that comes back later is localized. Needs
python3-facetloc and python3-matplotlib."""
# %% The planes of a depth image.
import sys

import matplotlib.pyplot as plt
import numpy as np

import facetloc

drive = facetloc.simulate("room", run="map", frames=40)
planes = facetloc.segment(drive[0].depth, drive.camera)
print(f"{planes}; the largest is {max(s.area for s in planes.segments):.1f} m^2")

# %% A map of what the robot sees on its way.
making = facetloc.MapMaking(drive.camera)
for frame in drive:
    making.add(frame.depth, frame.stamp, T_w_c=frame.T_w_c)
room = making.finish()
print(room)

# %% Where it is when it comes back, later and on another line.
later = facetloc.simulate("room", run="query", frames=15)
localizer = facetloc.Localizer(room)
answers = [localizer.update(frame.depth, later.camera, frame.stamp) for frame in later]  # localize() for single images
for frame, answer in zip(later, answers):
    if answer.sure:
        error = np.linalg.norm(answer.T_w_c[:3, 3] - frame.T_w_c[:3, 3])
        print(f"{frame.name}: sure (p {answer.probability:.3f}), off by {1000 * error:.0f} mm")
    else:
        print(f"{frame.name}: {answer.state}: {answer.reason or 'no place is likely enough'}")

# %% All of it in one picture; facetloc.show(room) opens the map as a page.
fig, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 4))
left.imshow(drive[0].depth, cmap="viridis")
left.set_title("depth [m]")
middle.imshow(np.where(planes.labels, planes.labels % 19 + 1, 0), cmap="tab20")
middle.set_title("planes")
facetloc.draw(room, answers, ax=right)
right.plot(*np.array([frame.T_w_c[:2, 3] for frame in later]).T, "k+", label="true")
right.legend(fontsize="small", framealpha=0.6)
right.set_title("the map from above")
fig.savefig(sys.argv[1] if len(sys.argv) > 1 else "first_steps.png", bbox_inches="tight")
