"""Maps the shards of one tunenet command over Ray tasks, then merges them.

    python ray_shards.py 4 pairs.mcap gen ball --preset easy --pairs 100000 --seed 7

Every node needs tunenet on its path (or TUNENET) and the folder of the file that is written.
"""

import os
import subprocess
import sys
from pathlib import Path

import ray

TUNENET = os.environ.get("TUNENET", "tunenet")


@ray.remote(num_cpus=1, max_retries=3)
def shard(command, out, index, count):
    line = [TUNENET, *command, "--out", out, "--shard", f"{index}/{count}"]
    ran = subprocess.run(line, stderr=subprocess.PIPE, text=True, env={**os.environ, "RAYON_NUM_THREADS": "1"})
    if ran.returncode != 0:
        raise RuntimeError(f"shard {index}/{count} ended with status {ran.returncode}: {ran.stderr}")


def main(count, out, *command):
    out = str(Path(out).absolute())
    ray.init(ignore_reinit_error=True, log_to_driver=False)
    ray.get([shard.remote(command, out, index, int(count)) for index in range(int(count))])
    shards = str(Path(out).with_suffix("")) + f".shard-*-of-{count}" + Path(out).suffix
    return subprocess.run([TUNENET, "merge", shards, "--out", out]).returncode


sys.exit(main(*sys.argv[1:]))
