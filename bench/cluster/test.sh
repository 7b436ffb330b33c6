#!/usr/bin/env bash
# A small protocol over a real Slurm: 1 shard and 7 shards, of which one is cancelled midway and submitted again, make
# the records and the tables of a plain run, all but the times. The Slurm is of one node, on ports and in a folder of
# its own; it is started here, by any user who may, and stopped again. Skipped, with a word, where there is none.
#
# Usage: bench/cluster/test.sh [PROGRAM]
set -euo pipefail

readonly here=$(dirname "$(realpath "$0")")
readonly program=$(realpath "${1:-$here/../../target/release/situ-bench}")
# Where the test itself is a job of some Slurm, that one is none of its business.
unset "${!SLURM_@}" "${!SBATCH_@}"
export PATH="$PATH:/usr/sbin:/sbin"

skip() {
  echo "skipped, no Slurm to run on: $1"
  exit 0
}
for daemon in munged slurmctld slurmd sbatch; do
  command -v "$daemon" >/dev/null || skip "$daemon is not installed (Debian: apt-get install slurm-wlm munge)"
done

readonly folder=$(mktemp -d)
daemons=()
stop() {
  if ((${#daemons[@]})); then
    timeout 10 scancel --user "$(id -un)" 2>/dev/null || true
    for _ in {1..100}; do
      [[ -n $(timeout 10 squeue --noheader 2>/dev/null) ]] || break
      sleep 0.1
    done
    # The last one that was started first: a node signs off, and nobody is left without whom it trusts.
    for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do
      kill "${daemons[i]}" 2>/dev/null || true
      wait "${daemons[i]}" 2>/dev/null || true
    done
  fi
  rm -rf "$folder"
}
trap stop EXIT
trap 'exit 130' INT TERM HUP

# Waits until a command succeeds, some 60 s at the longest.
until_true() {
  for _ in {1..600}; do
    "$@" && return
    sleep 0.1
  done
  return 1
}
start() {
  "$@" </dev/null >>"$folder/daemons.txt" 2>&1 &
  daemons+=($!)
}

host=$(hostname -s)
read -r controller node < <(python3 -c '
import socket
sockets = [socket.create_server(("", 0)) for _ in range(2)]
print(*(one.getsockname()[1] for one in sockets))')
export SLURM_CONF=$folder/slurm.conf
cat >"$SLURM_CONF" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$controller
SlurmdPort=$node
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=0
KillWait=10
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=2000
PartitionName=all Nodes=ALL Default=YES
CONF
mkdir "$folder/state" "$folder/spool"
(umask 077 && head --bytes 128 /dev/urandom >"$folder/munge.key")
start munged --foreground --force --key-file "$folder/munge.key" --socket "$folder/munge.socket" \
  --pid-file "$folder/munged.pid" --log-file "$folder/munged.txt" --seed-file "$folder/munge.seed"
until_true test -S "$folder/munge.socket" || skip "munged does not start: $(tail -n 1 "$folder/daemons.txt")"
start slurmctld -D
start slurmd -D
is_idle() { [[ $(timeout 10 sinfo --noheader --format %T 2>/dev/null) == idle ]]; }
until_true is_idle || skip "its node does not come up: $(grep --text error "$folder/daemons.txt" | tail -n 1)"

cat >"$folder/cluster.toml" <<'PROTOCOL'
name = "cluster"
analysis = "One family in physics, two teachers, and the update cost of two automata: a test."
tasks = ["sort_blocks"]
teachers = ["expert", "novice"]
methods = ["situ", "no_update"]
joint = ["situ"]
seeds = 2
target = 0.5
rollouts = 2
confidence = 0.3
execution = "sample"

[budget]
least_originals = 2
originals = 2
demonstrations = 1

[[cost]]
series = "nodes"
methods = ["situ", "rebuild"]
nodes = [10, 12]
seeds = 2
PROTOCOL
readonly options=(--protocol "$folder/cluster.toml" --plant hand)
# What went wrong, and what the jobs said of it.
fail() {
  echo "error: $1" >&2
  tail -n 5 "$folder"/*/*.txt "$folder/daemons.txt" >&2
  exit 1
}
# Submits so many shards into a folder; further arguments are options of the script.
submit() { "$here/slurm.sh" --program "$program" --memory 500M --shards "$1" "${@:3}" "$folder/$2" "${options[@]}"; }
is_quiet() { [[ -z $(squeue --noheader) ]]; }

# A name with all that paths may have.
seven="seven shards, été"
array=$(submit 7 "$seven" | sed -n 's/^array \([0-9]*\):.*/\1/p')
until_true test -s "$folder/$seven/shards/shard-1-of-7/ledger.jsonl" || fail "the first shard does not begin"
scancel "${array}_1"
until_true is_quiet || fail "the array does not end"
grep --quiet "interrupted: every finished run is in the ledger" "$folder/$seven/shard-1.txt" ||
  fail "a task that is cancelled does not say so"
grep --quiet "runs are missing" "$folder/$seven/merge.txt" || fail "the merge does not miss what was cancelled"
[[ ! -e $folder/$seven/merged ]] || fail "something was merged without all runs"
submit 7 "$seven" >/dev/null
submit 1 one >/dev/null
until_true is_quiet || fail "the arrays do not end"
[[ -e $folder/$seven/merged ]] || fail "what was cancelled, submitted again, is not merged"
cp -r "$folder/one/merged" "$folder/before"
submit 1 one --wait >/dev/null || fail "what is done, submitted again, is not merged"
diff -r "$folder/before" "$folder/one/merged" || fail "what is done, submitted again, is another"

for merged in "$seven" one; do
  "$program" run "${options[@]}" --out "$folder/plain" --resume --check "$folder/$merged/merged" \
    >"$folder/plain.txt" 2>&1 || fail "$merged: $(tail -n 1 "$folder/plain.txt")"
done
records=$(wc -l <"$folder/plain/ledger.jsonl")
echo "$records records: plain, and over Slurm as 1 shard and as 7, one of them cancelled midway: all the same"
