#!/usr/bin/env bash
# Runs a protocol as a Slurm array, one shard a task, and merges the shards once all of them have ended.
set -euo pipefail

usage() {
  cat <<'TEXT'
Usage: bench/cluster/slurm.sh [OPTION…] OUT [RUN-OPTION…]

Submits an array whose tasks each run a shard of a protocol into OUT/shards, and a job after it that merges them into
OUT/merged. Prints the numbers of both jobs. The program is copied to OUT/situ-bench first. What the tasks say is in
OUT/shard-1.txt and so on; what the merge says, in OUT/merge.txt. Submitted again it goes on: what is done is not done
again.

  --shards N         tasks of the array (default: 16)
  --cpus N           processors, and threads, of a task (default: 1)
  --memory SIZE      memory of a task, as sbatch takes it (default: 4G)
  --time TIME        the longest time of a task, as sbatch takes it (default: the partition's)
  --partition NAME   where it runs (default: the cluster's)
  --program PATH     the program (default: target/release/situ-bench)
  --wait             returns once all is merged; exit status 1 where it is not
  --help

Whatever else sbatch takes can be given by its variables: SBATCH_ACCOUNT, SBATCH_CONSTRAINT, SBATCH_EXCLUSIVE.
RUN-OPTIONs go to `situ-bench run`: --protocol paper, say. OUT must be on a file system that all nodes share, and that
has locks.

Example:
  cargo build --release
  bench/cluster/slurm.sh --shards 64 --time 12:00:00 /shared/paper --protocol paper
TEXT
}

refuse() {
  printf 'error: %s\n' "$1" >&2
  exit 2
}

shards=16 cpus=1 memory=4G time="" partition="" wait=""
program=$(dirname "$0")/../../target/release/situ-bench
while [[ ${1-} == --* ]]; do
  case $1 in
    --shards | --cpus | --memory | --time | --partition | --program)
      [[ -n ${2-} ]] || refuse "$1: expected a value"
      declare "${1#--}=$2"
      shift 2
      ;;
    --wait) wait=--wait && shift ;;
    --help) usage && exit ;;
    *) refuse "$1: expected one of the options that --help lists, or OUT and then those of \`run\`" ;;
  esac
done
[[ -n ${1-} ]] || refuse "no OUT: expected a folder that all nodes share (see --help)"
[[ $shards =~ ^[1-9][0-9]*$ ]] || refuse "--shards $shards: expected a number from 1 on"
[[ $cpus =~ ^[1-9][0-9]*$ ]] || refuse "--cpus $cpus: expected a number from 1 on"
[[ -f $program && -x $program ]] || refuse "$program: not there, expected the program (cargo build --release)"
command -v sbatch >/dev/null || refuse "no sbatch here, expected a machine with Slurm"
# Slurm puts something else in the place of these, or nothing at all.
out=$(realpath -m "$1")
[[ $out != *[%\\$'\n']* ]] || refuse "$out: expected a path without %, backslash and line feed"
shift

# The options of `run` that say what there is to run are those of `merge`, too.
merge=(merge "$out/shards" --out "$out/merged")
words=("$@")
for ((i = 0; i < $#; i++)); do
  case ${words[i]} in
    --out | --out=* | --shard | --shard=* | --jobs | --jobs=* | --resume | --check | --check=*)
      refuse "${words[i]}: expected options of \`run\` but --out, --shard, --jobs, --resume and --check"
      ;;
    --tasks | --teachers) merge+=("${words[i]}" "${words[i + 1]-}") ;;
    --tasks=* | --teachers=* | --mixed) merge+=("${words[i]}") ;;
  esac
done

# A copy of its own: who builds the program again does not change a sweep that is under way.
mkdir -p "$out"
copy=$out/situ-bench
if [[ ! -e $copy ]]; then
  cp "$program" "$copy.part"
  mv "$copy.part" "$copy"
fi
cmp -s "$program" "$copy" ||
  refuse "$copy, which has begun there, is another program than $program: go on with --program $copy, or another OUT"

# A script that becomes the program, so that the program hears the signals of Slurm.
script() { printf '#!/usr/bin/env bash\nexec%s\n' "$(printf ' %q' "$@")"; }

common=(--parsable --cpus-per-task "$cpus" --mem "$memory" --open-mode append)
[[ -z $time ]] || common+=(--time "$time")
[[ -z $partition ]] || common+=(--partition "$partition")
array=$(script "$copy" run "$@" --out "$out/shards" --resume --jobs "$cpus" |
  sbatch "${common[@]}" --requeue --job-name situ-run --array "1-$shards" --output "$out/shard-%a.txt")
array=${array%%;*}
echo "array $array: $shards shards into $out/shards"
# After any end of the tasks: where runs are missing, the merge says which.
common+=(--job-name situ-merge --dependency "afterany:$array" --output "$out/merge.txt")
if [[ -z $wait ]]; then
  after=$(script "$copy" "${merge[@]}" | sbatch "${common[@]}")
  echo "job ${after%%;*}: merges them into $out/merged"
elif script "$copy" "${merge[@]}" | sbatch "${common[@]}" --wait >/dev/null; then
  echo "merged into $out/merged"
else
  echo "error: not merged: $out/merge.txt says why, and $out/shard-*.txt what the tasks say" >&2
  exit 1
fi
