# SPDX-License-Identifier: BSD-3-Clause
"""ROS 1 by rospy."""
import rospy
from std_srvs.srv import Empty, EmptyResponse

from .messages import KINDS, Ros

QUEUE = {"image": 5, "sensor": 100, "reliable": 100, "latched": 100}  # every publisher of ROS 1 may latch


class Ros1(Ros):
    def __init__(self, name):
        rospy.init_node(name)
        self.log, self.served, self.subscribed = rospy.logwarn, [], set()
        self.advertise()

    def parameter(self, name, default):
        value = rospy.get_param("~" + name.replace(".", "/"), default)
        return float(value) if isinstance(default, float) else value  # 1 is written for 1.0

    def subscribe(self, kind, topic, callback, quality):
        if topic not in self.subscribed:
            rospy.Subscriber(topic, KINDS[kind], callback, queue_size=QUEUE[quality], buff_size=1 << 24)
        self.subscribed.add(topic)

    def publisher(self, kind, topic, latched):
        return rospy.Publisher(topic, KINDS[kind], queue_size=10, latch=latched)

    def service(self, name, act):
        for known_as in (name, "global_localization"):  # AMCL's name in ROS 1
            self.served.append(rospy.Service(known_as, Empty, lambda _: (act(), EmptyResponse())[1]))

    def resolved(self, topic):
        return rospy.resolve_name(topic)

    def seconds(self, stamp):
        return stamp.to_sec()

    def stamp(self, seconds):
        return rospy.Time.from_sec(seconds)

    def now(self):
        return rospy.Time.now()

    def spin(self, tick):
        """Calls tick() ten times a second until it is False."""
        while not rospy.is_shutdown() and tick():
            rospy.rostime.wallsleep(0.1)
