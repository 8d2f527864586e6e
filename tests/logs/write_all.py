"""Writes one recording of two joints, read from a CSV file, in every other format: `write_all.py FILE.csv FOLDER`.

Other programs write it, so that what tunenet reads is compared with what they mean. Needs pyarrow, h5py, numpy and rosbags.
"""

import csv
import json
import sys
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

JOINTS = ["shoulder", "elbow"]


def bag(path, times, q, dq, tau, plugin, mode=None):
    types = get_typestore(Stores.ROS2_HUMBLE)
    state, header, stamp = (types.types[name] for name in
                            ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"))
    writer = Writer(path, version=8, storage_plugin=plugin)
    if mode:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/joint_states", state.__msgtype__, typestore=types)
        for i, time in enumerate(times):
            ns = round(time * 1e9)
            at = header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="")
            message = state(header=at, name=JOINTS, position=q[i], velocity=dq[i], effort=tau[i])
            writer.write(connection, ns, types.serialize_cdr(message, state.__msgtype__))


def lerobot(folder, q):
    row = {"dtype": "float64", "shape": [2], "names": [f"{name}.pos" for name in JOINTS]}
    info = {"codebase_version": "v3.0", "fps": 100, "robot_type": "arm", "total_episodes": 1,
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "features": {"observation.state": row}}
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    (folder / "meta/info.json").write_text(json.dumps(info))
    count = len(q)
    pq.write_table(pa.table({
        "observation.state": pa.array(q.tolist(), pa.list_(pa.float64(), 2)),
        "timestamp": pa.array([k / 100 for k in range(count)], pa.float32()),
        "frame_index": pa.array(range(count), pa.int64()),
        "episode_index": pa.array([0] * count, pa.int64()),
    }), folder / "data/chunk-000/file-000.parquet")


def main(source, folder):
    with open(source) as file:
        rows = list(csv.DictReader(file))
    columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    pq.write_table(pa.table(columns), folder / "a.parquet", compression="zstd")
    np.savez_compressed(folder / "a.npz", **columns)
    np.save(folder / "a.npy", np.column_stack(list(columns.values())))
    with h5py.File(folder / "a.hdf5", "w") as made:
        for name, values in columns.items():
            made.create_dataset(name, data=values, compression="gzip")
    times = columns["t_s"]
    q, dq, tau = (np.column_stack([columns[f"{kind}{joint}_{unit}"] for joint in (1, 2)])
                  for kind, unit in (("q", "rad"), ("dq", "rad_s"), ("tau", "nm")))
    bag(folder / "sqlite", times, q, dq, tau, StoragePlugin.SQLITE3)
    bag(folder / "sqlite_file", times, q, dq, tau, StoragePlugin.SQLITE3, CompressionMode.FILE)
    bag(folder / "sqlite_message", times, q, dq, tau, StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
    bag(folder / "mcap", times, q, dq, tau, StoragePlugin.MCAP)
    lerobot(folder / "lerobot", q)


main(Path(sys.argv[1]), Path(sys.argv[2]))
