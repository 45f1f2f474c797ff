#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Feeds facetloc_live from an Orbbec camera: orbbec.py | facetloc_live --device - ...

Not run by the tests: it needs pyorbbecsdk, Orbbec's SDK version 2 (pip install pyorbbecsdk2), and a camera. An Astra with the
older OpenNI2 driver needs no program: facetloc_live finds it."""
import json
import sys

from pyorbbecsdk import Config, OBFormat, OBSensorType, Pipeline

pipeline, config = Pipeline(), Config()
profiles = pipeline.get_stream_profile_list(OBSensorType.DEPTH_SENSOR)
profile = profiles.get_video_stream_profile(640, 0, OBFormat.Y16, 30)  # 0 = any height
config.enable_stream(profile)
pipeline.start(config)
k = profile.get_intrinsic()
header = {"fx": k.fx, "fy": k.fy, "cx": k.cx, "cy": k.cy}
try:
    while True:
        frames = pipeline.wait_for_frames(1000)  # [ms]
        depth = frames.get_depth_frame() if frames else None
        if depth is None:
            continue
        size = {"width": depth.get_width(), "height": depth.get_height(),
                "depth_scale": 1000 / depth.get_depth_scale()}  # which is in millimetres per value
        line = json.dumps({"stamp": depth.get_timestamp_us() / 1e6, **size, **header})
        sys.stdout.buffer.write(line.encode() + b"\n" + bytes(depth.get_data()))
        sys.stdout.buffer.flush()
except (BrokenPipeError, KeyboardInterrupt):
    pipeline.stop()
    sys.stderr.close()
