#!/usr/bin/env python3
"""Seeds of the target `mcap` that hold messages only: kind, length, time in ms, and the message."""
import struct
import sys


def cdr(*fields):
    """Little-endian CDR: integers as (format, value), texts as str, lists of numbers or texts as list."""
    out = b""

    def put(fmt, value):
        nonlocal out
        size = struct.calcsize(fmt)
        out += b"\0" * (-len(out) % size) + struct.pack("<" + fmt, value)

    def text(value):
        nonlocal out
        put("I", len(value) + 1)
        out += value.encode() + b"\0"

    for field in fields:
        if isinstance(field, str):
            text(field)
        elif isinstance(field, bytes):
            put("I", len(field))
            out += field
        elif isinstance(field, list):
            put("I", len(field))
            for value in field:
                text(value) if isinstance(value, str) else put("d", value)
        else:
            put(*field)
    return b"\0\1\0\0" + out


def header(t_ms, frame="map"):
    return ("i", t_ms // 1000), ("I", t_ms % 1000 * 1_000_000), frame


def xyz(z):
    return ("d", 0.1), ("d", 0.2), ("d", z)


def joints(t):
    names = ["shoulder", "elbow"]
    return cdr(*header(t), names, [0.1, 0.2], [0.0, 0.1 * t], [3.0, 4.0])


SEEDS = {
    "points": [(0, cdr(*header(10 * i), *xyz(1.0 - 0.1 * i))) for i in range(6)],
    "poses": [(1, cdr(*header(10 * i), *xyz(1.0 - 0.1 * i), *[("d", 0.0)] * 3, ("d", 1.0))) for i in range(4)],
    "odometry": [(2, cdr(*header(10 * i), "base", *xyz(1.0 - 0.1 * i))) for i in range(5)],
    "joint_states": [(3, joints(10 * i)) for i in range(1, 6)],
    "pictures": [(4, cdr(*header(33 * i), ("I", 2), ("I", 2), "rgb8", ("B", 0), ("I", 6), bytes(12))) for i in range(3)],
    "compressed": [(5, cdr(*header(33 * i), "jpeg", b"\xff\xd8\xff\xe0" + bytes(20))) for i in range(3)],
    "json": [(6, b'{"t_s": %.2f, "x_m": 0, "y_m": 0, "z_m": %.2f}' % (0.01 * i, 1.0 - 0.1 * i)) for i in range(5)],
    "json_stamped": [
        (6, b'{"header":{"stamp":{"sec":1,"nanosec":%d}},"point":{"x":0,"y":0,"z":%.1f}}' % (i * 1000, 0.1 * i))
        for i in range(4)
    ],
    "mixed": [(7, b"?"), (0, cdr(*header(1), *xyz(1.0))), (3, joints(3)), (6, b"[1, 2]")],
}

for name, messages in SEEDS.items():
    data = b"\1" + b"".join(bytes([kind, len(m), 10]) + m for kind, m in messages)
    with open(f"{sys.argv[1]}/{name}", "wb") as file:
        file.write(data)
