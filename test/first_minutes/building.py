#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody with a scan or a plan of a building: maps before any camera was there."""
from newcomer import Newcomer, check, check_right

with Newcomer() as user:
    user.make_sample()
    for command in user.document("README.md").commands("You have a scan or a floor plan"):
        user.type(command)
    check_right(user.poses("found/poses_tum.txt"), user.poses("walk/query/groundtruth.txt"), 0.5)
    user.page("plan.html")
    printed = user.type("facetloc_map info plan.flmap")
    check("local models" in printed, "the plan has become a map")
