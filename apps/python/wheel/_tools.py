# SPDX-License-Identifier: BSD-3-Clause
"""The tools of the wheel: each command becomes the program of its name in the package."""
import os
import pathlib
import sys


def run() -> None:
    program = pathlib.Path(__file__).resolve().parent / "bin" / pathlib.Path(sys.argv[0]).name
    os.execv(program, [str(program), *sys.argv[1:]])
