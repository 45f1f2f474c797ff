#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Feeds facetloc_live from a RealSense: realsense.py [WIDTH HEIGHT RATE] | facetloc_live --device - ...

Not run by the tests: it needs pyrealsense2, Intel's SDK (pip install pyrealsense2), and a camera. Without the SDK:
facetloc_live --device /dev/video0 --camera realsense_d435."""
import json
import sys

import pyrealsense2 as rs

width, height, rate = (int(a) for a in sys.argv[1:4]) if len(sys.argv) > 3 else (640, 480, 30)
pipeline, config = rs.pipeline(), rs.config()
config.enable_stream(rs.stream.depth, width, height, rs.format.z16, rate)
profile = pipeline.start(config)
sensor = profile.get_device().first_depth_sensor()
k = profile.get_stream(rs.stream.depth).as_video_stream_profile().get_intrinsics()
header = {"width": k.width, "height": k.height, "fx": k.fx, "fy": k.fy, "cx": k.ppx, "cy": k.ppy,
          "depth_scale": 1 / sensor.get_depth_scale()}
if "D4" in profile.get_device().get_info(rs.camera_info.name):
    header["camera"] = "realsense_d435"  # its noise
try:
    while True:
        frame = pipeline.wait_for_frames().get_depth_frame()
        line = json.dumps({"stamp": frame.get_timestamp() / 1000, **header})
        sys.stdout.buffer.write(line.encode() + b"\n" + bytes(frame.get_data()))
        sys.stdout.buffer.flush()
except (BrokenPipeError, KeyboardInterrupt):
    pipeline.stop()
    sys.stderr.close()
