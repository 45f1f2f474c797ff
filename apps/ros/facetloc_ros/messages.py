# SPDX-License-Identifier: BSD-3-Clause
"""Messages, which have the same names and fields in ROS 1 and ROS 2."""
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

from .geometry import quaternion_of

KINDS = {kind.__name__: kind for kind in (CameraInfo, DiagnosticArray, Image, Odometry, PoseWithCovarianceStamped, TFMessage)}


def fill(position, rotation, T):
    position.x, position.y, position.z = (float(c) for c in T[:3, 3])
    rotation.x, rotation.y, rotation.z, rotation.w = quaternion_of(T[:3, :3])


class Ros:
    """What both have in common. A subclass has parameter(), subscribe(), publisher(), service(), resolved(), seconds(), stamp(), now(),
    log() and spin(), and calls advertise()."""

    def advertise(self):
        self.publishers = {"pose": self.publisher("PoseWithCovarianceStamped", "pose", latched=False),
                           "amcl_pose": self.publisher("PoseWithCovarianceStamped", "amcl_pose", latched=True),
                           "/tf": self.publisher("TFMessage", "/tf", latched=False),
                           "/diagnostics": self.publisher("DiagnosticArray", "/diagnostics", latched=False)}

    def publish_pose(self, topic, stamp, frame, T, covariance):
        """covariance: (6, 6), position first, along the axes of the frame."""
        out = PoseWithCovarianceStamped()
        out.header.frame_id, out.header.stamp = frame, self.stamp(stamp)
        fill(out.pose.pose.position, out.pose.pose.orientation, T)
        out.pose.covariance = covariance.ravel().tolist()
        self.publishers[topic].publish(out)

    def publish_transform(self, stamp, parent, child, T):
        out = TransformStamped()
        out.header.frame_id, out.header.stamp, out.child_frame_id = parent, self.stamp(stamp), child
        fill(out.transform.translation, out.transform.rotation, T)
        self.publishers["/tf"].publish(TFMessage(transforms=[out]))

    def publish_status(self, level, name, message, hardware, values):
        status = DiagnosticStatus(name=name, message=message, hardware_id=hardware)
        status.level = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR)[level]  # of another type in each ROS
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        out = DiagnosticArray(status=[status])
        out.header.stamp = self.now()
        self.publishers["/diagnostics"].publish(out)
