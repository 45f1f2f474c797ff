#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Localization of a depth camera as a node of ROS 1 (rospy) or ROS 2 (rclpy), whichever is installed.

Tested with ROS 1 as Debian 12 has it (python3-rospy); the part for ROS 2, class Ros2, has not been run yet.

    ros_node.py _map:=office.flmap depth:=/camera/depth/image_rect_raw        ROS 1
    ros_node.py --ros-args -p map:=office.flmap -r depth:=/camera/...         ROS 2

In: depth (sensor_msgs/Image, 16UC1 or 32FC1), camera_info, odom (nav_msgs/Odometry), initialpose, tf_static with the camera on the
base. Out: pose (PoseWithCovarianceStamped, of the base; of the camera if tf_static does not say where it is), tf map -> odom,
diagnostics; service relocalize (std_srvs/Empty). Parameters: map, map_frame, options (of facetloc_live, such as "--camera camera.ini").
Poses are published only if they are sure."""
import collections
import json
import os
import shlex
import subprocess
import sys
import threading

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

try:
    import rospy
    from std_srvs.srv import Empty, EmptyResponse
except ImportError:
    rospy = None
    import rclpy
    import rclpy.time
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_srvs.srv import Empty

class Ros1:
    def __init__(self, name):
        rospy.init_node(name)
        self.log = rospy.logwarn
    def parameter(self, name, default):
        return rospy.get_param("~" + name, default)
    def subscribe(self, kind, topic, callback, latched=False):
        rospy.Subscriber(topic, kind, callback, queue_size=100 if latched else 10, buff_size=1 << 24)
    def resolved(self, topic):
        return rospy.resolve_name(topic)
    def publisher(self, kind, topic):
        return rospy.Publisher(topic, kind, queue_size=10)
    def service(self, name, act):
        self.served = rospy.Service(name, Empty, lambda _: (act(), EmptyResponse())[1])
    def seconds(self, stamp):
        return stamp.to_sec()
    def stamp(self, seconds):
        return rospy.Time.from_sec(seconds)
    def spin(self, ended):
        while not rospy.is_shutdown() and not ended():
            rospy.rostime.wallsleep(0.1)

class Ros2:
    def __init__(self, name):
        rclpy.init()
        self.node = rclpy.create_node(name)
        self.log = self.node.get_logger().warning
    def parameter(self, name, default):
        return self.node.declare_parameter(name, default).value
    def subscribe(self, kind, topic, callback, latched=False):
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        self.node.create_subscription(kind, topic, callback, QoSProfile(depth=100 if latched else 10, durability=durability))
    def resolved(self, topic):
        return self.node.resolve_topic_name(topic)
    def publisher(self, kind, topic):
        return self.node.create_publisher(kind, topic, 10)
    def service(self, name, act):
        self.node.create_service(Empty, name, lambda _, response: (act(), response)[1])
    def seconds(self, stamp):
        return stamp.sec + 1e-9 * stamp.nanosec
    def stamp(self, seconds):
        return rclpy.time.Time(nanoseconds=round(1e9 * seconds)).to_msg()
    def spin(self, ended):
        while rclpy.ok() and not ended():
            rclpy.spin_once(self.node, timeout_sec=0.1)

def matrix(position, q):  # of numbers, quaternion x y z w
    x, y, z, w = np.asarray(q, float) / np.linalg.norm(q)
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = position
    return T

def xyz(v):
    return [v.x, v.y, v.z]

def xyzw(q):
    return [q.x, q.y, q.z, q.w]

def quaternion(R):  # by its largest component, x y z w
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]])
    return [float(c) for c in np.linalg.eigh(K)[1][:, 3]]  # of the lower triangle

def as_json(T):
    return {"position": [float(c) for c in T[:3, 3]], "quaternion": quaternion(T[:3, :3])}

def fill(to_position, to_rotation, T):
    to_position.x, to_position.y, to_position.z = (float(c) for c in T[:3, 3])
    to_rotation.x, to_rotation.y, to_rotation.z, to_rotation.w = quaternion(T[:3, :3])

def moved(upper, lever):  # the stream's covariance for a point that lies elsewhere on the robot, in the order of ROS
    P = np.zeros((6, 6))
    P[np.triu_indices(6)] = upper
    P += np.triu(P, 1).T
    J = np.eye(6)  # an error of the rotation moves the point
    J[3:, :3] = -np.array([[0, -lever[2], lever[1]], [lever[2], 0, -lever[0]], [-lever[1], lever[0], 0]])
    P = J @ P @ J.T
    return P[np.ix_([3, 4, 5, 0, 1, 2], [3, 4, 5, 0, 1, 2])].ravel().tolist()

class Node:
    def __init__(self, ros):
        self.ros, self.lock = ros, threading.Lock()
        self.info, self.camera_frame, self.odom_frame, self.base_frame, self.T_map_odom = None, "", "", "", None
        self.static, self.odometry, self.told = {}, collections.deque(maxlen=1000), None
        self.map_frame = ros.parameter("map_frame", "map")
        command = [os.environ.get("FACETLOC_LIVE", "facetloc_live"), "--device", "-", "--map", ros.parameter("map", ""), "--headless",
                   "--stream", "--wait", *shlex.split(ros.parameter("options", ""))]
        self.live = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.pose, self.tf = ros.publisher(PoseWithCovarianceStamped, "pose"), ros.publisher(TFMessage, "/tf")
        self.diagnostics = ros.publisher(DiagnosticArray, "/diagnostics")
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()
        ros.subscribe(TFMessage, "/tf_static", self.on_static, latched=True)
        ros.subscribe(CameraInfo, "camera_info", lambda info: setattr(self, "info", info))
        ros.subscribe(Odometry, "odom", self.on_odometry)
        ros.subscribe(PoseWithCovarianceStamped, "initialpose", self.on_start)
        ros.subscribe(Image, "depth", self.on_image)
        ros.service("relocalize", lambda: self.send({"relocalize": True}))

    def send(self, header, pixels=b""):
        try:
            with self.lock:
                self.live.stdin.write(json.dumps(header).encode() + b"\n" + pixels)
                self.live.stdin.flush()
        except BrokenPipeError:
            pass  # spin() ends

    def on_static(self, message):
        for t in message.transforms:
            self.static[t.child_frame_id] = t.header.frame_id, matrix(xyz(t.transform.translation), xyzw(t.transform.rotation))

    def base_to_camera(self):  # None where tf_static does not lead from one to the other
        frame, T = self.camera_frame, np.eye(4)
        for _ in range(len(self.static) + 1):
            if frame == (self.base_frame or "base_link"):
                return T
            if frame not in self.static:
                return None
            frame, step = self.static[frame]
            T = step @ T
        return None

    def on_odometry(self, message):
        self.odom_frame, self.base_frame = message.header.frame_id, message.child_frame_id
        T_o_b, stamp = matrix(xyz(message.pose.pose.position), xyzw(message.pose.pose.orientation)), self.ros.seconds(message.header.stamp)
        self.odometry.append((stamp, T_o_b))
        T_b_c = self.base_to_camera()
        if T_b_c is not None:
            self.send({"stamp": stamp, "T_w_c": as_json(T_o_b @ T_b_c)})

    def on_start(self, message):
        T_b_c = self.base_to_camera()
        T_w_b = matrix(xyz(message.pose.pose.position), xyzw(message.pose.pose.orientation))
        self.send({"pose": {"T_w_c": as_json(T_w_b @ (np.eye(4) if T_b_c is None else T_b_c))}})

    def on_image(self, message):
        if self.info is None:
            return
        kinds = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
        if message.encoding not in kinds:
            self.ros.log(f"depth images of {message.encoding} are not known, only of {', '.join(kinds)}")
            return
        kind = np.dtype((">" if message.is_bigendian else "<") + kinds[message.encoding])
        rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)[:, :message.width * kind.itemsize]
        depth = np.ascontiguousarray(rows).view(kind)
        if kind.kind == "f":  # metres
            depth = np.where(np.isfinite(depth) & (depth < 65.5), np.round(1000 * np.nan_to_num(depth, posinf=0)), 0)
        self.camera_frame = message.header.frame_id
        self.send({"stamp": self.ros.seconds(message.header.stamp), "width": message.width, "height": message.height, **self.optics()},
                  depth.astype("<u2").tobytes())

    def optics(self):  # of an image without distortion if its topic is called rect...
        K, P, D = (getattr(self.info, n, getattr(self.info, n.lower(), None)) for n in "KPD")
        if "rect" in self.ros.resolved("depth"):
            return dict(zip(("fx", "cx", "fy", "cy"), (float(P[i]) for i in (0, 2, 5, 6))))
        lens = {k: float(d) for k, d in zip(("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"), D) if d}
        return {**dict(zip(("fx", "cx", "fy", "cy"), (float(K[i]) for i in (0, 2, 4, 5)))), **lens}

    def read(self):
        for line in self.live.stdout:
            answer = json.loads(line)
            if "state" in answer:  # not of another kind, such as a finding
                self.tell(answer)

    def tell(self, answer):
        sure = answer["state"] == "sure" and answer["T_w_c"] and not answer["part"]
        T_b_c, stamp = self.base_to_camera(), self.ros.stamp(answer["stamp"])
        if sure:
            T_w_c = matrix(answer["T_w_c"]["position"], answer["T_w_c"]["quaternion"])
            T_w_b = T_w_c if T_b_c is None else T_w_c @ np.linalg.inv(T_b_c)
            out = PoseWithCovarianceStamped()
            out.header.frame_id, out.header.stamp = self.map_frame, stamp
            fill(out.pose.pose.position, out.pose.pose.orientation, T_w_b)
            out.pose.covariance = moved(answer["covariance"], T_w_b[:3, 3] - T_w_c[:3, 3])
            self.pose.publish(out)
            near = min(self.odometry, key=lambda o: abs(o[0] - answer["stamp"]), default=None)
            if near and abs(near[0] - answer["stamp"]) < 0.1 and T_b_c is not None:
                self.T_map_odom = T_w_b @ np.linalg.inv(near[1])
        if self.T_map_odom is not None:  # which odometry carries on while no pose is sure
            t = TransformStamped()
            t.header.frame_id, t.header.stamp, t.child_frame_id = self.map_frame, stamp, self.odom_frame
            fill(t.transform.translation, t.transform.rotation, self.T_map_odom)
            self.tf.publish(TFMessage([t]) if rospy else TFMessage(transforms=[t]))
        if self.told is None or answer["state"] != self.told[0] or not 0 <= answer["stamp"] - self.told[1] < 1:
            self.told = answer["state"], answer["stamp"]
            status = DiagnosticStatus(name="facetloc", message=answer["reason"] or answer["state"], hardware_id=self.camera_frame)
            status.level = {"sure": DiagnosticStatus.OK, "doubtful": DiagnosticStatus.WARN}.get(answer["state"], DiagnosticStatus.ERROR)
            out = DiagnosticArray(status=[status])
            out.header.stamp = stamp
            self.diagnostics.publish(out)

ros = Ros1("facetloc") if rospy else Ros2("facetloc")
node = Node(ros)
try:
    ros.spin(lambda: node.live.poll() is not None)
finally:
    node.live.terminate()
sys.exit(node.live.wait() if node.live.returncode not in (None, 0, -15) else 0)
