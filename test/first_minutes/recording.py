#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody with a recording: first steps, then the steps that they consist of."""
from newcomer import Newcomer, check, check_right

with Newcomer() as user:
    readme = user.document("README.md")
    for command in readme.commands("First steps"):
        if command.startswith("facetloc"):  # what follows the build
            user.type(command)
    truth = user.poses("walk/query/groundtruth.txt")
    check(len(truth) >= 20, f"the sample has {len(truth)} images to be found")
    check("sure" in user.page("walk.try/report.html"), "the report of facetloc try has a verdict")
    check_right(user.poses("walk.try/details/results/poses_tum.txt"), truth, 0.9, 0.3, 5.0)  # as one drive

    for command in readme.commands("You have a recording"):
        printed = user.type(command)
        if command.startswith("facetloc_check"):
            check("camera" in printed, "facetloc_check describes the recording")
    check_right(user.poses("results/poses_tum.txt"), truth, 0.3)  # image by image
    user.has("walk.flmap", "results/hypotheses.csv")
    check("sure" in user.page("evaluation/report.html"), "the evaluation has a verdict")
    user.page("answers.html")
    check((user.folder / "answers.html").stat().st_size < 3e6, "the map to turn is a file below 3 MB")
