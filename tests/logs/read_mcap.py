"""Prints the joint states in an MCAP file as rosbags reads them, a row for each message: `read_mcap.py FILE.mcap`.

A row is the stamp in ns, then positions, velocities and efforts, with all their digits. Needs rosbags.
"""

import sys
from pathlib import Path

from rosbags.highlevel import AnyReader

with AnyReader([Path(sys.argv[1])]) as reader:
    for connection, _, raw in reader.messages():
        message = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        numbers = [*message.position, *message.velocity, *message.effort]
        print(stamp.sec * 10**9 + stamp.nanosec, *(repr(float(number)) for number in numbers))
