#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Plays a folder of 16-bit PNG images as a camera: replay.py FOLDER [RATE] | facetloc_live --device - ...

FOLDER or the one above it has a camera.ini. RATE is in images per second, 30 unless given, 0 = as fast as they are taken.
Stamps are the numbers in the names, in seconds, or without such names count images at RATE. Needs python3-numpy, python3-pil."""
import json
import pathlib
import re
import sys
import time

import numpy
from PIL import Image

folder, rate = pathlib.Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 30.0
ini = next(place / "camera.ini" for place in (folder, folder.parent) if (place / "camera.ini").exists())
text = re.sub("#.*", "", ini.read_text(encoding="utf-8"))
camera = {key: value for key, value in re.findall(r"(\w+)\s*=\s*(\S+)", text)}
for key in camera.keys() - {"camera", "depth_is"}:  # the keys whose values are words
    camera[key] = float(camera[key])
files = list((folder / "depth" if (folder / "depth").is_dir() else folder).glob("*.png"))
files.sort(key=lambda file: [float(n) for n in re.findall(r"\d+(?:\.\d+)?", file.stem)] or [0.0])
begin = time.monotonic()
try:
    for n, file in enumerate(files):
        pixels = numpy.asarray(Image.open(file)).astype("<u2")
        timed = re.fullmatch(r"\d+\.\d+", file.stem)
        header = {"stamp": float(file.stem) if timed else n / (rate or 30), **camera}
        header["height"], header["width"] = pixels.shape
        if rate > 0:
            time.sleep(max(0.0, begin + n / rate - time.monotonic()))
        sys.stdout.buffer.write(json.dumps(header).encode() + b"\n" + pixels.tobytes())
        sys.stdout.buffer.flush()
except BrokenPipeError:  # whoever took the frames has ended
    sys.stderr.close()
