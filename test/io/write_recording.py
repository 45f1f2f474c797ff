#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes recordings of today with nothing but Python's library, after the public specifications:

    write_recording.py FOLDER OUT CONTAINER [WORD...]

FOLDER has intrinsics.txt (width height fx fy cx cy), <stamp>.raw (depth in millimetres, 16 bit), and odometry.txt (TUM), which may be
missing. CONTAINER is db3, mcap or rtabmap. Words, of all of which the last one counts:

    16UC1 32FC1 png quantized rvl    how images are stored; png and rvl are compressedDepth, quantized is its 32FC1 (rtabmap: png, 32FC1, rvl)
    transport                        a PNG of 16 bits, by the plain transport
    zstd lz4                         how messages (db3) or chunks (mcap) are compressed
    unchunked                        mcap: no chunks
    big                              CDR is big-endian
    split                            OUT is a folder of rosbag2 with two files
    tf                               odometry is in /tf, and not in /odom
    torn                             two more messages of tf, and one of the odometry, are none
    imu=FRAME imu_tf                 an IMU at rest in this frame, which tf has turned beside the camera
    camera_tf                        tf has the camera on the robot
    no_info other_info               no CameraInfo; one of another name with the frame of the images
    binned                           CameraInfo is of a sensor of which the images are a part, two by two pixels binned
    again late                       an image is there twice; one is written after the next
    two_topics                       a second topic of depth images, with fewer
    no_graph                         rtabmap: no optimised graph
"""
import ctypes
import math
import pathlib
import sqlite3
import struct
import sys
import zlib

folder, out, container, words = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3], set(sys.argv[4:])
width, height, *intrinsics = map(float, (folder / "intrinsics.txt").read_text().split())
width, height = int(width), int(height)
fx, fy, cx, cy = intrinsics
ORDER = ">" if "big" in words else "<"
CAMERA, BASE, TOPIC = "camera_depth_optical_frame", "base_link", "/camera/depth/image_raw"
LATENCY = 50_000_000  # [ns] from when an image was taken to when it was written
A, B = 10.1, 0.9      # of the quantization: a / (v - b) metres


def zstd(data):
    lib = ctypes.CDLL("libzstd.so.1")
    lib.ZSTD_compressBound.restype = lib.ZSTD_compress.restype = ctypes.c_size_t
    lib.ZSTD_compressBound.argtypes = [ctypes.c_size_t]
    lib.ZSTD_compress.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    packed = ctypes.create_string_buffer(lib.ZSTD_compressBound(len(data)))
    size = lib.ZSTD_compress(packed, len(packed), data, len(data), 1)
    return packed.raw[:size]


def lz4(data):
    lib = ctypes.CDLL("liblz4.so.1")
    lib.LZ4F_compressFrameBound.restype = lib.LZ4F_compressFrame.restype = ctypes.c_size_t
    lib.LZ4F_compressFrameBound.argtypes = [ctypes.c_size_t, ctypes.c_void_p]
    lib.LZ4F_compressFrame.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_void_p]
    packed = ctypes.create_string_buffer(lib.LZ4F_compressFrameBound(len(data), None))
    size = lib.LZ4F_compressFrame(packed, len(packed), data, len(data), None)
    return packed.raw[:size]


class Cdr:
    """A message of XCDR1."""

    def __init__(self):
        self.body = b""

    def put(self, kind, *values):
        size = struct.calcsize("=" + kind)
        for value in values:
            self.body += b"\0" * (-len(self.body) % size) + struct.pack(ORDER + kind, value)
        return self

    def text(self, value):
        data = value.encode() + b"\0"
        self.put("I", len(data)).body += data
        return self

    def data(self, value):
        self.put("I", len(value)).body += value
        return self

    def header(self, stamp, frame):
        seconds = math.floor(stamp + 5e-10)
        return self.put("i", seconds).put("I", max(0, round((stamp - seconds) * 1e9))).text(frame)

    def cut(self):
        self.body = self.body[:-9]
        return self

    def bytes(self):
        return (b"\0\0\0\0" if ORDER == ">" else b"\0\1\0\0") + self.body


def png(values, channels=1, bits=16):
    """Values of a 16-bit grey image, or the bytes of one with four channels."""
    row = width * channels * bits // 8
    data = struct.pack(f">{len(values)}H", *values) if bits == 16 else bytes(values)
    rows = b"".join(b"\0" + data[row * v:row * (v + 1)] for v in range(height))

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, bits, 0 if channels == 1 else 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


def rvl(values):
    nibbles = []

    def number(n):
        while True:
            nibbles.append((n & 7) | (8 if n > 7 else 0))
            n >>= 3
            if n == 0:
                return

    previous, i = 0, 0
    while i < len(values):
        first = i
        while i < len(values) and values[i] == 0:
            i += 1
        number(i - first)
        first = i
        while i < len(values) and values[i] != 0:
            i += 1
        number(i - first)
        for value in values[first:i]:
            number(2 * (value - previous) if value >= previous else 2 * (previous - value) - 1)
            previous = value
    nibbles += [0] * (-len(nibbles) % 8)
    data = bytes(nibbles[k] << 4 | nibbles[k + 1] for k in range(0, len(nibbles), 2))
    return struct.pack("<II", width, height) + b"".join(data[k:k + 4][::-1] for k in range(0, len(data), 4))


def metres(values):
    return [v / 1000 if v else 0.0 for v in values]


def image_message(stamp, values):
    message = Cdr().header(stamp, CAMERA)
    if "transport" in words:
        return message.text("16UC1; png compressed ").data(png(values))
    if {"png", "rvl", "quantized"} & words:
        encoding = "16UC1"
        if "quantized" in words:
            encoding = "32FC1"
            values = [round(A / z + B) if z else 0 for z in metres(values)]
        code = "rvl" if "rvl" in words else "png"
        message.text(f"{encoding}; compressedDepth {code}")
        return message.data(struct.pack("<iff", 0, A, B) + (rvl(values) if code == "rvl" else png(values)))
    is_float = "32FC1" in words
    data = struct.pack(f"<{len(values)}f", *[z or float("nan") for z in metres(values)]) if is_float else \
        struct.pack(f"<{len(values)}H", *values)
    message.put("I", height, width).text("32FC1" if is_float else "16UC1").put("B", 0)
    return message.put("I", (4 if is_float else 2) * width).data(data)


def info_message(stamp):
    n, x, y = (2, 16, 32) if "binned" in words else (1, 0, 0)
    k = [n * fx, n * cx + x, n * fy, n * cy + y]
    message = Cdr().header(stamp, CAMERA).put("I", n * height + y, n * width + x).text("plumb_bob")
    message.put("I", 5).put("d", *[0.0] * 5)
    message.put("d", k[0], 0, k[1], 0, k[2], k[3], 0, 0, 1).put("d", 1, 0, 0, 0, 1, 0, 0, 0, 1)
    message.put("d", k[0], 0, k[1], 0, 0, k[2], k[3], 0, 0, 0, 1, 0)
    region = (x, y, n * height, n * width) if n > 1 else (0, 0, 0, 0)
    return message.put("I", n if n > 1 else 0, n if n > 1 else 0, *region).put("B", 0)


def transforms(*all_of_them):
    message = Cdr().put("I", len(all_of_them))
    for stamp, parent, child, pose in all_of_them:
        message.header(stamp, parent).text(child).put("d", *pose)
    return message


def odometry_message(stamp, pose):
    message = Cdr().header(stamp, "odom").text(BASE).put("d", *pose).put("d", *[0.0] * 36)
    return message.put("d", *[0.0] * 42)


def imu_message(stamp, frame):
    message = Cdr().header(stamp, frame).put("d", 0, 0, 0, 1).put("d", *[0.0] * 9)
    message.put("d", 0, 0, 0).put("d", *[0.0] * 9)
    up = (9.81 * math.sin(0.3), 0, 9.81 * math.cos(0.3)) if "imu_tf" in words else (0, -9.81, 0)
    return message.put("d", *up).put("d", *[0.0] * 9)


def images():
    for file in sorted(folder.glob("*.raw"), key=lambda f: float(f.stem)):
        yield float(file.stem), list(struct.unpack(f"<{width * height}H", file.read_bytes()))


def odometry():
    file = folder / "odometry.txt"
    for line in file.read_text().splitlines() if file.exists() else []:
        if not line.startswith("#"):
            stamp, *pose = map(float, line.split())
            yield stamp, pose


# x right, y down, z forward in x forward, y left, z up
OPTICAL = [0.2, 0, 0.7, -0.5, 0.5, -0.5, 0.5]


def all_messages():
    """(time [ns], topic, type, Cdr), by their times."""
    compressed = "/compressedDepth" if {"png", "rvl", "quantized"} & words else "/compressed" if "transport" in words else ""
    kind = "sensor_msgs/msg/CompressedImage" if compressed else "sensor_msgs/msg/Image"
    messages = []

    def add(stamp, topic, kind, message, late=0):
        messages.append((round((stamp + late) * 1e9) + LATENCY, topic, kind, message.bytes()))

    grey = Cdr().header(0, "rgb").put("I", 1, 1).text("mono8").put("B", 0).put("I", 1).data(b"\0")
    add(0, "/camera/color/image_raw", "sensor_msgs/msg/Image", grey)
    stamps = [stamp for stamp, _ in images()]
    for n, (stamp, values) in enumerate(images()):
        late = 1.5 * (stamps[3] - stamps[2]) if "late" in words and n == 2 else 0
        for _ in range(2 if "again" in words and n == 1 else 1):
            add(stamp, TOPIC + compressed, kind, image_message(stamp, values), late)
        if "two_topics" in words and n % 2 == 0:
            add(stamp, "/other/depth/image", kind, image_message(stamp, values))
        if "no_info" not in words:
            topic = "/info" if "other_info" in words else "/camera/depth/camera_info"
            add(stamp, topic, "sensor_msgs/msg/CameraInfo", info_message(stamp))
        for word in words:
            if word.startswith("imu="):
                for k in range(-5, 6):
                    add(stamp + 0.001 * k, "/imu", "sensor_msgs/msg/Imu", imu_message(stamp + 0.001 * k, word[4:]))
        if n == 0 and "imu_tf" in words:  # the IMU's axes are those of the robot, tilted by 0.3 about y
            tilt = [0, 0, 0, 0, math.sin(-0.15), 0, math.cos(0.15)]
            add(stamp, "/tf_static", "tf2_msgs/msg/TFMessage",
                transforms((stamp, BASE, CAMERA, OPTICAL), (stamp, BASE, "imu_link", tilt)))
        if n == 0 and "camera_tf" in words:
            add(stamp, "/tf_static", "tf2_msgs/msg/TFMessage", transforms((stamp, BASE, CAMERA, OPTICAL)))
    for stamp, pose in odometry():
        if "torn" in words and stamp == 1000:
            good = [5.0, 0, 0, 0, 0, 0, 1]  # in one message with what has no rotation
            add(stamp, "/tf", "tf2_msgs/msg/TFMessage", transforms((stamp, "odom", BASE, good), (stamp, "odom", "x", [0.0] * 7)))
            add(stamp, "/tf", "tf2_msgs/msg/TFMessage", transforms((stamp, "odom", BASE, pose)).cut())
            if "tf" not in words:
                add(stamp, "/odom", "nav_msgs/msg/Odometry", odometry_message(stamp, pose).cut())
        if "tf" in words:
            add(stamp, "/tf", "tf2_msgs/msg/TFMessage", transforms((stamp, "odom", BASE, pose)))
        else:
            add(stamp, "/odom", "nav_msgs/msg/Odometry", odometry_message(stamp, pose))
    return sorted(messages, key=lambda m: m[0])


def write_db3(path, messages):
    db = sqlite3.connect(path)
    db.executescript("""CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                          serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
                        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
                          data BLOB NOT NULL);
                        CREATE INDEX timestamp_idx ON messages (timestamp ASC);""")
    topics = {}
    for time, topic, kind, data in messages:
        if topic not in topics:
            topics[topic] = len(topics) + 1
            db.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')", (topics[topic], topic, kind))
        data = zstd(data) if "zstd" in words else data
        db.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", (topics[topic], time, data))
    db.commit()
    db.close()


def write_mcap(path, messages):
    def text(value):
        return struct.pack("<I", len(value.encode())) + value.encode()

    def record(opcode, content):
        return struct.pack("<BQ", opcode, len(content)) + content

    magic = b"\x89MCAP0\r\n"
    file = magic + record(1, text("ros2") + text("write_recording"))
    compression = next((c for c in ("zstd", "lz4") if c in words), "")
    pack = {"zstd": zstd, "lz4": lz4, "": lambda data: data}[compression]
    per_chunk, part, begin, channels = 3, b"", 0, {}

    def chunk(records, begin, end):
        packed = pack(records)
        head = struct.pack("<QQQI", begin, end, len(records), zlib.crc32(records)) + text(compression)
        return record(6, head + struct.pack("<Q", len(packed)) + packed)

    for n, (time, topic, kind, data) in enumerate(messages):
        begin = begin or time
        if topic not in channels:
            channels[topic] = len(channels) + 1
            schema = struct.pack("<H", channels[topic]) + text(kind) + text("ros2msg") + text("")
            channel = struct.pack("<HH", channels[topic], channels[topic]) + text(topic) + text("cdr") + text("")
            part += record(3, schema) + record(4, channel)
        part += record(5, struct.pack("<HIQQ", channels[topic], n, time, time) + data)
        if "unchunked" in words:
            file, part = file + part, b""
        elif n % per_chunk == per_chunk - 1 or n == len(messages) - 1:
            file, part, begin = file + chunk(part, begin, time), b"", 0
    file += record(15, struct.pack("<I", zlib.crc32(file)))
    path.write_bytes(file + record(2, struct.pack("<QQI", 0, 0, 0)) + magic)


def matrix(pose):
    x, y, z, i, j, k, w = pose
    return [1 - 2 * (j * j + k * k), 2 * (i * j - k * w), 2 * (i * k + j * w), x,
            2 * (i * j + k * w), 1 - 2 * (i * i + k * k), 2 * (j * k - i * w), y,
            2 * (i * k - j * w), 2 * (j * k + i * w), 1 - 2 * (i * i + j * j), z]


def write_rtabmap(path):
    """Poses of the camera in odometry.txt are stored as those of the robot, which carries it at OPTICAL."""
    def product(a, b):
        return [sum(a[4 * r + k] * b[4 * k + c] for k in range(3)) + (a[4 * r + 3] if c == 3 else 0)
                for r in range(3) for c in range(4)]

    def inverse(a):
        return [x for r in range(3) for x in
                [a[r], a[4 + r], a[8 + r], -sum(a[4 * k + r] * a[4 * k + 3] for k in range(3))]]

    def packed(numbers, kind):
        return zlib.compress(struct.pack(f"<{len(numbers)}{kind}", *numbers)) + \
            struct.pack("<iii", 1, len(numbers), 4 if kind == "i" else 5)

    def depth(values):
        if "rvl" in words:
            return b"DEPTHRVL" + rvl(values)
        if "32FC1" not in words:
            return png(values)
        data = bytearray(struct.pack(f"<{len(values)}f", *metres(values)))
        data[0::4], data[2::4] = data[2::4], data[0::4]  # OpenCV takes the bytes for blue, green, red, alpha
        return png(data, 4, 8)

    optical = matrix(OPTICAL)
    poses = {round(stamp, 6): product(matrix(pose), inverse(optical)) for stamp, pose in odometry()}
    db = sqlite3.connect(path)
    db.executescript("""CREATE TABLE Node(id INTEGER NOT NULL, map_id INTEGER NOT NULL, weight INTEGER, stamp FLOAT, pose BLOB,
                          ground_truth_pose BLOB, velocity BLOB, label TEXT, gps BLOB, env_sensors BLOB, time_enter DATE, PRIMARY KEY (id));
                        CREATE TABLE Data(id INTEGER NOT NULL, image BLOB, depth BLOB, calibration BLOB, scan BLOB, scan_info BLOB,
                          user_data BLOB, time_enter DATE, PRIMARY KEY (id));
                        CREATE TABLE Admin(version TEXT, preview_image BLOB, opt_cloud BLOB, opt_ids BLOB, opt_poses BLOB,
                          time_enter DATE);""")
    K = [fx, 0, cx, 0, fy, cy, 0, 0, 1]
    P = [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]
    calibration = struct.pack("<11i", 0, 21, 1, 0, width, height, 9, 5, 9, 12, 12)
    calibration += struct.pack("<35d", *K, *[0] * 5, *[1, 0, 0, 0, 1, 0, 0, 0, 1], *P) + struct.pack("<12f", *optical)
    graph = {}
    for n, (stamp, values) in enumerate(images(), 1):
        pose = poses.get(round(stamp, 6))
        drifted = struct.pack("<12f", *product([1, 0, 0, 0.01 * n, 0, 1, 0, 0, 0, 0, 1, 0], pose)) if pose else None
        if pose:
            graph[n] = pose
        db.execute("INSERT INTO Node(id, map_id, weight, stamp, pose) VALUES(?, 0, 0, ?, ?)", (n, stamp, drifted))
        db.execute("INSERT INTO Data(id, depth, calibration) VALUES(?, ?, ?)", (n, depth(values), calibration))
    db.execute("INSERT INTO Node(id, map_id, weight, stamp) VALUES(100000, 0, -1, 0)")  # without an image
    db.execute("INSERT INTO Data(id) VALUES(100000)")
    if "no_graph" in words or not graph:
        db.execute("INSERT INTO Admin(version) VALUES('0.21.1')")
    else:
        db.execute("INSERT INTO Admin(version, opt_ids, opt_poses) VALUES('0.21.1', ?, ?)",
                   (packed(list(graph), "i"), packed([x for pose in graph.values() for x in pose], "f")))
    db.commit()
    db.close()


if container == "rtabmap":
    write_rtabmap(out)
else:
    write = {"db3": write_db3, "mcap": write_mcap}[container]
    messages = all_messages()
    if "split" in words:
        out.mkdir()
        half, names = len(messages) // 2, [f"{out.name}_{n}.{container}" for n in range(2)]
        write(out / names[0], messages[:half])
        write(out / names[1], messages[half:])
        lines = "".join(f"    - {name}\n" for name in names)
        (out / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n" + lines)
    else:
        write(out, messages)
