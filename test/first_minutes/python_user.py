#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody who writes Python: the code of README as it stands there, then the example that it names."""
import importlib.util
import pathlib
import re
import sys

from newcomer import Newcomer, check, check_picture, check_right


def pose(text):
    """x y z and a unit quaternion of a printed 4x4 matrix."""
    m = [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e[-+]\d+)?", text)]
    check(len(m) == 16, "a pose is a 4x4 matrix")
    w = 0.5 * max(0.0, 1 + m[0] + m[5] + m[10]) ** 0.5
    x, y, z = (0.5 * max(0.0, 1 + s) ** 0.5 for s in (m[0] - m[5] - m[10], m[5] - m[0] - m[10], m[10] - m[0] - m[5]))
    largest = max(("w", w), ("x", x), ("y", y), ("z", z), key=lambda named: named[1])[0]
    a, b, c = m[9] - m[6], m[2] - m[8], m[4] - m[1]
    d, e, f = m[4] + m[1], m[8] + m[2], m[9] + m[6]
    quaternion = {"w": (a, b, c, 4 * w * w), "x": (4 * x * x, d, e, a), "y": (d, 4 * y * y, f, b), "z": (e, f, 4 * z * z, c)}[largest]
    size = sum(q * q for q in quaternion) ** 0.5
    return [m[3], m[7], m[11], *(q / size for q in quaternion)]


with Newcomer() as user:
    packages = list({package.parent.resolve() for package in user.prefix.glob("lib*/python3*/*-packages/facetloc")})
    check(len(packages) == 1, "the Python package is installed")
    user.env["PYTHONPATH"] = str(packages[0])
    user.make_sample()
    user.type("facetloc_map build walk/map -o walk.flmap")

    (program,) = user.document("README.md").code("You write Python", "python")
    (user.folder / "program.py").write_text(program, encoding="utf-8")
    printed = user.type(f"{sys.executable} program.py")
    # In the order of the images: four lines of a matrix if the answer is sure, else a line with the reason.
    answers, lines = [], iter(printed.splitlines())
    for line in lines:
        answers.append(" ".join([line, *(next(lines) for _ in range(3))]) if line.startswith("[[") else line)
    truth = user.poses("walk/query/groundtruth.txt")
    check(len(answers) == len(truth), f"each of {len(truth)} images has an answer")
    sure = {stamp: pose(answer) for stamp, answer in zip(sorted(truth), answers) if answer.startswith("[[")}
    check_right(sure, truth, 0.3)

    if importlib.util.find_spec("matplotlib"):
        examples = [path for path in re.findall(r"\((apps/examples/\w+\.py)\)", "\n".join(user.document("README.md").section("You write Python")))]
        check(len(examples) == 1, "README names an example")
        printed = user.type(f"{sys.executable} {examples[0]} first_steps.png")
        check("sure" in printed, "the example finds the camera")
        check_picture(user.folder / "first_steps.png")
    else:
        print("left out, without matplotlib: the example")
