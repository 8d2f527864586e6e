#!/usr/bin/env python3
"""Reads what `simulate`, `gen` and `plan` write with the libraries of others: `check.py TUNENET`, run by `make test-mcap`.

Every message of every topic is decoded from the definitions inside the file alone, as Foxglove does it, and held against
the CSV file of the same rollout. CDR is also written back by the library and has to be the same bytes.
"""

import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

from mcap.reader import NonSeekingReader, SeekingReader
from mcap_ros2._dynamic import serialize_dynamic
from mcap_ros2.decoder import DecoderFactory

# Fields as in the packages common_interfaces and rcl_interfaces of ROS 2.
PUBLISHED = {
    "geometry_msgs/PointStamped": ["std_msgs/Header header", "geometry_msgs/Point point"],
    "geometry_msgs/Point": ["float64 x", "float64 y", "float64 z"],
    "std_msgs/Header": ["builtin_interfaces/Time stamp", "string frame_id"],
    "builtin_interfaces/Time": ["int32 sec", "uint32 nanosec"],
}
PUBLISHED_STATE = {
    "sensor_msgs/JointState": [
        "std_msgs/Header header", "string[] name", "float64[] position", "float64[] velocity", "float64[] effort",
    ],
    "std_msgs/Header": PUBLISHED["std_msgs/Header"],
    "builtin_interfaces/Time": PUBLISHED["builtin_interfaces/Time"],
}
PUBLISHED_TRAJECTORY = {
    "trajectory_msgs/JointTrajectory": [
        "std_msgs/Header header", "string[] joint_names", "trajectory_msgs/JointTrajectoryPoint[] points",
    ],
    "trajectory_msgs/JointTrajectoryPoint": [
        "float64[] positions", "float64[] velocities", "float64[] accelerations", "float64[] effort",
        "builtin_interfaces/Duration time_from_start",
    ],
    "builtin_interfaces/Duration": ["int32 sec", "uint32 nanosec"],
    "std_msgs/Header": PUBLISHED["std_msgs/Header"],
    "builtin_interfaces/Time": PUBLISHED["builtin_interfaces/Time"],
}
SCENE = """kind = "ball"
[ball]
radius_m = 0.02
[release]
height_m = 1.0
velocity_m_s = [0.7, -0.3, 0.0]
[parameters.restitution]
value = 0.8
min = 0.0
max = 1.0
"""
ASSETS = Path(__file__).resolve().parent.parent.parent / "assets"
JSON_TYPES = {"object": dict, "array": list, "string": str, "number": (int, float), "integer": int, "boolean": bool}


class JsonDecoder:
    """What the library leaves to others."""

    def decoder_for(self, encoding, schema):
        return json.loads if encoding == "json" and schema is not None and schema.encoding == "jsonschema" else None


def definitions(name, text):
    """The fields of a message and of all that it needs, by name, comments left out."""
    parts, current = {}, name.replace("/msg/", "/")
    for line in text.splitlines():
        line = line.split("#")[0].strip()
        if line.startswith("MSG: "):
            current = line[5:].strip()
        elif line and not line.startswith("==="):
            parts.setdefault(current, []).append(" ".join(line.split()))
    return parts


def acceptable(schema, at="message"):
    """A JSON schema of the kind that Foxglove takes: objects with typed properties, a time as `sec` and `nsec`."""
    assert schema.get("type") in JSON_TYPES, f"{at}: type {schema.get('type')!r}"
    assert not {"$ref", "oneOf", "anyOf", "allOf"} & schema.keys(), f"{at}: only plain types"
    if schema["type"] == "object":
        assert schema.get("properties"), f"{at}: an object without properties"
        if schema.get("title") == "time":
            types = {name: part["type"] for name, part in schema["properties"].items()}
            assert types == {"sec": "integer", "nsec": "integer"}, f"{at}: {types}"
        for name, part in schema["properties"].items():
            acceptable(part, f"{at}.{name}")


def fits(value, schema, at="message"):
    """Whether a message is what its schema says, no field more and none less."""
    assert isinstance(value, JSON_TYPES[schema["type"]]) and not isinstance(value, bool), f"{at}: {value!r}"
    if schema["type"] == "object":
        assert set(schema.get("required", [])) <= value.keys() <= schema["properties"].keys(), f"{at}: {sorted(value)}"
        for name, part in value.items():
            fits(part, schema["properties"][name], f"{at}.{name}")


def messages(path):
    """`{topic: (schema, [(log time, message)])}`, every message decoded and checked against its definition."""
    found = {}
    with open(path, "rb") as file:
        reader = SeekingReader(file, validate_crcs=True, decoder_factories=[DecoderFactory(), JsonDecoder()])
        header, summary = reader.get_header(), reader.get_summary()
        assert header.profile == "ros2" and header.library.startswith("tunenet"), header
        assert summary is not None and summary.statistics is not None, "no summary"
        for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            assert channel.topic.startswith("/") and schema is not None and schema.name, channel
            if channel.message_encoding == "cdr":
                written = serialize_dynamic(schema.name, schema.data.decode())[schema.name](decoded)
                assert bytes(written) == message.data, f"{channel.topic}: message {message.sequence} is written otherwise"
            else:
                fits(decoded, json.loads(schema.data))
            found.setdefault(channel.topic, (schema, []))[1].append((message.log_time, decoded))
        for channel in summary.channels.values():
            read = len(found[channel.topic][1])
            counted = summary.statistics.channel_message_counts[channel.id]
            assert read == counted, f"{channel.topic}: {read} messages, {counted} in the statistics"
            times = [time for time, _ in found[channel.topic][1]]
            assert all(a < b for a, b in zip(times, times[1:])), f"{channel.topic}: the stamps do not rise"
    # As a stream, for those who cannot seek.
    with open(path, "rb") as file:
        streamed = sum(1 for _ in NonSeekingReader(file, validate_crcs=True).iter_messages(log_time_order=False))
    assert streamed == sum(len(each) for _, each in found.values()), f"{streamed} messages as a stream"
    return found


def table(path):
    with open(path, newline="") as file:
        return [[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]


def nanoseconds(time):
    return time.sec * 10**9 + time.nanosec


def positions(found, rows):
    assert list(found) == ["/ball/point"], list(found)
    schema, each = found["/ball/point"]
    assert schema.name == "geometry_msgs/msg/PointStamped", schema.name
    parts = definitions(schema.name, schema.data.decode())
    assert parts == PUBLISHED, parts
    assert len(each) == len(rows) > 100, (len(each), len(rows))
    for (time, message), (t, x, y, z) in zip(each, rows):
        assert message.header.frame_id == "world", message.header
        assert nanoseconds(message.header.stamp) == time == round(t * 1e9), (time, t)
        assert (message.point.x, message.point.y, message.point.z) == (x, y, z), message.point


def bounces(found, rows):
    assert list(found) == ["/ball/bounce"], list(found)
    schema, each = found["/ball/bounce"]
    assert (schema.name, schema.encoding) == ("tunenet.Bounce", "jsonschema"), schema
    acceptable(json.loads(schema.data))
    assert len(each) == len(rows) > 3, (len(each), len(rows))
    # Without a column of numbers, impacts count from 0.
    numbered = [row if len(row) == 2 else [number, *row] for number, row in enumerate(rows)]
    for (time, message), (number, t) in zip(each, numbered):
        stamp = message["timestamp"]["sec"] * 10**9 + message["timestamp"]["nsec"]
        assert stamp == time == round(t * 1e9) and message["bounce"] == number, (message, number, t)


def dataset(found, pairs):
    assert sorted(found) == ["/dataset", "/pair"], list(found)
    (schema, [(_, head)]), (kind, each) = found["/dataset"], found["/pair"]
    assert (schema.name, kind.name) == ("tunenet_msgs/msg/Dataset", "tunenet_msgs/msg/Pair"), (schema.name, kind.name)
    assert head.pairs == len(each) == pairs and head.seed == 3, head
    numbers = len(head.clock) * len(head.channel_names)
    for _, pair in each:
        assert len(pair.proposed) == len(pair.target) == numbers, (len(pair.proposed), numbers)
        for values in (pair.proposed_parameters, pair.target_parameters):
            ranges = zip(head.parameter_names, values, head.parameter_min, head.parameter_max)
            assert all(low <= value <= high for _, value, low, high in ranges), list(values)


def approach(found, plan, limits):
    """The way to the release: one trajectory, and the same point by point; rates as the positions change; within limits."""
    assert sorted(found) == ["/joint_states", "/joint_trajectory"], list(found)
    (kind, [(start, whole)]), (schema, states) = found["/joint_trajectory"], found["/joint_states"]
    assert kind.name == "trajectory_msgs/msg/JointTrajectory" and schema.name == "sensor_msgs/msg/JointState"
    assert definitions(kind.name, kind.data.decode()) == PUBLISHED_TRAJECTORY
    assert definitions(schema.name, schema.data.decode()) == PUBLISHED_STATE
    assert start == 0 and whole.header.frame_id == "base", whole.header
    assert len(whole.points) == len(states) > 20, (len(whole.points), len(states))
    assert list(whole.points[-1].positions) == plan["joint_positions_rad"], "it ends at the release"
    times = [nanoseconds(point.time_from_start) for point in whole.points]
    assert times[0] == 0 and all(a < b for a, b in zip(times, times[1:])), times
    for (time, state), point, due in zip(states, whole.points, times):
        assert time == due == nanoseconds(state.header.stamp) and state.header.frame_id == "base", state.header
        assert list(state.name) == list(whole.joint_names) and not list(state.effort), state.name
        assert list(state.position) == list(point.positions) and list(state.velocity) == list(point.velocities)
    for number, name in enumerate(whole.joint_names):
        q, v, a = ([list(getattr(p, field))[number] for p in whole.points]
                   for field in ("positions", "velocities", "accelerations"))
        low, high, fastest = limits[name]
        assert all(low <= x <= high for x in q) and max(map(abs, v)) <= fastest, name
        assert v[0] == v[-1] == a[0] == a[-1] == 0.0, f"{name}: from rest to rest"
        # Of a way of least jerk the third derivative is at most 60 times the way over T³, the fourth 360 times over T⁴;
        # differences over two steps of h are off by h²/6 of what follows.
        whole_s, step, way = times[-1] * 1e-9, times[1] * 1e-9, abs(q[-1] - q[0])
        off_v, off_a = (way * most * step**2 / 6 + 1e-6 for most in (60 / whole_s**3, 360 / whole_s**4))
        for i in range(1, len(q) - 1):
            seconds = (times[i + 1] - times[i - 1]) * 1e-9
            assert abs((q[i + 1] - q[i - 1]) / seconds - v[i]) <= off_v, (name, i)
            assert abs((v[i + 1] - v[i - 1]) / seconds - a[i]) <= off_a, (name, i)


def limits(urdf):
    """Lowest and highest place and greatest speed of every joint."""
    found = {}
    for joint in ElementTree.parse(urdf).getroot().iter("joint"):
        limit = joint.find("limit")
        if limit is None:
            continue
        free = joint.get("type") == "continuous"
        ends = (-math.inf, math.inf) if free else (float(limit.get("lower", 0)), float(limit.get("upper", 0)))
        found[joint.get("name")] = (*ends, float(limit.get("velocity")))
    return found


def main(tool):
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder)
        (at / "ball.toml").write_text(SCENE)

        def run(*arguments):
            subprocess.run([tool, *arguments], cwd=folder, check=True, stderr=subprocess.DEVNULL)

        for name, flags in [("drop", []), ("bounces", ["--bounces"])]:
            for ending in ["mcap", "csv"]:
                run("simulate", "--sim", "ball.toml", *flags, "--out", f"{name}.{ending}")
        run("gen", "ball", "--pairs", "40", "--seed", "3", "--out", "pairs.mcap")
        positions(messages(at / "drop.mcap"), table(at / "drop.csv"))
        bounces(messages(at / "bounces.mcap"), table(at / "bounces.csv"))
        dataset(messages(at / "pairs.mcap"), 40)
        line = [tool, "plan", "--sim", "ball.toml", "--task", str(ASSETS / "shot.toml"), "--out", "way.mcap", "--json"]
        plan = subprocess.run(line, cwd=folder, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
        approach(messages(at / "way.mcap"), json.loads(plan), limits(ASSETS / "jaco_robotiq.urdf"))
    print("/ball/point, /ball/bounce, /dataset, /pair and the way to a release: every message is read by others as it was meant")


if __name__ == "__main__":
    main(str(Path(sys.argv[1]).resolve()))
