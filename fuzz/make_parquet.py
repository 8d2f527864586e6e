"""Seeds of the targets `parquet` and `lerobot`: small tables of every compression that is read, and data sets of two versions."""

import json
import sys
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

FRAMES = 24


def frames(fixed):
    row = pa.list_(pa.float32(), 2) if fixed else pa.list_(pa.float32())
    state = [[(i * i * 7 % 91) * 0.25, (i * 3 % 17) * 0.5] for i in range(FRAMES)]
    return pa.table({
        "observation.state": pa.array(state, row),
        "action": pa.array([[a + 1, b] for a, b in state], row),
        "timestamp": pa.array([i / 30 for i in range(FRAMES)], pa.float32()),
        "frame_index": pa.array(range(FRAMES), pa.int64()),
        "episode_index": pa.array([0] * FRAMES, pa.int64()),
    })


def table():
    return pa.table({
        "t_s": [i * 0.1 for i in range(FRAMES)],
        "z_m": [None if i == 3 else 1.0 - i * 0.01 for i in range(FRAMES)],
        "stamp": pa.array([1_700_000_000_000_000 + i for i in range(FRAMES)], pa.timestamp("us")),
        "note": ["a"] * FRAMES,
        "on": [i % 2 == 0 for i in range(FRAMES)],
    })


def main(corpus):
    for name, made, options in [
        ("plain", table(), {"compression": "none", "use_dictionary": False}),
        ("snappy", table(), {"compression": "snappy"}),
        ("zstd", table(), {"compression": "zstd", "data_page_version": "2.0"}),
        ("gzip", frames(True), {"compression": "gzip", "row_group_size": 10}),
    ]:
        pq.write_table(made, corpus / "parquet" / name, **options)
    for version, names, fixed in [("v2.1", [["a", "b"]], True), ("v3.0", {"motors": ["a.pos", "b.pos"]}, False)]:
        row = {"dtype": "float32", "shape": [2], "names": names}
        info = {"codebase_version": version, "fps": 30, "robot_type": "arm", "total_episodes": 2,
                "features": {"observation.state": row, "action": row}}
        path = corpus / "lerobot" / version.replace(".", "_")
        pq.write_table(frames(fixed), path)
        path.write_bytes(json.dumps(info).encode() + b"\0" + path.read_bytes())


main(Path(sys.argv[1]))
