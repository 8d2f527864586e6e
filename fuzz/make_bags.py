"""Seeds of the target `bag`: small bags of ROS 2 in SQLite, of several versions."""

import sqlite3
import struct
import sys
from pathlib import Path

OLD = """
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);
"""
THREE = "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT); INSERT INTO schema VALUES (3, 'humble');"
FOUR = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT); INSERT INTO schema VALUES (4, 'jazzy');
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT, encoded_message_definition TEXT,
    type_description_hash TEXT);
INSERT INTO message_definitions VALUES (1, 'motor/msg/Status', 'ros2msg', 'float64 position', '');
"""
INDEX = "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"


def header(ns):
    return struct.pack("<iII", ns // 10**9, ns % 10**9, 1) + b"\0" + b"\0" * 3


def joints(ns, value):
    names = b"".join(struct.pack("<I", 2) + name + b"\0\0\0" for name in (b"a", b"b"))[:-2]
    body = header(ns) + struct.pack("<I", 2) + names
    for values in ((value, -value), (), (value / 2, 0.0)):
        body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(values))
        if values:
            body += b"\0" * (-len(body) % 8) + struct.pack(f"<{len(values)}d", *values)
    return b"\0\1\0\0" + body


def bag(path, schema, topics):
    path.unlink(missing_ok=True)
    database = sqlite3.connect(path)
    database.execute("PRAGMA page_size = 512")
    database.executescript(schema)
    for number, (name, kind, messages) in enumerate(topics, 1):
        database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, name, kind))
        for ns, data in messages:
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", (number, ns, data))
    database.commit()
    database.close()


folder = Path(sys.argv[1])
at = [10**9 + i * 10**7 for i in range(5)]
states = ("/joint_states", "sensor_msgs/msg/JointState", [(ns, joints(ns, 0.1 * i)) for i, ns in enumerate(at)])
status = ("/status", "motor/msg/Status", [(ns, b"\0\1\0\0" + struct.pack("<d", 0.5 * i)) for i, ns in enumerate(at)])
bag(folder / "old", OLD, [states])
bag(folder / "three", OLD + THREE + INDEX, [states, status])
bag(folder / "four", OLD + FOUR + INDEX, [status, states])
bag(folder / "empty", OLD + THREE, [])
