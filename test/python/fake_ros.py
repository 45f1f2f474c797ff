# SPDX-License-Identifier: BSD-3-Clause
"""rclpy and rospy without ROS, for tests of apps/ros. They refuse what the real ones refuse: values of wrong types, fields that a message
lacks, undeclared or mistyped parameters, publishing a message of another type, and a service without its response. A subscription receives
nothing from a publisher that offers less than it asks for, and late ones what is latched, if they are reliable."""
import array
import collections
import itertools
import sys
import types

import numpy as np

# Fields of messages: a type of Python, the name of a message, [n] = n numbers, [] = any number; * = a list of messages.
FIELDS = {
    "std_msgs": {"Header": {"stamp": "Time", "frame_id": str}},
    "geometry_msgs": {
        "Point": dict.fromkeys("xyz", float), "Vector3": dict.fromkeys("xyz", float), "Quaternion": dict.fromkeys("xyzw", float),
        "Pose": {"position": "Point", "orientation": "Quaternion"}, "PoseWithCovariance": {"pose": "Pose", "covariance": [36]},
        "PoseWithCovarianceStamped": {"header": "Header", "pose": "PoseWithCovariance"},
        "Transform": {"translation": "Vector3", "rotation": "Quaternion"},
        "TransformStamped": {"header": "Header", "child_frame_id": str, "transform": "Transform"}},
    "nav_msgs": {"Odometry": {"header": "Header", "child_frame_id": str, "pose": "PoseWithCovariance"}},
    "sensor_msgs": {
        "RegionOfInterest": dict.fromkeys(("x_offset", "y_offset", "height", "width"), int),
        "CameraInfo": {"header": "Header", "height": int, "width": int, "distortion_model": str, "d": [], "k": [9], "r": [9], "p": [12],
                       "binning_x": int, "binning_y": int, "roi": "RegionOfInterest"},
        "Image": {"header": "Header", "height": int, "width": int, "encoding": str, "is_bigendian": int, "step": int, "data": bytes}},
    "tf2_msgs": {"TFMessage": {"transforms": "*TransformStamped"}},
    "diagnostic_msgs": {
        "KeyValue": {"key": str, "value": str},
        "DiagnosticStatus": {"level": "byte", "name": str, "message": str, "hardware_id": str, "values": "*KeyValue"},
        "DiagnosticArray": {"header": "Header", "status": "*DiagnosticStatus"}}}


class Refused(AssertionError):
    """As the setters of rclpy's messages and genpy's serialization raise for values of wrong types."""


def messages(ros2, time):
    """{package: {name: class}}. rclpy checks a field when it is set, rospy when the message is published."""
    classes = {"Time": time}

    def checked(name, kind, value):
        def require(fits):
            if not fits:
                raise Refused(f"{name}: {value!r} is not of the type {kind}")
        if isinstance(kind, list):
            numbers = list(value)
            require((not kind or len(numbers) == kind[0]) and all(isinstance(v, float) or (not ros2 and isinstance(v, int)) for v in numbers))
            return np.array(numbers) if ros2 and kind else array.array("d", numbers) if ros2 else numbers
        if kind == "byte":
            require(isinstance(value, bytes) and len(value) == 1 if ros2 else isinstance(value, int))
        elif kind is bytes:
            require(isinstance(value, (bytes, array.array, np.ndarray)))
            return array.array("B", bytes(value)) if ros2 else value
        elif isinstance(kind, str) and kind.startswith("*"):
            require(isinstance(value, (list, tuple)) and all(isinstance(v, classes[kind[1:]]) for v in value))
        elif isinstance(kind, str):
            require(isinstance(value, classes[kind]))
        elif kind is float:
            require(isinstance(value, float) or (not ros2 and isinstance(value, int)))
        else:
            require(isinstance(value, kind) and not (kind is int and value < 0))
        return value

    def default(kind):
        if isinstance(kind, list):
            return kind[0] * [0.0] if kind else []
        if isinstance(kind, str):
            return (b"\0" if ros2 else 0) if kind == "byte" else [] if kind.startswith("*") else classes[kind]()
        return kind()

    def message_class(name, fields):
        class Message:
            __slots__ = list(fields)

            def __init__(self, *positional, **values):
                if positional and (ros2 or len(positional) != len(fields)):
                    raise Refused(f"{name} takes names of fields")
                for field, kind in fields.items():
                    object.__setattr__(self, field, default(kind))
                for field, value in itertools.chain(zip(fields, positional), values.items()):
                    setattr(self, field, value)

            def __setattr__(self, field, value):
                if field not in fields:
                    raise AttributeError(f"{name} has no field {field}")
                object.__setattr__(self, field, checked(f"{name}.{field}", fields[field], value) if ros2 else value)

            def check(self):
                for field, kind in fields.items():
                    value = checked(f"{name}.{field}", kind, getattr(self, field))
                    for inner in value if isinstance(kind, str) and kind.startswith("*") else [value]:
                        if hasattr(inner, "check"):
                            inner.check()
        Message.__name__ = Message.__qualname__ = name
        return Message

    packages = {}
    for package, of_package in FIELDS.items():
        for name, fields in of_package.items():
            if not ros2 and name == "CameraInfo":  # K, D, R and P are capitals in ROS 1
                fields = {field.upper() if len(field) == 1 else field: kind for field, kind in fields.items()}
            classes[name] = packages.setdefault(package, {})[name] = message_class(name, fields)
    for level, word in enumerate(("OK", "WARN", "ERROR", "STALE")):
        setattr(classes["DiagnosticStatus"], word, bytes([level]) if ros2 else level)
    return packages


def install(monkeypatch, modules):
    """Makes them importable. modules: {"rclpy.qos": {name: object}}"""
    for name in [n for n in sys.modules if n.split(".")[0] in ("facetloc_ros", *(m.split(".")[0] for m in modules))]:
        monkeypatch.delitem(sys.modules, name)
    for name in sorted({".".join(m.split(".")[:n]) for m in modules for n in range(1, m.count(".") + 2)}):
        module = types.ModuleType(name)
        module.__path__ = []
        monkeypatch.setitem(sys.modules, name, module)
        if "." in name:
            setattr(sys.modules[name.rpartition(".")[0]], name.rpartition(".")[2], module)
    for name, contents in modules.items():
        vars(sys.modules[name]).update(contents)
    return {name: kind for package in modules if package.endswith("_msgs.msg") for name, kind in modules[package].items()}


class Stamp1:
    """rospy.Time"""
    def __init__(self, secs=0, nsecs=0):
        self.secs, self.nsecs = secs, nsecs

    def to_sec(self):
        return self.secs + 1e-9 * self.nsecs

    @classmethod
    def from_sec(cls, seconds):
        nanoseconds = round(1e9 * seconds)
        return cls(nanoseconds // 10**9, nanoseconds % 10**9)

    @classmethod
    def now(cls):
        return cls(1)


class Stamp2:
    """builtin_interfaces/Time"""
    def __init__(self, *, sec=0, nanosec=0):
        self.sec, self.nanosec = sec, nanosec


class Bus:
    """Topics, services and parameters of a ROS. Messages wait until run()."""

    def __init__(self, parameters=None, remapped=None):
        self.parameters, self.remapped = parameters or {}, remapped or {}
        self.subscriptions, self.publishers, self.services, self.logged = [], [], {}, []
        self.waiting = collections.deque()

    def name(self, topic):
        topic = self.remapped.get(topic, topic)
        return topic if topic.startswith("/") else "/" + topic

    def run(self):
        while self.waiting:
            callback, message = self.waiting.popleft()
            callback(message)

    @staticmethod
    def matches(offered, asked):
        """Each a dict: kind, topic, reliable, latched."""
        return (offered["kind"] is asked["kind"] and offered["topic"] == asked["topic"] and offered["reliable"] >= asked["reliable"]
                and offered["latched"] >= asked["latched"])

    def subscribe(self, callback, late=None, **asked):
        """late: it receives what was latched before; unless given, as in ROS 2."""
        self.subscriptions.append((asked, callback))
        late = asked["latched"] and asked["reliable"] if late is None else late
        for publisher in self.publishers:
            if self.matches(publisher.offered, asked) and late:
                self.waiting.extend((callback, message) for message in publisher.kept)

    def advertise(self, kept, **offered):
        publisher = types.SimpleNamespace(offered=offered, kept=collections.deque(maxlen=kept if offered["latched"] else 0))

        def publish(message):
            if not isinstance(message, offered["kind"]):
                raise TypeError(f"{offered['topic']} takes {offered['kind'].__name__}, not {type(message).__name__}")
            message.check()
            publisher.kept.append(message)
            self.waiting.extend((callback, message) for asked, callback in list(self.subscriptions) if self.matches(offered, asked))
        publisher.publish = publish
        self.publishers.append(publisher)
        return publisher


def rclpy(monkeypatch, bus):
    """Installs rclpy on the bus; the classes of messages by name."""
    reliability = types.SimpleNamespace(RELIABLE="reliable", BEST_EFFORT="best effort")
    durability = types.SimpleNamespace(VOLATILE="volatile", TRANSIENT_LOCAL="transient local")

    class QoSProfile:
        def __init__(self, *, depth, reliability="reliable", durability="volatile", history="keep last"):
            self.depth, self.reliable, self.latched = depth, reliability == "reliable", durability == "transient local"
            if history != "keep last" or {reliability, durability} - {"reliable", "best effort", "volatile", "transient local"}:
                raise Refused("no such quality of service")

    def profile(qos):
        if not isinstance(qos, QoSProfile):
            if not isinstance(qos, int) or qos < 0:
                raise TypeError("expected QoSProfile or int")
            qos = QoSProfile(depth=qos)
        return qos

    class SubscriptionEventCallbacks:
        def __init__(self, *, incompatible_qos=None, use_default_callbacks=True):
            self.use_default_callbacks = use_default_callbacks

    class Time:
        def __init__(self, *, seconds=0, nanoseconds=0):
            self.nanoseconds = int(seconds * 10**9) + nanoseconds
            if not isinstance(nanoseconds, int) or self.nanoseconds < 0:
                raise ValueError("nanoseconds must be a whole number that is not negative")

        def to_msg(self):
            return Stamp2(sec=self.nanoseconds // 10**9, nanosec=self.nanoseconds % 10**9)

    class Node:
        def __init__(self, name):
            self.declared = {}

        def get_logger(self):
            return types.SimpleNamespace(warning=bus.logged.append)

        def get_clock(self):
            return types.SimpleNamespace(now=lambda: Time(seconds=1))

        def declare_parameter(self, name, value):
            if name in self.declared:
                raise RuntimeError(f"the parameter {name} was declared before")
            given = bus.parameters.get(name, value)
            if type(given) is not type(value):
                raise TypeError(f"the parameter {name} is a {type(value).__name__}, not a {type(given).__name__}")
            self.declared[name] = given
            return types.SimpleNamespace(value=given)

        def resolve_topic_name(self, topic):
            return bus.name(topic)

        def create_subscription(self, msg_type, topic, callback, qos_profile, *, callback_group=None, event_callbacks=None, raw=False):
            if not (event_callbacks is None or isinstance(event_callbacks, SubscriptionEventCallbacks)):
                raise TypeError("event_callbacks")
            qos = profile(qos_profile)
            bus.subscribe(callback, kind=msg_type, topic=bus.name(topic), reliable=qos.reliable, latched=qos.latched)

        def create_publisher(self, msg_type, topic, qos_profile):
            qos = profile(qos_profile)
            return bus.advertise(qos.depth, kind=msg_type, topic=bus.name(topic), reliable=qos.reliable, latched=qos.latched)

        def create_service(self, srv_type, srv_name, callback):
            def call():
                response = srv_type.Response()
                if callback(srv_type.Request(), response) is not response:
                    raise TypeError("a service has to return its response")
            bus.services[bus.name(srv_name)] = call

    Empty = type("Empty", (), {"Request": type("Request", (), {}), "Response": type("Response", (), {})})
    return install(monkeypatch, {
        "rclpy": {"init": lambda: None, "create_node": Node, "ok": lambda: True, "spin_once": lambda node, timeout_sec: bus.run()},
        "rclpy.time": {"Time": Time}, "rclpy.executors": {"ExternalShutdownException": type("ExternalShutdownException", (Exception,), {})},
        "rclpy.qos": {"QoSProfile": QoSProfile, "ReliabilityPolicy": reliability, "DurabilityPolicy": durability},
        "rclpy.event_handler": {"SubscriptionEventCallbacks": SubscriptionEventCallbacks}, "std_srvs.srv": {"Empty": Empty},
        **{f"{package}.msg": of_package for package, of_package in messages(True, Stamp2).items()}})


def rospy(monkeypatch, bus):
    """Installs rospy on the bus; the classes of messages by name. Every subscriber receives from every publisher."""
    class EmptyResponse:
        pass

    def service(name, kind, handler):
        def call():
            if not isinstance(handler(None), EmptyResponse):
                raise TypeError("a service has to return its response")
        bus.services[bus.name(name)] = call

    def parameter(name, default):
        if not name.startswith("~"):
            raise KeyError(name)
        return bus.parameters.get(name[1:].replace("/", "."), default)
    return install(monkeypatch, {
        "rospy": {"init_node": lambda name: None, "logwarn": bus.logged.append, "get_param": parameter, "resolve_name": bus.name, "Time": Stamp1,
                  "Subscriber": lambda name, data_class, callback, queue_size, buff_size: bus.subscribe(
                      callback, late=True, kind=data_class, topic=bus.name(name), reliable=False, latched=False),
                  "Publisher": lambda name, data_class, queue_size, latch=False: bus.advertise(
                      1, kind=data_class, topic=bus.name(name), reliable=True, latched=latch),
                  "Service": service, "is_shutdown": lambda: False,
                  "rostime": types.SimpleNamespace(wallsleep=lambda seconds: bus.run())},
        "std_srvs.srv": {"Empty": type("Empty", (), {}), "EmptyResponse": EmptyResponse},
        **{f"{package}.msg": of_package for package, of_package in messages(False, Stamp1).items()}})
