# SPDX-License-Identifier: BSD-3-Clause
"""apps/ros without ROS: both APIs are faked (fake_ros.py), and facetloc_live by a script, but for the last test."""
import json
import os
import pathlib
import runpy
import sys
import time
import types
import xml.etree.ElementTree as xml

import fake_ros
import numpy as np
import pytest

import facetloc

PACKAGE = (pathlib.Path(os.environ["FACETLOC_EXAMPLES"]) / "../ros").resolve()
TOOLS = pathlib.Path(os.environ["FACETLOC_TOOLS"])
LIVE = """#!{python}
import json, sys
answers, log = iter({answers!r}), open({log!r}, "a")
for line in iter(sys.stdin.buffer.readline, b""):
    header = json.loads(line)
    if "width" in header:
        header["pixels"] = sys.stdin.buffer.read(2 * header["width"] * header["height"]).hex()
    print(json.dumps(header), file=log, flush=True)
    if "width" in header:
        print(json.dumps(dict(next(answers), stamp=header["stamp"])), flush=True)
"""


def rotation(v):
    """exp of rotation vectors (..., 3), by Rodrigues."""
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(np.asarray(v, float), -1, 0)
    K = np.stack([0 * x, -z, y, z, 0 * x, -x, -y, x, 0 * x], axis=-1).reshape(*np.shape(x), 3, 3)
    return np.eye(3) + np.sinc(angle / np.pi) * K + np.sinc(angle / 2 / np.pi)**2 / 2 * K @ K


def pose(v, t):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(np.array(v, float)), t
    return T


def quaternion(T):
    """x y z w of a rotation that is no half turn."""
    R = T[:3, :3]
    w = np.sqrt(1 + np.trace(R)) / 2
    return [*(np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (4 * w)), w]


def matrix(p, q):
    v = np.array([q.x, q.y, q.z])
    length = np.linalg.norm(v)
    return pose(2 * np.arctan2(length, q.w) * v / length if length else v, [p.x, p.y, p.z])


def sampled(P, T, moved, swap):
    """Covariance of the pose moved(T), by samples of T's errors (exp(phi) R, t + dt), rotation first in and, with swap, position first out."""
    errors = np.random.default_rng(1).multivariate_normal(np.zeros(6), P, 20000)
    others = np.repeat(T[None], len(errors), axis=0)
    others[:, :3, :3], others[:, :3, 3] = rotation(errors[:, :3]) @ T[:3, :3], T[:3, 3] + errors[:, 3:]
    R = moved(others)[:, :3, :3] @ moved(T)[:3, :3].T
    phi = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
    dt = moved(others)[:, :3, 3] - moved(T)[:3, 3]
    return np.cov(np.hstack([dt, phi] if swap else [phi, dt]).T)


def agree(P, Q):
    """To the statistics of the samples, in units of the standard deviations."""
    s = np.sqrt(np.diag(Q))
    assert np.all(np.abs(P - Q) < 0.05 * np.outer(s, s))


A = np.random.default_rng(3).normal(size=(6, 6))
COVARIANCE = np.diag([0.02, 0.03, 0.01, 0.1, 0.2, 0.05]) @ (A @ A.T / 6 + np.eye(6)) @ np.diag([0.02, 0.03, 0.01, 0.1, 0.2, 0.05])
T_B_C = pose([-1.2, 1.1, -1.3], [0.3, -0.1, 0.8])  # the camera on its base
T_W_C = pose([0.4, -1, 0.9], [3, 5, 1])


def answer(state="sure", part="", T=T_W_C):
    return {"state": state, "part": part, "probability": 0.99, "not_in_map": 0, "reason": "" if state == "sure" else "a bare wall",
            "T_w_c": {"position": list(T[:3, 3]), "quaternion": quaternion(T)}, "covariance": list(COVARIANCE[np.triu_indices(6)])}


class Robot:
    """A camera of 4x3 pixels on a robot with odometry; publishers offer what drivers do."""

    def __init__(self, version, monkeypatch, folder, answers=(), parameters=None, live=None):
        self.log = folder / "log.jsonl"
        self.log.touch()
        if live is None:
            live = folder / "live"
            live.write_text(LIVE.format(python=sys.executable, answers=list(answers), log=str(self.log)))
            live.chmod(0o755)
        monkeypatch.setenv("FACETLOC_LIVE", str(live))
        monkeypatch.syspath_prepend(str(PACKAGE))
        self.bus = fake_ros.Bus({"map": "x.flmap", **(parameters or {})}, {"depth": "/camera/depth/image_rect_raw"})
        self.messages = (fake_ros.rclpy if version == 2 else fake_ros.rospy)(monkeypatch, self.bus)
        self.version, self.publishers, self.got = version, {}, {}
        self.tf(None, "base_footprint", "mast", pose([0, 0, 0], [0, 0, 0.5]))
        self.tf(None, "mast", "camera", np.linalg.inv(pose([0, 0, 0], [0, 0, 0.5])) @ T_B_C)
        if version == 2:
            from facetloc_ros.ros2 import Ros2 as Ros
        else:
            from facetloc_ros.ros1 import Ros1 as Ros
        from facetloc_ros.localization import Localization
        for topic, kind in (("/pose", "PoseWithCovarianceStamped"), ("/tf", "TFMessage"), ("/diagnostics", "DiagnosticArray")):
            self.listen(topic, kind)
        self.ros = Ros("facetloc")
        self.node = Localization(self.ros)
        self.bus.run()

    def listen(self, topic, kind, latched=False):
        self.got[topic] = []
        self.bus.subscribe(self.got[topic].append, kind=self.messages[kind], topic=topic, reliable=True, latched=latched)

    def stamp(self, seconds):
        seconds, nanoseconds = divmod(round(1e9 * seconds), 10**9)
        return fake_ros.Stamp2(sec=seconds, nanosec=nanoseconds) if self.version == 2 else fake_ros.Stamp1(seconds, nanoseconds)

    def seconds(self, stamp):
        return stamp.sec + 1e-9 * stamp.nanosec if self.version == 2 else stamp.to_sec()

    def publish(self, topic, message, reliable=False, latched=False):
        if topic not in self.publishers:
            self.publishers[topic] = self.bus.advertise(10, kind=type(message), topic=topic, reliable=reliable, latched=latched)
        self.publishers[topic].publish(message)
        self.bus.run()

    def tf(self, stamp, parent, child, T):
        t = self.messages["TransformStamped"](child_frame_id=child)
        t.header.frame_id, t.header.stamp = parent, self.stamp(stamp or 0)
        for v, names, numbers in ((t.transform.translation, "xyz", T[:3, 3]), (t.transform.rotation, "xyzw", quaternion(T))):
            for name, number in zip(names, numbers):
                setattr(v, name, float(number))
        self.publish("/tf_static" if stamp is None else "/tf", self.messages["TFMessage"](transforms=[t]), reliable=True, latched=stamp is None)

    def info(self, latched=False, **changed):
        K, P = [2.0, 0, 1.5, 0, 2.0, 1.0, 0, 0, 1.0], [2.5, 0, 1.5, 0, 0, 2.5, 1.0, 0, 0, 0, 1.0, 0]
        capital = str.upper if self.version == 1 else str
        values = {"width": 4, "height": 3, capital("k"): [float(k) for k in K], capital("p"): [float(p) for p in P], **changed}
        self.publish("/camera_info", self.messages["CameraInfo"](**values), reliable=latched, latched=latched)

    def image(self, stamp, depth=None, **changed):
        depth = np.full((3, 4), 1500, "<u2") if depth is None else depth
        image = self.messages["Image"](width=depth.shape[1], height=depth.shape[0], encoding="16UC1", step=depth.itemsize * depth.shape[1],
                                       data=depth.tobytes(), **changed)
        image.header.stamp, image.header.frame_id = self.stamp(stamp), "camera"
        self.publish("/camera/depth/image_rect_raw", image)

    def start(self, T, covariance, frame="map"):
        message = self.messages["PoseWithCovarianceStamped"]()
        message.header.frame_id = frame
        p, q = message.pose.pose.position, message.pose.pose.orientation
        p.x, p.y, p.z = (float(c) for c in T[:3, 3])
        q.x, q.y, q.z, q.w = (float(c) for c in quaternion(T))
        message.pose.covariance = [float(c) for c in np.ravel(covariance)]
        self.publish("/initialpose", message, reliable=True)

    def sent(self):
        return [json.loads(line) for line in self.log.read_text().splitlines()]

    def wait(self, condition, seconds=20):
        """Until it holds, while messages arrive."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.bus.run()
            if condition():
                return True
            time.sleep(0.01)
        return False

    def answered(self, state):
        return self.wait(lambda: self.node.answer is not None and self.node.answer["state"] == state)

    def diagnosis(self):
        self.node.reported_at = -1.0
        self.node.tick()
        self.bus.run()
        status = self.got["/diagnostics"][-1].status[0]
        return status, {v.key: v.value for v in status.values}


@pytest.fixture(params=[1, 2], ids=["ros1", "ros2"])
def robot(request, monkeypatch, tmp_path):
    made = []

    def make(*arguments, **named):
        made.append(Robot(request.param, monkeypatch, tmp_path, *arguments, **named))
        return made[-1]
    yield make
    for one in made:
        one.node.stop()


def test_a_sure_pose_is_of_the_base_and_corrects_the_odometry(robot):
    r = robot([answer()])
    r.info()
    T_o_b = [pose([0, 0, 0.1 * i], [i, 2, 0]) for i in range(3)]
    r.tf(10, "odom", "base_footprint", T_o_b[0])
    r.image(10.05)
    assert r.wait(lambda: r.got["/pose"])
    assert not [t for m in r.got["/tf"] for t in m.transforms if t.child_frame_id == "odom"], "odometry of that time is not known yet"
    r.tf(10.1, "odom", "base_footprint", T_o_b[1])

    out, T_w_b = r.got["/pose"][0], T_W_C @ np.linalg.inv(T_B_C)
    assert out.header.frame_id == "map" and abs(r.seconds(out.header.stamp) - 10.05) < 1e-6
    np.testing.assert_allclose(matrix(out.pose.pose.position, out.pose.pose.orientation), T_w_b, atol=1e-9)
    P = np.array(out.pose.covariance).reshape(6, 6)
    agree(P, sampled(COVARIANCE, T_W_C, lambda T: T @ np.linalg.inv(T_B_C), swap=True))

    correction, = [t for m in r.got["/tf"] for t in m.transforms if t.child_frame_id == "odom"]
    assert correction.header.frame_id == "map" and abs(r.seconds(correction.header.stamp) - 11.05) < 1e-6
    T_map_odom = matrix(correction.transform.translation, correction.transform.rotation)
    np.testing.assert_allclose(T_map_odom @ pose([0, 0, 0.05], [0.5, 2, 0]), T_w_b, atol=1e-4)

    r.listen("/amcl_pose", "PoseWithCovarianceStamped", latched=True)  # late, as a page that is opened later
    assert r.wait(lambda: r.got["/amcl_pose"])
    flat = r.got["/amcl_pose"][0]
    p, q = flat.pose.pose.position, flat.pose.pose.orientation
    assert (p.x, p.y, p.z, q.x, q.y) == (out.pose.pose.position.x, out.pose.pose.position.y, 0, 0, 0)
    assert abs(2 * np.arctan2(q.z, q.w) - np.arctan2(T_w_b[1, 0], T_w_b[0, 0])) < 1e-9
    Q = np.array(flat.pose.covariance).reshape(6, 6)
    planar, others = [0, 1, 5], [2, 3, 4]
    assert np.array_equal(Q[np.ix_(planar, planar)], P[np.ix_(planar, planar)]) and not Q[others].any() and not Q[:, others].any()


def test_publishes_nothing_while_it_is_not_sure(robot):
    r = robot([answer(), answer("doubtful"), answer("unknown"), answer(part="cellar")])
    r.info()
    for i in range(60):
        r.tf(10 + i / 10, "odom", "base_footprint", pose([0, 0, 0], [i / 10, 0, 0]))
    r.image(10)
    assert r.wait(lambda: r.got["/pose"])
    published = len(r.got["/pose"]), len(r.got["/tf"])
    for i, state in enumerate(("doubtful", "unknown", "sure"), start=1):
        r.image(10 + i)
        assert r.answered(state)
        status, values = r.diagnosis()
        assert status.level in (i, bytes([i])) if state != "sure" else "cellar" in status.message
        assert values["state"] == state
    r.bus.run()
    assert (len(r.got["/pose"]), len(r.got["/tf"])) == published


def test_without_a_way_to_the_base_nothing_is_published_and_the_cause_is_named(robot):
    r = robot([answer()], {"base_frame_id": "base_link"})
    r.info()
    r.image(10)
    assert r.answered("sure")
    status, _ = r.diagnosis()
    assert "tf does not lead from camera to base_link" in status.message and not r.got["/pose"]
    r.tf(None, "base_link", "base_footprint", np.eye(4))
    assert r.wait(lambda: r.got["/pose"])


def test_a_camera_in_the_hand_has_no_base(robot):
    r = robot([answer()], {"base_frame_id": ""})
    r.info()
    r.image(10)
    assert r.wait(lambda: r.got["/pose"])
    p = r.got["/pose"][0].pose.pose
    np.testing.assert_allclose(matrix(p.position, p.orientation), T_W_C, atol=1e-9)


def test_an_initial_pose_keeps_its_covariance(robot):
    r = robot(2 * [answer()])
    r.info()
    T_w_b = pose([0, 0, 1.2], [2, 1, 0])
    first = [3, 4, 5, 0, 1, 2]
    r.start(T_w_b, COVARIANCE[np.ix_(first, first)])
    assert not r.sent(), "waits for the image that it applies to"
    r.image(10)
    assert r.wait(lambda: len(r.sent()) == 2)
    start, T_w_c = r.sent()[0]["pose"], T_w_b @ T_B_C
    np.testing.assert_allclose(start["T_w_c"]["position"], T_w_c[:3, 3], atol=1e-9)
    P = np.zeros((6, 6))
    P[np.triu_indices(6)] = start["covariance"]
    agree(P + np.triu(P, 1).T, sampled(COVARIANCE, T_w_b, lambda T: T @ T_B_C, swap=False))

    r.start(T_w_b, np.diag([0.25, 0.25, 0, 0, 0, 0.0685]))  # as RViz says it
    r.image(11)
    assert r.wait(lambda: len(r.sent()) == 4)
    P = np.zeros((6, 6))
    P[np.triu_indices(6)] = r.sent()[2]["pose"]["covariance"]
    assert np.linalg.eigvalsh(P + np.triu(P, 1).T)[0] > 0
    assert abs(P[2, 2] - 0.0685) < 1e-9 and abs(P[0, 0] - np.radians(30)**2) < 1e-9


@pytest.mark.parametrize("frame, covariance, words", [("odom", np.eye(6), "'odom'"), ("map", -np.ones((6, 6)) + np.eye(6), "ignored")])
def test_an_impossible_initial_pose_is_ignored_with_a_word(robot, frame, covariance, words):
    r = robot([answer()])
    r.info()
    r.start(np.eye(4), covariance + 2 * np.diag(6 * [frame == "map"]) * 0.4, frame)
    r.image(10)
    assert r.wait(lambda: r.sent())
    assert "pose" not in r.sent()[0] and words in r.bus.logged[0]


def test_an_initial_pose_may_be_a_parameter_as_of_amcl(robot):
    r = robot([answer()], {"set_initial_pose": True, "initial_pose.x": 4.0, "initial_pose.yaw": 0.5})
    r.info()
    r.image(10)
    assert r.wait(lambda: len(r.sent()) == 2)
    np.testing.assert_allclose(r.sent()[0]["pose"]["T_w_c"]["position"], (pose([0, 0, 0.5], [4, 0, 0]) @ T_B_C)[:3, 3], atol=1e-9)


def test_services_start_a_global_search(robot):
    r = robot()
    for name in ("/reinitialize_global_localization", "/global_localization")[:3 - r.version]:
        r.bus.services[name]()
    assert r.wait(lambda: len(r.sent()) == 3 - r.version) and r.sent()[0] == {"relocalize": True}


@pytest.mark.parametrize("latched", [False, True])
def test_images_before_camera_info_are_counted(robot, latched):
    r = robot([answer()])
    r.image(10)
    r.image(10.1)
    status, values = r.diagnosis()
    assert "/camera_info" in status.message and values["images before camera_info"] == "2" and status.level in (1, b"\1")
    r.info(latched)  # with each image at best effort, or once and latched
    r.image(10.2)
    assert r.wait(lambda: r.sent())
    header, = r.sent()
    assert (header["stamp"], header["fx"], header["cx"]) == (10.2, 2.5, 1.5), "P, as the images are rectified"
    assert r.answered("sure") and r.diagnosis()[1]["images"] == "3"


def test_a_latched_camera_info_of_before_the_start_is_received(monkeypatch, tmp_path):
    r = Robot(2, monkeypatch, tmp_path, [answer()])
    r.info(latched=True)
    r.node.stop()
    from facetloc_ros.localization import Localization
    r.node = Localization(type(r.ros)("facetloc"))
    r.bus.run()
    assert r.node.info is not None and r.node.frames.transform("base_footprint", "camera", 0) is not None
    r.node.stop()


def test_odometry_may_come_by_a_topic_in_place_of_tf(robot):
    r = robot(2 * [answer()], {"odom_topic": "wheel/odom"})
    r.info()
    r.image(9)
    assert r.wait(lambda: r.sent())
    T_o_b = pose([0, 0, 1], [5, 0, 0])
    r.tf(10, "odom", "base_footprint", np.eye(4))  # not asked for
    odometry = r.messages["Odometry"](child_frame_id="base_footprint")
    odometry.header.stamp, odometry.header.frame_id = r.stamp(10), "odom"
    odometry.pose.pose.position.x = 5.0
    odometry.pose.pose.orientation.z, odometry.pose.pose.orientation.w = float(np.sin(0.5)), float(np.cos(0.5))
    r.publish("/wheel/odom", odometry)
    assert r.wait(lambda: len(r.sent()) == 2)
    assert r.sent()[1]["stamp"] == 10
    np.testing.assert_allclose(r.sent()[1]["T_w_c"]["position"], (T_o_b @ T_B_C)[:3, 3], atol=1e-9)


@pytest.mark.parametrize("encoding, kind, big", [("16UC1", "<u2", 0), ("mono16", ">u2", 1), ("32FC1", "<f4", 0), ("32FC1", ">f4", 1)])
def test_depth_of_all_encodings_arrives_as_millimetres(robot, encoding, kind, big):
    r = robot([answer()])
    r.info()
    millimetres = np.arange(12).reshape(3, 4) * 100
    depth = (millimetres if kind[1] == "u" else np.where(millimetres, millimetres / 1000, np.nan)).astype(kind)
    padded = np.zeros((3, 6), kind)
    padded[:, :4] = depth
    image = r.messages["Image"](width=4, height=3, encoding=encoding, is_bigendian=big, step=padded.strides[0], data=padded.tobytes())
    image.header.stamp, image.header.frame_id = r.stamp(10), "camera"
    r.publish("/camera/depth/image_rect_raw", image)
    assert r.wait(lambda: r.sent())
    assert np.array_equal(np.frombuffer(bytes.fromhex(r.sent()[0]["pixels"]), "<u2").reshape(3, 4), millimetres)


def test_what_cannot_be_read_is_named(robot):
    r = robot([answer()])
    for changed, words in ({"width": 8}, "4x3 pixels, camera_info of 8x3"), ({"p" if r.version == 2 else "P": 12 * [0.0]}, "calibrate"):
        r.info(**changed)
        r.image(10)
        assert words in r.diagnosis()[0].message
    r.info(binning_x=2, binning_y=2, width=8, height=6)
    r.image(10)
    assert r.wait(lambda: r.sent()) and r.sent()[0]["fx"] == 1.25
    color = r.messages["Image"](width=4, height=3, encoding="rgb8", step=12, data=bytes(36))
    r.publish("/camera/depth/image_rect_raw", color)
    assert "rgb8" in r.diagnosis()[0].message


def test_the_lens_of_images_that_are_not_rectified():
    sys.path.insert(0, str(PACKAGE))
    from facetloc_ros.localization import optics
    roi = types.SimpleNamespace(x_offset=0, y_offset=0, width=0, height=0)
    info = types.SimpleNamespace(k=[2.0, 0, 1.5, 0, 2.0, 1.0, 0, 0, 1], p=12 * [0.0], d=[0.1, 0, 0.2, 0, 0], distortion_model="plumb_bob", width=4,
                                 height=3, binning_x=0, binning_y=0, roi=roi)
    image = types.SimpleNamespace(width=4, height=3)
    assert optics(info, image, False) == {"fx": 2, "fy": 2, "cx": 1.5, "cy": 1, "k1": 0.1, "p1": 0.2}
    info.distortion_model = "equidistant"
    with pytest.raises(ValueError, match="equidistant"):
        optics(info, image, False)


def test_the_package_is_whole(monkeypatch):
    from facetloc_ros.localization import PARAMETERS
    yaml = pytest.importorskip("yaml", reason="python3-yaml is not installed")
    given = yaml.safe_load((PACKAGE / "config/localization.yaml").read_text())["facetloc"]["ros__parameters"]
    given.update({"initial_pose." + name: value for name, value in given.pop("initial_pose").items()})
    assert given == PARAMETERS
    assert xml.parse(PACKAGE / "package.xml").findtext("version") in (PACKAGE / "setup.py").read_text()

    def recorded(name):
        return lambda *values, **named: (name, values, named)
    fake_ros.install(monkeypatch, {
        "ament_index_python.packages": {"get_package_share_directory": lambda name: f"/share/{name}"},
        "launch": {"LaunchDescription": list}, "launch.actions": {"DeclareLaunchArgument": recorded("argument")},
        "launch.substitutions": {"LaunchConfiguration": lambda name: "$" + name}, "launch_ros.actions": {"Node": recorded("node")}})
    *arguments, node = runpy.run_path(str(PACKAGE / "launch/localization.launch.py"))["generate_launch_description"]()
    declared = {values[0]: named["default_value"] for _, values, named in arguments}
    assert declared["params_file"] == "/share/facetloc_ros/config/localization.yaml" and (PACKAGE / "config/localization.yaml").exists()
    assert (PACKAGE / "scripts" / node[2]["executable"]).exists() and node[2]["package"] == "facetloc_ros"
    assert set(node[2]["parameters"][1]) <= {*PARAMETERS, "use_sim_time"} and [a for a, _ in node[2]["remappings"]] == ["depth", "camera_info"]


def test_a_drive_is_followed_by_facetloc_live(robot, tmp_path):
    drive = facetloc.simulate("room", seed=5, frames=24)
    making = facetloc.MapMaking(drive.camera)
    for frame in drive:
        making.add(frame.depth, frame.stamp, T_w_c=frame.T_w_c)
    making.finish().save(tmp_path / "room.flmap")
    r = robot(parameters={"map": str(tmp_path / "room.flmap"), "options": "--every-frame"}, live=TOOLS / "facetloc_live")
    c = drive.camera
    r.info(width=c.width, height=c.height, **{"p" if r.version == 2 else "P": [c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0]})
    poses = facetloc.simulate("room", seed=5, frames=24)
    for i, frame in enumerate(poses):
        r.tf(100 + i, "odom", "base_footprint", np.linalg.inv(poses[0].T_w_c @ np.linalg.inv(T_B_C)) @ frame.T_w_c @ np.linalg.inv(T_B_C))
        r.image(100 + i, np.round(1000 * frame.depth).astype("<u2"))
    assert r.wait(lambda: r.node.answer is not None and r.node.answer["stamp"] == 123)
    r.bus.run()
    assert len(r.got["/pose"]) > 12
    for out in r.got["/pose"]:
        T = matrix(out.pose.pose.position, out.pose.pose.orientation)
        true = poses[round(r.seconds(out.header.stamp)) - 100].T_w_c @ np.linalg.inv(T_B_C)
        assert np.linalg.norm(T[:3, 3] - true[:3, 3]) < 0.2
    assert len([t for m in r.got["/tf"] for t in m.transforms if t.child_frame_id == "odom"]) > 12
