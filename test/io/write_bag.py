#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes a ROS bag with the library of ROS: write_bag.py FOLDER OUT.bag KIND

FOLDER has intrinsics.txt (width height fx fy cx cy), <stamp>.raw (depth in millimetres, 16 bit) and, if there is an
odometry, odometry.txt (TUM). KIND: uint16, float, compressed, compressed_depth, realsense, colour, big_endian, short,
no_camera, lens, fisheye, imu.
"""
import array
import pathlib
import struct
import sys
import zlib

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, Imu
from std_msgs.msg import Float32
from tf2_msgs.msg import TFMessage

LATENCY = rospy.Duration(0.05)  # from when an image was taken to when it was written
UNIT = 0.0005                   # of a RealSense whose user has chosen it [m]

folder, out, kind = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]
width, height, fx, fy, cx, cy = map(float, (folder / "intrinsics.txt").read_text().split())
width, height = int(width), int(height)


def png(values):
    rows = b"".join(b"\0" + struct.pack(f">{width}H", *values[width * v:width * (v + 1)]) for v in range(height))

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def image(time, values):
    if kind == "compressed_depth":
        message = CompressedImage(format="16UC1; compressedDepth", data=struct.pack("<iff", 0, 0, 0) + png(values))
        message.header.stamp = time
        return message
    message = Image(width=width, height=height, encoding="16UC1", step=2 * width)
    message.header.stamp = time
    message.header.frame_id = "depth_optical_frame" if kind == "imu" else ""
    if kind == "float":
        message.encoding, message.step = "32FC1", 4 * width
        values = array.array("f", [v / 1000 if v else float("nan") for v in values])
    elif kind == "realsense":
        message.encoding = "mono16"
        values = array.array("H", [round(v / 1000 / UNIT) for v in values])
    elif kind == "colour":
        message.encoding, message.step = "rgb8", 3 * width
        values = array.array("B", [0] * (3 * width * height))
    message.data = values.tobytes()
    message.is_bigendian = kind == "big_endian"
    if kind == "short":
        message.data = message.data[:-1]
    return message


base = "/device_0/sensor_0/Depth_0" if kind == "realsense" else "/camera/depth"
images = base + ("/image/data" if kind == "realsense" else "/image_raw")
if kind == "compressed_depth":
    images += "/compressedDepth"
with rosbag.Bag(out, "w", compression="bz2" if kind == "compressed" else "none") as bag:
    files = sorted(folder.glob("*.raw"), key=lambda file: float(file.stem))
    for file in files:
        time = rospy.Time.from_sec(float(file.stem))
        values = array.array("H", file.read_bytes())
        bag.write(images, image(time, values), time + LATENCY)
        if kind == "imu":  # at rest, held like the camera
            imu = Imu()
            imu.header.stamp, imu.header.frame_id = time, "imu_optical_frame"
            imu.linear_acceleration.y = -9.81
            bag.write("/imu", imu, time + LATENCY)
        grey = Image(width=1, height=1, encoding="mono8", step=1, data=b"\0")
        bag.write("/camera/color/image_raw", grey, time + LATENCY)
    if kind != "no_camera":
        info = CameraInfo(width=width, height=height, K=[fx, 0, cx, 0, fy, cy, 0, 0, 1])
        if kind in ("lens", "fisheye"):
            info.distortion_model = "plumb_bob" if kind == "lens" else "equidistant"
            info.D = [0.1, -0.02, 0.001, 0.002, 0.0] if kind == "lens" else [0.1, 0, 0, 0]
        bag.write(base + ("/info/camera_info" if kind == "realsense" else "/camera_info"), info, time + LATENCY)
    if kind == "realsense":
        bag.write("/device_0/sensor_0/option/Depth Units/value", Float32(UNIT), time + LATENCY)
    odometry = folder / "odometry.txt"
    lines = odometry.read_text().splitlines() if odometry.exists() else []
    for line in lines:
        if line.startswith("#"):
            continue
        stamp, *pose = map(float, line.split())
        time = rospy.Time.from_sec(stamp)
        if kind == "compressed":
            t = TransformStamped()
            t.header.stamp, t.header.frame_id, t.child_frame_id = time, "odom", "base_link"
            position, rotation = t.transform.translation, t.transform.rotation
            message, topic = TFMessage([t]), "/tf"
        else:
            message, topic = Odometry(), "/odom"
            message.header.stamp = time
            position, rotation = message.pose.pose.position, message.pose.pose.orientation
        position.x, position.y, position.z, rotation.x, rotation.y, rotation.z, rotation.w = pose
        bag.write(topic, message, time + LATENCY)
