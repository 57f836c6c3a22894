#!/bin/bash
# A Slurm of one node for a test, in the folder that is given; `slurm_node.sh stop FOLDER` ends it.
# Then SLURM_CONF=FOLDER/slurm.conf leads sbatch and squeue to it. Needs root, slurmctld, slurmd and
# munged.
set -euo pipefail
if [ "$1" = stop ]; then
  for daemon in slurmd slurmctld munge; do
    [ -f "$2/$daemon.pid" ] && kill "$(cat "$2/$daemon.pid")" 2>/dev/null
  done
  exit 0
fi
folder=$1 port=$2 host=$(hostname -s)
mkdir -p "$folder/state" "$folder/spool" "$folder/munge"
chmod 700 "$folder/munge"
head -c 1024 /dev/urandom >"$folder/munge/key"
chmod 600 "$folder/munge/key"
munged --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" --pid-file="$folder/munge.pid" \
  --log-file="$folder/munge.log" --seed-file="$folder/munge/seed" --num-threads=1
cat >"$folder/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldPort=$port
SlurmdPort=$((port + 1))
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_interval=1
MinJobAge=30
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=test Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$folder/slurm.conf
slurmctld -f "$SLURM_CONF" -L "$folder/slurmctld.log"
slurmd -f "$SLURM_CONF" -L "$folder/slurmd.log" -N "$host"
for _ in $(seq 100); do
  sinfo --noheader --format=%T 2>/dev/null | grep -q idle && { echo ready; exit 0; }
  sleep 0.2
done
cat "$folder/slurmctld.log" "$folder/slurmd.log" >&2
exit 1
