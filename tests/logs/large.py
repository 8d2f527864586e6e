"""Time and memory on recordings that are larger than memory should have to be: `large.py TOOL FOLDER [GIB]`.

Writes, one after the other, a LeRobot data set, a ROS 2 bag with pictures and a robomimic file with pictures of so many GiB
each (10 by default) into FOLDER, runs TOOL on each, prints a table, and deletes them. Needs pyarrow, h5py, numpy, rosbags
and GNU time.
"""

import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

FRAMES, TACTILE = 1000, 512  # of an episode; numbers of a skin in each frame
HEIGHT, WIDTH = 480, 640
SCENE = """kind = "equations"
[states.a_rad]
[start.a_rad]
value = "first"
[inputs.goal_rad]
{column}
[parameters.rate]
unit = "1/s"
value = 2.0
min = 0.1
max = 20.0
[derivatives]
a_rad = "rate * (goal_rad - a_rad)"
"""


def moves(random, count, rate):
    """A goal in steps, and a joint that follows it with 3/s and 1 mrad of noise."""
    goal = np.repeat(random.uniform(-1, 1, count // 50 + 1), 50)[:count]
    place, seen = goal[0], []
    for wanted in goal:
        seen.append(place)
        place += (wanted - place) * (1 - np.exp(-3.0 / rate))
    return goal, np.array(seen) + random.normal(0, 1e-3, count)


def lerobot(folder, size, random):
    row = {"dtype": "float32", "shape": [1], "names": ["a.pos"]}
    skin = {"dtype": "float32", "shape": [TACTILE], "names": [f"skin_{i}" for i in range(TACTILE)]}
    per_episode = FRAMES * TACTILE * 4
    episodes = max(int(size / per_episode), 2)
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    info = {"codebase_version": "v3.0", "fps": 50, "robot_type": "arm", "total_episodes": episodes,
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "features": {"observation.state": row, "action": row, "observation.skin": skin}}
    (folder / "meta/info.json").write_text(json.dumps(info))
    step = 48
    for file, first in enumerate(range(0, episodes, step)):
        numbers = range(first, min(first + step, episodes))
        all_moves = [moves(random, FRAMES, 50) for _ in numbers]
        count = FRAMES * len(numbers)
        column = lambda values: pa.FixedSizeListArray.from_arrays(pa.array(values.astype(np.float32)), 1)
        table = pa.table({
            "observation.state": column(np.concatenate([seen for _, seen in all_moves])),
            "action": column(np.concatenate([goal for goal, _ in all_moves])),
            "observation.skin": pa.FixedSizeListArray.from_arrays(
                pa.array(random.standard_normal(count * TACTILE, np.float32)), TACTILE),
            "timestamp": pa.array(np.tile(np.arange(FRAMES) / 50, len(numbers)), pa.float32()),
            "frame_index": pa.array(np.tile(np.arange(FRAMES), len(numbers)), pa.int64()),
            "episode_index": pa.array(np.repeat(np.array(numbers), FRAMES), pa.int64()),
        })
        pq.write_table(table, folder / f"data/chunk-000/file-{file:03d}.parquet", row_group_size=4 * FRAMES,
                       compression="none", use_dictionary=False)
    last = episodes - 1
    return [str(folder)], [f"{folder}/episode_{last}", "--units", "rad"], 'column = "action.a"'


def bag(folder, size, random):
    types = get_typestore(Stores.ROS2_HUMBLE)
    state, header, stamp, image, number = (types.types[name] for name in (
        "sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time", "sensor_msgs/msg/Image",
        "std_msgs/msg/Float64"))
    picture = random.integers(0, 255, HEIGHT * WIDTH * 3, dtype=np.uint8)
    count = max(int(size / picture.nbytes), 100)
    goal, seen = moves(random, count, 50)
    with Writer(folder, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = [writer.add_connection(name, kind.__msgtype__, typestore=types)
                  for name, kind in (("/camera", image), ("/joint_states", state), ("/goal", number))]
        for i in range(count):
            ns = i * 20_000_000
            at = header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="")
            picture[:4] = list(i.to_bytes(4, "little"))
            none = np.zeros(0)
            for topic, message in zip(topics, (
                    image(at, HEIGHT, WIDTH, "rgb8", 0, WIDTH * 3, picture),
                    state(at, ["a"], np.array([seen[i]]), none, none), number(float(goal[i])))):
                writer.write(topic, ns, types.serialize_cdr(message, message.__msgtype__))
    return [str(folder)], [str(folder), "--topic", "/joint_states"], 'topic = "/goal"'


def robomimic(path, size, random):
    picture = HEIGHT * WIDTH * 3
    frames = 200
    episodes = max(int(size / (frames * picture)), 2)
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        for episode in range(episodes):
            goal, seen = moves(random, frames, 50)
            demo = data.create_group(f"demo_{episode}")
            demo["obs/joint_pos"] = seen[:, None]
            demo["actions"] = goal[:, None]
            pictures = demo.create_dataset("obs/camera", (frames, HEIGHT, WIDTH, 3), np.uint8)
            for i in range(frames):
                pictures[i] = random.integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    words = ["--rate", "50", "--units", "rad", "--columns", "a_rad=obs.joint_pos.0"]
    return [str(path)], [f"{path}/demo_{episodes - 1}", *words], 'column = "actions.0"'


def spent(words):
    """Seconds and the most memory in MiB of a command, and what it printed."""
    began = time.monotonic()
    with tempfile.NamedTemporaryFile("r") as kibibytes:
        # A child of Python itself would be charged for Python's memory.
        measured = ["/usr/bin/time", "--quiet", "--format=%M", f"--output={kibibytes.name}", *words]
        ran = subprocess.run(measured, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return time.monotonic() - began, int(kibibytes.read()) / 1024, ran.returncode, ran.stdout


def size_of(path):
    return path.stat().st_size if path.is_file() else sum(p.stat().st_size for p in path.rglob("*") if p.is_file())


def main(tool, folder, gib):
    folder.mkdir(parents=True, exist_ok=True)
    print("| recording | size | inspect | its memory | tune one episode | its memory |\n|---|---:|---:|---:|---:|---:|")
    for name, write in (("LeRobot data set", lerobot), ("ROS 2 bag with pictures", bag), ("HDF5 with pictures", robomimic)):
        place = folder / name.split()[0].lower()
        listed, tuned, column = write(place, gib * 2**30, np.random.default_rng(7))
        scene = folder / "scene.toml"
        scene.write_text(SCENE.format(column=column))
        inspect = spent([tool, "inspect", *listed])
        tune = spent([tool, "tune", "--sim", str(scene), "--json", *tuned])
        print(f"| {name} | {size_of(place) / 2**30:.1f} GiB | {inspect[0]:.2f} s | {inspect[1]:.0f} MiB "
              f"| {tune[0]:.2f} s | {tune[1]:.0f} MiB |", flush=True)
        shutil.rmtree(place) if place.is_dir() else place.unlink()
        if inspect[2] != 0 or tune[2] != 0:
            sys.exit(f"{name}: exit {inspect[2]} and {tune[2]}\n{inspect[3]}\n{tune[3]}")
        rate = json.loads(tune[3][tune[3].index("{\n"):tune[3].rindex("}") + 1])["parameters"]["rate"]["value"]
        assert abs(rate - 3) < 0.1, f"{name}: the rate is 3/s, found {rate}"


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]) if len(sys.argv) > 3 else 10.0)
