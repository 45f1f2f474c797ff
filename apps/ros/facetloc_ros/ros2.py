# SPDX-License-Identifier: BSD-3-Clause
"""ROS 2 by rclpy."""
import rclpy
import rclpy.time
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Empty

try:
    from rclpy.event_handler import SubscriptionEventCallbacks
except ImportError:  # up to Humble
    from rclpy.qos_event import SubscriptionEventCallbacks

from .messages import KINDS, Ros

# A subscription receives nothing from a publisher that offers less than it asks for. Drivers offer best effort for images, camera_info
# and odometry; what is latched is reliable and transient local.
QUALITY = {"image": QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT),
           "sensor": QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT),
           "reliable": QoSProfile(depth=100),
           "latched": QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)}


class Ros2(Ros):
    def __init__(self, name):
        rclpy.init()
        self.node = rclpy.create_node(name)
        self.log = self.node.get_logger().warning
        self.advertise()

    def parameter(self, name, default):
        return self.node.declare_parameter(name, default).value

    def subscribe(self, kind, topic, callback, quality):
        # A topic is subscribed to in two qualities, of which one does not match: no reason to warn.
        self.node.create_subscription(KINDS[kind], topic, callback, QUALITY[quality],
                                      event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=quality != "latched"))

    def publisher(self, kind, topic, latched):
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        return self.node.create_publisher(KINDS[kind], topic, QoSProfile(depth=1 if latched else 100, durability=durability))

    def service(self, name, act):
        self.node.create_service(Empty, name, lambda _, response: (act(), response)[1])

    def resolved(self, topic):
        return self.node.resolve_topic_name(topic)

    def seconds(self, stamp):
        return stamp.sec + 1e-9 * stamp.nanosec

    def stamp(self, seconds):
        return rclpy.time.Time(nanoseconds=round(1e9 * seconds)).to_msg()

    def now(self):
        return self.node.get_clock().now().to_msg()

    def spin(self, tick):
        """Calls tick() at least ten times a second until it is False."""
        try:
            while rclpy.ok() and tick():
                rclpy.spin_once(self.node, timeout_sec=0.1)
        except ExternalShutdownException:
            pass
