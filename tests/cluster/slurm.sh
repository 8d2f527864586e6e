#!/usr/bin/env bash
# A one-node Slurm on loopback, started here and taken down again: the array job of assets/cluster makes a data set in four
# shards, one task is killed midway and requeued, and the merged file has to have the bytes of one run.
#
#   tests/cluster/slurm.sh TUNENET
#
# Needs root, and Debian's munge, slurmctld, slurmd and slurm-client. No cgroups, no other daemon, nothing outside a
# temporary folder.
set -euo pipefail
export TUNENET
TUNENET=$(realpath "$1")
export PAIRS=24000
scripts=$(realpath "$(dirname "$0")/../../assets/cluster")
root=$(mktemp -d /tmp/tunenet-slurm.XXXXXX)
daemons=()
job=

cleanup() { # ends what was started here, and nothing else
    local status=$? pid
    if [[ -n $job ]]; then scancel "$job" 2> /dev/null || true; fi
    for pid in $(stepds); do kill -TERM "$pid" 2> /dev/null || true; done
    for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do
        kill -TERM "${daemons[i]}" 2> /dev/null || true
    done
    for pid in "${daemons[@]}"; do
        timeout 10 tail --pid="$pid" -f /dev/null || kill -KILL "$pid" 2> /dev/null || true
    done
    if ((status != 0)); then
        for log in "$root"/*.log "$root"/work/slurm-*.out; do
            [[ -f $log ]] && { echo "--- $log"; tail -n 25 "$log"; }
        done
    fi
    rm -rf "$root"
    exit "$status"
}

stepds() { # the step daemons of this Slurm: their environment names our configuration
    local entry
    for entry in /proc/[0-9]*; do
        if [[ $(readlink "$entry/exe" 2> /dev/null) == */slurmstepd* ]] \
            && tr '\0' '\n' < "$entry/environ" 2> /dev/null | grep -qx "SLURM_CONF=$root/slurm.conf"; then
            echo "${entry#/proc/}"
        fi
    done
}

task() { # the process of array task $1, where it runs
    local entry
    for entry in /proc/[0-9]*; do
        if [[ $(readlink "$entry/exe" 2> /dev/null) == "$TUNENET" ]] \
            && tr '\0' '\n' < "$entry/environ" 2> /dev/null | grep -qx "SLURM_ARRAY_TASK_ID=$1" \
            && tr '\0' '\n' < "$entry/environ" 2> /dev/null | grep -qx "SLURM_CONF=$root/slurm.conf"; then
            echo "${entry#/proc/}"
            return
        fi
    done
}

await() { # SECONDS WHAT COMMAND…: until the command succeeds
    local end=$((SECONDS + $1)) what=$2
    shift 2
    until "$@"; do
        if ((SECONDS >= end)); then
            echo "waited in vain for $what" >&2
            return 1
        fi
        sleep 0.05
    done
}

free_port() {
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}

trap cleanup EXIT
trap 'exit 130' INT TERM
chmod 755 "$root"
mkdir -p "$root"/{munge,state,spool,work}
chmod 700 "$root/munge"
head -c 128 /dev/urandom > "$root/munge/key"
chmod 400 "$root/munge/key"
host=$(hostname -s)
cat > "$root/slurm.conf" << CONF
ClusterName=tunenet
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# A requeued job waits for as long as the credential of its first run lives.
AuthInfo=socket=$root/munge/socket,cred_expire=5
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
# What the kernel kills is sent off again.
JobRequeue=1
RequeueExit=137
SchedulerParameters=batch_sched_delay=0,sched_interval=2,sched_min_interval=0
KillWait=2
# Four tasks run at once, also on a machine with fewer cores: the figures below count, not what slurmd finds.
SlurmdParameters=config_overrides
StateSaveLocation=$root/state
SlurmdSpoolDir=$root/spool
SlurmctldPidFile=$root/slurmctld.pid
SlurmdPidFile=$root/slurmd.pid
SlurmctldLogFile=$root/slurmctld.log
SlurmdLogFile=$root/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=10 OverSubscribe=NO
CONF
export SLURM_CONF="$root/slurm.conf"

munged --foreground --force --socket="$root/munge/socket" --key-file="$root/munge/key" --seed-file="$root/munge/seed" \
    --pid-file="$root/munge/pid" --log-file="$root/munged.log" > /dev/null 2>&1 &
daemons+=($!)
await 10 munge test -S "$root/munge/socket"
slurmctld -D -i -f "$SLURM_CONF" > /dev/null 2>&1 &
daemons+=($!)
await 20 slurmctld scontrol ping > /dev/null
slurmd -D -f "$SLURM_CONF" > /dev/null 2>&1 &
daemons+=($!)
idle() { [[ $(sinfo --noheader --format=%T 2> /dev/null) == idle ]]; }
await 30 "a node that is idle" idle

cd "$root/work"
job=$(sbatch --parsable "$scripts/array.sbatch")
last=$(sbatch --parsable --dependency="afterany:$job" "$scripts/merge.sbatch")
partial=pairs.shard-2-of-4.mcap.partial
midway() { [[ -s $partial ]] && (($(stat -c %s "$partial") > 1000000)) && [[ -n $(task 2) ]]; }
await 30 "task 2 midway" midway
kill -KILL "$(task 2)"
if [[ -e pairs.shard-2-of-4.mcap ]]; then echo "task 2 ended before it was killed" >&2; exit 1; fi
echo "killed task 2 of 4 with $(stat -c %s "$partial") bytes written"
state() { scontrol show job "$1" --oneliner 2> /dev/null | grep -o "$2=[^ ]*" | sort -u; }
over() { [[ $(state "$last" JobState) == JobState=COMPLETED ]]; }
await 80 "the merged file" over
restarts=$(scontrol show job "${job}_2" --oneliner | grep -o "Restarts=[0-9]*")
[[ $restarts == Restarts=1 ]] || { echo "expected one restart of task 2, found $restarts" >&2; exit 1; }
"$TUNENET" gen ball --preset easy --pairs "$PAIRS" --seed 7 --out whole.mcap > /dev/null 2>&1
cmp pairs.mcap whole.mcap
echo "Slurm $(sinfo --version | cut -d' ' -f2): 4 shards, one killed and requeued, merged to the $(stat -c %s whole.mcap) bytes of one run, $SECONDS s"
