# SPDX-License-Identifier: BSD-3-Clause
"""Localization as a robot sees it: images and transforms in, sure poses out. Plain Python: the argument ros, a Ros1 or a Ros2, speaks to
ROS, and the program facetloc_live localizes."""
import json
import os
import shlex
import subprocess
import threading
import time

import numpy as np

from .geometry import Frames, exchanged, moved, planar, pose_matrix, quaternion_of, symmetric

#: Names and defaults of nav2_amcl where it has such a parameter; map, options and odom_topic are ours.
PARAMETERS = {"map": "", "options": "", "odom_topic": "", "base_frame_id": "base_footprint", "global_frame_id": "map",
              "odom_frame_id": "odom", "tf_broadcast": True, "transform_tolerance": 1.0, "set_initial_pose": False,
              "initial_pose.x": 0.0, "initial_pose.y": 0.0, "initial_pose.z": 0.0, "initial_pose.yaw": 0.0}
OK, WARN, ERROR = range(3)
ENCODINGS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
UNSTATED = np.diag(3 * [np.radians(30)**2] + 3 * [1.0])  # covariance of a start that states none, as of facetloc_live


def as_json(T):
    return {"position": [float(c) for c in T[:3, 3]], "quaternion": quaternion_of(T[:3, :3])}


def pose_of(pose):
    """(4, 4) of a geometry_msgs/Pose."""
    p, q = pose.position, pose.orientation
    return pose_matrix([p.x, p.y, p.z], [q.x, q.y, q.z, q.w])


def millimetres(image):
    """The bytes of a sensor_msgs/Image as facetloc_live takes them: 16 bit, little-endian. Raises ValueError for other images."""
    if image.encoding not in ENCODINGS:
        raise ValueError(f"images of the encoding {image.encoding} are no depth images, which are {', '.join(ENCODINGS)}")
    kind = np.dtype((">" if image.is_bigendian else "<") + ENCODINGS[image.encoding])
    if image.step < image.width * kind.itemsize or len(image.data) < image.height * image.step:
        raise ValueError(f"an image has {len(image.data)} bytes, fewer than its size says")
    rows = np.frombuffer(image.data, np.uint8)[:image.height * image.step].reshape(image.height, image.step)
    depth = np.ascontiguousarray(rows[:, :image.width * kind.itemsize]).view(kind)
    if kind.kind == "f":  # metres
        depth = np.where(np.isfinite(depth) & (depth > 0) & (depth < 65.5), np.round(1000 * np.nan_to_num(depth, posinf=0, neginf=0)), 0)
    return depth.astype("<u2").tobytes()


def optics(info, image, rectified):
    """Intrinsics and lens by the keys of camera.ini. rectified: the image has no distortion, and P holds. Raises ValueError if they are not
    those of the image."""
    K, P, D = (getattr(info, name, getattr(info, name.lower(), None)) for name in "KPD")  # in capitals in ROS 1
    fx, cx, fy, cy = (float((P if rectified else K)[i]) for i in ((0, 2, 5, 6) if rectified else (0, 2, 4, 5)))
    if not (fx > 0 and fy > 0):
        raise ValueError("camera_info has no focal length: calibrate the camera")
    roi, bins = info.roi, (max(info.binning_x, 1), max(info.binning_y, 1))
    size = (roi.width or info.width) // bins[0], (roi.height or info.height) // bins[1]
    if size != (image.width, image.height):
        raise ValueError(f"images are of {image.width}x{image.height} pixels, camera_info of {size[0]}x{size[1]}: they are not of one camera")
    keys = {"fx": fx / bins[0], "fy": fy / bins[1], "cx": (cx - roi.x_offset) / bins[0], "cy": (cy - roi.y_offset) / bins[1]}
    if rectified or not any(D):
        return keys
    if info.distortion_model not in ("", "plumb_bob", "rational_polynomial") or any(D[8:]):
        raise ValueError(f"the lens model {info.distortion_model} is not known: rectify the images")
    return {**keys, **{k: float(d) for k, d in zip(("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"), D) if d}}


class Localization:
    def __init__(self, ros):
        self.ros, self.lock, self.sending = ros, threading.RLock(), threading.Lock()
        self.values = {name: ros.parameter(name, default) for name, default in PARAMETERS.items()}
        # Our own transform, and one that odom_topic replaces.
        self.unread = {self.values["global_frame_id"], *([self.values["odom_frame_id"]] if self.values["odom_topic"] else [])}
        self.frames, self.info, self.camera_frame, self.start = Frames(), None, "", None
        self.images = self.images_without_info = 0
        self.answer, self.problem, self.last_sure = None, "", None
        self.unposed, self.uncorrected, self.odometry_sent = None, None, None
        self.reported, self.reported_at = None, -1.0
        if self.values["set_initial_pose"]:
            x, y, z, yaw = (self.values["initial_pose." + name] for name in ("x", "y", "z", "yaw"))
            self.start = pose_matrix([x, y, z], [0, 0, np.sin(yaw / 2), np.cos(yaw / 2)]), UNSTATED
        command = [os.environ.get("FACETLOC_LIVE", "facetloc_live"), "--device", "-", "--map", self.values["map"], "--headless", "--stream",
                   "--wait", *shlex.split(self.values["options"])]
        self.live = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        threading.Thread(target=self.read, daemon=True).start()
        ros.subscribe("TFMessage", "/tf_static", lambda message: self.on_transforms(message, static=True), "latched")
        ros.subscribe("TFMessage", "/tf", self.on_transforms, "reliable")
        for quality in ("sensor", "latched"):  # some drivers send it once, others with each image
            ros.subscribe("CameraInfo", "camera_info", self.on_info, quality)
        if self.values["odom_topic"]:
            ros.subscribe("Odometry", self.values["odom_topic"], self.on_odometry, "sensor")
        ros.subscribe("PoseWithCovarianceStamped", "initialpose", self.on_start, "reliable")
        ros.subscribe("Image", "depth", self.on_image, "image")
        ros.service("reinitialize_global_localization", self.relocalize)

    def send(self, header, pixels=b""):
        try:
            with self.sending:
                self.live.stdin.write(json.dumps(header).encode() + b"\n" + pixels)
                self.live.stdin.flush()
        except BrokenPipeError:
            pass  # tick() reports it

    # What the robot says

    def on_transforms(self, message, static=False):
        for t in message.transforms:
            if t.header.frame_id in self.unread:
                continue
            v, q = t.transform.translation, t.transform.rotation
            self.on_transform(t.header.frame_id, t.child_frame_id, None if static else self.ros.seconds(t.header.stamp), [v.x, v.y, v.z],
                              [q.x, q.y, q.z, q.w])

    def on_odometry(self, message):
        p, q = message.pose.pose.position, message.pose.pose.orientation
        self.on_transform(self.values["odom_frame_id"], message.child_frame_id or self.values["base_frame_id"],
                          self.ros.seconds(message.header.stamp), [p.x, p.y, p.z], [q.x, q.y, q.z, q.w])

    def on_transform(self, parent, child, stamp, position, quaternion):
        try:
            T = pose_matrix(position, quaternion)
        except ValueError as error:
            self.ros.log(f"{parent} -> {child}: {error}")
            return
        with self.lock:
            self.frames.add(parent.lstrip("/"), child.lstrip("/"), stamp, T)
            odom = self.values["odom_frame_id"]
            newest = self.frames.newest(odom, self.camera_frame)
            T_odom_camera = None if newest in (None, self.odometry_sent) else self.frames.transform(odom, self.camera_frame, newest)
            self.publish()
        if T_odom_camera is not None:
            self.odometry_sent = newest
            self.send({"stamp": newest, "T_w_c": as_json(T_odom_camera)})

    def on_info(self, message):
        self.info = message

    def on_start(self, message):
        """The pose applies to the next image from which tf leads to the base."""
        frame, own = message.header.frame_id.lstrip("/"), self.values["global_frame_id"]
        if frame != own:
            self.ros.log(f"an initial pose in the frame '{frame}' is ignored: it has to be in '{own}'")
            return
        P = exchanged(message.pose.covariance)
        unstated = np.diag(P) <= 0  # RViz states x, y and yaw
        P[unstated, :], P[:, unstated] = 0, 0
        P += np.diag(np.where(unstated, np.diag(UNSTATED), 0))
        try:
            T_w_b = pose_of(message.pose.pose)
            np.linalg.cholesky(P)
        except (ValueError, np.linalg.LinAlgError) as error:
            self.ros.log(f"an initial pose is ignored: {error}")
            return
        self.start = T_w_b, P

    def relocalize(self):
        self.start = None
        self.send({"relocalize": True})

    def on_image(self, image):
        self.images += 1
        if self.info is None:
            self.images_without_info += 1
            return
        try:
            pixels, keys = millimetres(image), optics(self.info, image, "rect" in self.ros.resolved("depth"))
        except ValueError as error:
            self.problem = str(error)
            return
        self.problem, self.camera_frame, stamp = "", image.header.frame_id.lstrip("/"), self.ros.seconds(image.header.stamp)
        with self.lock:
            T_b_c = self.base_to_camera(stamp)
        if self.start is not None and T_b_c is not None:
            (T_w_b, P), self.start = self.start, None
            T_w_c = T_w_b @ T_b_c
            P = moved(P, T_w_c[:3, 3] - T_w_b[:3, 3])[np.triu_indices(6)]
            self.send({"pose": {"T_w_c": as_json(T_w_c), "covariance": P.tolist()}})
        self.send({"stamp": stamp, "width": image.width, "height": image.height, **keys}, pixels)

    def base_to_camera(self, stamp):
        """T_b_c at a time; of a static mounting at any; None if tf does not say it."""
        base = self.values["base_frame_id"] or self.camera_frame  # a camera in the hand
        newest = self.frames.newest(base, self.camera_frame)
        return self.frames.transform(base, self.camera_frame, stamp if newest is None else min(stamp, newest))

    # What facetloc_live answers

    def read(self):
        for line in self.live.stdout:
            answer = json.loads(line)
            if "state" in answer:  # not of another kind, such as a finding
                self.on_answer(answer)

    def on_answer(self, answer):
        with self.lock:
            sure = answer["state"] == "sure" and answer["T_w_c"] is not None and not answer["part"]
            self.answer, self.unposed, self.uncorrected = answer, answer if sure else None, None
            if sure:
                self.last_sure = answer["stamp"]
            self.publish()

    def publish(self):
        """The sure pose, and the correction of the odometry as soon as tf knows the odometry of its time. Nothing while it is not sure."""
        if self.unposed is not None:
            answer, stamp = self.unposed, self.unposed["stamp"]
            T_b_c = self.base_to_camera(stamp)
            if T_b_c is not None:
                T_w_c = pose_matrix(answer["T_w_c"]["position"], answer["T_w_c"]["quaternion"])
                T_w_b = T_w_c @ np.linalg.inv(T_b_c)
                P = exchanged(moved(symmetric(answer["covariance"]), T_w_b[:3, 3] - T_w_c[:3, 3]))
                flat = np.zeros((6, 6))
                flat[np.ix_([0, 1, 5], [0, 1, 5])] = P[np.ix_([0, 1, 5], [0, 1, 5])]
                self.ros.publish_pose("pose", stamp, self.values["global_frame_id"], T_w_b, P)
                self.ros.publish_pose("amcl_pose", stamp, self.values["global_frame_id"], planar(T_w_b), flat)
                self.unposed, self.uncorrected = None, (stamp, T_w_b)
        if self.uncorrected is not None and self.values["tf_broadcast"]:
            stamp, T_w_b = self.uncorrected
            odom = self.values["odom_frame_id"]
            T_odom_base = self.frames.transform(odom, self.values["base_frame_id"] or self.camera_frame, stamp)
            if T_odom_base is not None:
                self.uncorrected = None
                self.ros.publish_transform(stamp + self.values["transform_tolerance"], self.values["global_frame_id"], odom,
                                           T_w_b @ np.linalg.inv(T_odom_base))

    # What a supervisor wants to know

    def status(self):
        if self.live.poll() is not None:
            return ERROR, f"facetloc_live has ended with exit code {self.live.returncode}"
        if self.problem:
            return ERROR, self.problem
        if not self.images:
            return WARN, f"no image on {self.ros.resolved('depth')} yet"
        if self.info is None:
            return WARN, f"no message on {self.ros.resolved('camera_info')} yet: {self.images_without_info} images could not be used"
        if self.answer is None:
            return WARN, "no answer yet"
        if self.answer["state"] == "sure" and self.unposed is not None:
            return ERROR, f"sure, but tf does not lead from {self.camera_frame} to {self.values['base_frame_id']}: no pose is published"
        if self.answer["state"] == "sure" and self.answer["part"]:
            return WARN, f"sure in the part {self.answer['part']} of the map, which has no place in {self.values['global_frame_id']}"
        level = {"sure": OK, "doubtful": WARN}.get(self.answer["state"], ERROR)
        return level, self.answer["reason"] or self.answer["state"]

    def tick(self):
        """Reports on a change, else once a second. True while facetloc_live runs."""
        with self.lock:
            level, message = self.status()
            answer, now = self.answer or {}, time.monotonic()
            values = {"state": answer.get("state", ""), "probability": answer.get("probability", ""), "not in map": answer.get("not_in_map", ""),
                      "last sure pose [s]": "" if self.last_sure is None else f"{self.last_sure:.6f}", "images": self.images,
                      "images before camera_info": self.images_without_info,
                      "odometry": "yes" if self.frames.newest(self.values["odom_frame_id"], self.camera_frame) is not None else "no"}
        if level != self.reported or now - self.reported_at >= 1:
            self.reported, self.reported_at = level, now
            self.ros.publish_status(level, "facetloc", message, self.camera_frame, {k: str(v) for k, v in values.items()})
        return self.live.poll() is None

    def stop(self):
        """Exit code: 0 if it was facetloc_live's own end or ours, else facetloc_live's."""
        self.live.terminate()
        return max(self.live.wait(), 0)
