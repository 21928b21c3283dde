#!/usr/bin/env bash
# Runs a command with a Slurm of its own: munge, slurmctld and slurmd on this machine, one node with all its cores.
#   scripts/slurm-localhost.sh sbatch --wait --wrap hostname
# Everything is in a temporary folder, on free ports, and ends with the command. Needs Debian's slurm-wlm and munge.
set -euo pipefail

if [ $# = 0 ]; then
  echo 'usage: scripts/slurm-localhost.sh COMMAND [ARGUMENT]...' >&2
  exit 2
fi
# Debian has the daemons in sbin, which is not on every path.
PATH=$PATH:/usr/sbin:/sbin
for program in munged slurmctld slurmd sinfo; do
  if ! command -v "$program" >/dev/null; then
    echo "slurm-localhost.sh: $program is missing; try: sudo apt-get install slurm-wlm munge" >&2
    exit 1
  fi
done

folder=$(mktemp -d -t raypath-slurm-XXXXXX)
processes=()
stop() {
  # The last one started is the first to stop.
  for ((i = ${#processes[@]} - 1; i >= 0; i--)); do kill "${processes[i]}" 2>/dev/null || true; done
  wait
  if [ -n "${RAYPATH_SLURM_KEEP:-}" ]; then echo "slurm-localhost.sh: kept $folder" >&2; else rm -rf "$folder"; fi
}
trap stop EXIT

mkdir -m 700 "$folder/munge" "$folder/state" "$folder/spool"
dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 status=none
chmod 400 "$folder/munge/key"
# munged checks who owns the folders above its files: /tmp is anyone's, which --force allows.
munged --foreground --force --key-file "$folder/munge/key" --socket "$folder/munge/socket" \
  --pid-file "$folder/munge/pid" --log-file "$folder/munge/log" --seed-file "$folder/munge/seed" \
  >"$folder/munged.txt" 2>&1 &
processes+=($!)

host=$(hostname -s)
user=$(id -un)
mapfile -t ports < <(python3 -c '
import socket
found = [socket.socket() for _ in range(2)]
for one in found: one.bind(("127.0.0.1", 0))
for one in found: print(one.getsockname()[1])')
cat >"$folder/slurm.conf" <<CONF
ClusterName=raypath
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
SlurmctldPort=${ports[0]}
SlurmdPort=${ports[1]}
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(awk '/MemTotal/ {print int($2 / 1024)}' /proc/meminfo)
PartitionName=local Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf

slurmctld -D -f "$SLURM_CONF" >"$folder/slurmctld.txt" 2>&1 &
processes+=($!)
slurmd -D -f "$SLURM_CONF" -N "$host" >"$folder/slurmd.txt" 2>&1 &
processes+=($!)
for _ in $(seq 100); do
  [ "$(sinfo --noheader --format %T 2>/dev/null)" = idle ] && break
  sleep 0.3
done
if [ "$(sinfo --noheader --format %T 2>/dev/null)" != idle ]; then
  echo 'slurm-localhost.sh: the node is not idle after 30 s, expected it to be; the logs end with:' >&2
  tail -n 5 "$folder"/*.txt >&2
  exit 1
fi
"$@"
