#!/usr/bin/env bash
# assets/cluster/ray_shards.py on a local Ray: the file has to have the bytes of one run.
#
#   tests/cluster/ray.sh TUNENET PYTHON
set -euo pipefail
export TUNENET
TUNENET=$(realpath "$1")
# Not resolved: a virtual environment is known by the link.
python=$(cd "$(dirname "$2")" && pwd)/$(basename "$2")
script=$(realpath "$(dirname "$0")/../../assets/cluster/ray_shards.py")
# Short, since sockets lie in it.
root=$(mktemp -d /tmp/tn.XXXXXX)
trap 'rm -rf "$root"' EXIT
export HOME="$root" RAY_TMPDIR="$root" RAY_AUTH_MODE=disabled RAY_USAGE_STATS_ENABLED=0
cd "$root"
what=(gen ball --preset easy --pairs 2000 --seed 7)
if ! timeout 120 "$python" "$script" 4 pairs.mcap "${what[@]}" > log 2>&1; then
    cat log >&2
    exit 1
fi
"$TUNENET" "${what[@]}" --out whole.mcap > /dev/null 2>&1
cmp pairs.mcap whole.mcap
echo "Ray $("$python" -c 'import ray; print(ray.__version__)'): 4 shards, merged to the $(stat -c %s whole.mcap) bytes of one run, $SECONDS s"
