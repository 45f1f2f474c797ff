# SPDX-License-Identifier: BSD-3-Clause
"""apps/ros in a real ROS 1, by its launch file: a bag of a simulated drive is played, poses, tf, diagnostics and services are read back."""
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

import facetloc

rospy = pytest.importorskip("rospy", reason="ROS 1 is not installed (python3-rospy)")
rosbag = pytest.importorskip("rosbag", reason="python3-rosbag is not installed")
pytest.importorskip("std_srvs.srv", reason="python3-std-srvs is not installed")
pytest.importorskip("diagnostic_msgs.msg", reason="python3-diagnostic-msgs is not installed")
for program, package in (("roslaunch", "python3-roslaunch"), ("rosbag", "python3-rosbag")):
    if not shutil.which(program):
        pytest.skip(f"{program} is not installed ({package})", allow_module_level=True)

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped  # noqa: E402
from sensor_msgs.msg import CameraInfo, Image  # noqa: E402
from std_srvs.srv import Empty  # noqa: E402
from tf2_msgs.msg import TFMessage  # noqa: E402

TOOLS = pathlib.Path(os.environ["FACETLOC_TOOLS"])
PACKAGE = pathlib.Path(os.environ["FACETLOC_EXAMPLES"]) / "../ros"
TOPIC = "/camera/depth/image_rect_raw"


def free_port():
    with socket.socket() as s:
        s.bind(("localhost", 0))
        return s.getsockname()[1]


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return False


def matrix(position, rotation):
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = position.x, position.y, position.z
    return T


def set_pose(position, rotation, t, q):
    position.x, position.y, position.z = t
    rotation.x, rotation.y, rotation.z, rotation.w = q


def tum(path):
    return {round(row[0], 6): row[1:] for row in np.loadtxt(path)}


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """A drive through a room in a bag, its map, and where the base truly was."""
    folder = tmp_path_factory.mktemp("ros")
    call = lambda *c: subprocess.run([str(a) for a in c], check=True, capture_output=True)  # noqa: E731
    call(TOOLS / "facetloc_simulate", "room", "-o", folder, "--seed", 5, "--frames", 40, "--width", 320, "--odometry",
         "--drive.turn_deg", 3, "--drive.step", 0.05)
    call(TOOLS / "facetloc_map", "build", folder / "map", "-o", folder / "room.flmap", "--map.distance", 0.2)
    run = folder / "map"
    camera = facetloc.Camera.open(run / "camera.ini")
    odometry = tum(run / "odometry.txt")
    recording = facetloc.Recording.open(run)
    truth = {}
    with rosbag.Bag(str(folder / "drive.bag"), "w") as bag:
        T = TransformStamped(child_frame_id="camera_optical")
        T.header.frame_id = "base_link"
        R = camera.T_b_c[:3, :3]
        q = np.linalg.eigh(np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                                     [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                                     [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]]))[1][:, 3]
        set_pose(T.transform.translation, T.transform.rotation, camera.T_b_c[:3, 3], q)
        bag.write("/tf_static", TFMessage([T]), rospy.Time(1))
        for frame in recording:
            stamp = rospy.Time.from_sec(frame.stamp + 1)
            truth[round(stamp.to_sec(), 6)] = frame.T_w_c @ np.linalg.inv(camera.T_b_c)
            odom = TransformStamped(child_frame_id="base_link")
            odom.header.frame_id, odom.header.stamp = "odom", stamp
            row = odometry[round(frame.stamp, 6)]
            set_pose(odom.transform.translation, odom.transform.rotation, row[:3], row[3:])
            bag.write("/tf", TFMessage([odom]), stamp)
            info = CameraInfo(width=camera.width, height=camera.height)
            info.header.stamp = stamp
            info.P = [camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0]
            bag.write("/camera/depth/camera_info", info, stamp)
            image = Image(width=camera.width, height=camera.height, encoding="16UC1", step=2 * camera.width)
            image.header.stamp, image.header.frame_id = stamp, "camera_optical"
            image.data = np.round(1000 * frame.depth).astype("<u2").tobytes()
            bag.write(TOPIC, image, stamp)
    return folder, truth


@pytest.fixture(scope="module")
def ros(drive):
    folder, _ = drive
    port = free_port()
    os.environ.update(ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost", ROS_HOME=str(folder / "home"),
                      ROS_LOG_DIR=str(folder / "log"))
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def runs():
        with socket.socket() as s:
            return s.connect_ex(("localhost", port)) == 0
    try:
        assert wait_for(runs), "roscore does not start"
        rospy.init_node("test", disable_signals=True)
        environment = dict(os.environ, FACETLOC_LIVE=str(TOOLS / "facetloc_live"),
                           PATH=f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}",  # env python3 is the one with rospy
                           ROS_PACKAGE_PATH=f"{PACKAGE.resolve()}:{os.environ.get('ROS_PACKAGE_PATH', '/usr/share')}")
        node = subprocess.Popen(["roslaunch", "--wait", "facetloc_ros", "localization.launch", f"map:={folder / 'room.flmap'}",
                                 f"depth:={TOPIC}", "camera_info:=/camera/depth/camera_info", "base_frame_id:=base_link",
                                 "options:=--every-frame"], env=environment)
        yield node
        node.terminate()
        node.wait(20)
    finally:
        rospy.signal_shutdown("done")
        core.terminate()
        core.wait(20)


def test_poses_and_transforms_are_right(drive, ros):
    folder, truth = drive
    poses, transforms, diagnostics = [], [], []
    rospy.Subscriber("/pose", PoseWithCovarianceStamped, poses.append)
    rospy.Subscriber("/tf", TFMessage, lambda message: transforms.extend(t for t in message.transforms if t.child_frame_id == "odom"))
    rospy.Subscriber("/diagnostics", DiagnosticArray, diagnostics.append)
    odometry = {}
    with rosbag.Bag(str(folder / "drive.bag")) as bag:
        for _, message, _ in bag.read_messages("/tf"):
            t = message.transforms[0]
            odometry[round(t.header.stamp.to_sec(), 6)] = matrix(t.transform.translation, t.transform.rotation)
    subprocess.run(["rosbag", "play", "--wait-for-subscribers", "--quiet", "-d", "1", str(folder / "drive.bag")], check=True, timeout=120,
                   stdin=subprocess.DEVNULL)
    assert wait_for(lambda: len(poses) >= 30), f"{len(poses)} poses only"
    assert ros.poll() is None

    off = []
    for pose in poses:
        assert pose.header.frame_id == "map"
        T = matrix(pose.pose.pose.position, pose.pose.pose.orientation)
        true = truth[round(pose.header.stamp.to_sec(), 6)]
        R = T[:3, :3] @ true[:3, :3].T
        rotation = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
        error = np.concatenate([T[:3, 3] - true[:3, 3], rotation])
        off.append((np.linalg.norm(error[:3]), np.degrees(np.linalg.norm(rotation))))
        P = np.array(pose.pose.covariance).reshape(6, 6)
        np.linalg.cholesky(P)
        assert P[0, 0] < 0.05, "position first"
        # Which images a busy node receives before their odometry differs from run to run, and with it how well a pose is
        # known; its covariance has to say so. 22.5: 0.999 quantile of chi square of 6 degrees of freedom.
        assert error @ np.linalg.solve(P + np.diag(3 * [0.01**2] + 3 * [0.005**2]), error) < 22.5
    assert np.max(off, axis=0)[0] < 0.3 and np.max(off, axis=0)[1] < 5, "a sure pose is right"
    assert np.all(np.quantile(off, 0.9, axis=0) < (0.1, 1)), "and seldom as far off"
    assert len(transforms) >= 30
    for t in transforms:
        assert t.header.frame_id == "map"
        stamp = round(t.header.stamp.to_sec() - 1, 6)  # transform_tolerance
        T_w_b = matrix(t.transform.translation, t.transform.rotation) @ odometry[stamp]
        assert np.linalg.norm(T_w_b[:3, 3] - truth[stamp][:3, 3]) < 0.15
    assert any(s.level in (DiagnosticStatus.OK, b"\0") and s.name == "facetloc" for d in diagnostics for s in d.status)

    latched = rospy.wait_for_message("/amcl_pose", PoseWithCovarianceStamped, 10)
    assert (latched.pose.pose.position.z, latched.pose.pose.orientation.x) == (0, 0)
    for service in ("/reinitialize_global_localization", "/global_localization"):
        rospy.wait_for_service(service, 10)
        rospy.ServiceProxy(service, Empty)()
    assert ros.poll() is None
