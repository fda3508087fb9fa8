#!/usr/bin/env bash
# A sweep on a real Slurm: two slurmd on this host, one of which is killed in mid-run together with a task.
#
# Goal: what `efam sweep submit` hands in comes to its end, a killed task is one missing shard, handing in again runs
# that alone, and the merged table is the one of a single machine, byte for byte. Whatever a folder is called, a script
# does that and nothing else, or is refused.
# Setup: Debian's slurmctld, slurmd, slurm-client and munge, each daemon started by hand with files of its own in a
# folder that is removed; 2048 releases of 20 s. Needs root to install and to run them; says so and passes elsewhere.
#
#     tests/slurm.sh target/debug/efam
set -euo pipefail

efam=$(realpath "${1:-target/debug/efam}")
scenario=$(realpath "$(dirname "$0")/../scenarios/release-15psi.toml")
points=${POINTS:-2048}

skip() { printf -- '-- skipped: %s\n' "$*"; exit 0; }
say() { printf '   %3d s  %s\n' $SECONDS "$*"; }

[ "$(uname -s)" = Linux ] || skip "Slurm runs on Linux"
[ "$(id -u)" = 0 ] || skip "Slurm's daemons need root"
"$(dirname "$0")/apt.sh" slurmctld slurmd sbatch munged -- slurmctld slurmd slurm-client munge ||
  skip "Slurm is not there, and could not be installed"

dir=$(mktemp -d /tmp/efam-slurm.XXXXXX)
export SLURM_CONF=$dir/slurm.conf
daemons=()
# shellcheck disable=SC2317 # the trap calls it
finish() {
  scancel --full --user root >/dev/null 2>&1 || true
  # runuser does not hand a signal on that cannot be caught.
  for pid in $(pgrep -f "$dir/sweep" || true) "${daemons[@]}" $(cat "$dir/munge/pid" 2>/dev/null || true); do
    kill -9 "$pid" 2>/dev/null || true
  done
  wait 2>/dev/null || true
  rm -rf "$dir"
}
trap finish EXIT

failed() {
  printf 'FAILED: %s\n' "$*"
  tail -n 20 "$dir"/*.log "$dir"/sweep/log/* 2>/dev/null || true
  exit 1
}
# What must come true within so many seconds.
until_true() {
  local what=$1 seconds=$2
  shift 2
  for _ in $(seq $((5 * seconds))); do
    if "$@"; then return; fi
    sleep 0.2
  done
  failed "$what did not come within $seconds s"
}

chmod 755 "$dir"
install -d -m 755 "$dir/state" "$dir/munge"
head -c 1024 /dev/urandom >"$dir/munge/key"
chmod 600 "$dir/munge/key"
chown -R munge "$dir/munge"
runuser -u munge -- munged --foreground --force --key-file "$dir/munge/key" --socket "$dir/munge/socket" \
  --pid-file "$dir/munge/pid" --log-file "$dir/munge/log" --seed-file "$dir/munge/seed" >/dev/null 2>&1 &
daemons+=($!)

host=$(hostname -s)
cat >"$SLURM_CONF" <<CONF
ClusterName=efam
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket
SlurmctldPort=26817
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool-%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd-%n.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
SlurmdTimeout=10
KillWait=2
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=2,bf_interval=2
NodeName=n[1-2] NodeHostname=$host NodeAddr=127.0.0.1 Port=[27001-27002] CPUs=1 RealMemory=500
PartitionName=all Nodes=n[1-2] Default=YES MaxTime=INFINITE State=UP
CONF
is_up() { munge -S "$dir/munge/socket" -n >/dev/null 2>&1; }
until_true "munge" 20 is_up
slurmctld -D >"$dir/slurmctld.out" 2>&1 &
daemons+=($!)
for node in n1 n2; do
  install -d "$dir/spool-$node"
  slurmd -D -N $node >"$dir/slurmd-$node.out" 2>&1 &
  daemons+=($!)
  disown
done
second=${daemons[3]}
both_idle() { [ "$(sinfo -h -N -o '%t' 2>/dev/null | grep -c '^idle$')" = 2 ]; }
until_true "Slurm with two nodes" 60 both_idle
say "$(slurmctld -V) is up with two nodes"

cat >"$dir/sweep.toml" <<TOML
[sweep]
scenario = "$scenario"
design = "sobol"
points = $points
[[sweep.parameter]]
path = "muscle.pressure"
range = ["5 psi", "100 psi"]
[[sweep.parameter]]
path = "effects.payload.mass"
range = ["0 g", "100 g"]
TOML
"$efam" -q sweep plan "$dir/sweep.toml" --out "$dir/sweep" --points-per-shard 64
shards=$((points / 64))
done_shards() { find "$dir/sweep" -name part.parquet | wc -l; }
at_least() { [ "$(done_shards)" -ge "$1" ]; }
none_waits() { [ -z "$(squeue -h 2>/dev/null)" ] && squeue -h >/dev/null 2>&1; }

"$efam" sweep submit --plan "$dir/sweep" -- --no-requeue --mem=100 | sed 's/^/          /'
until_true "a quarter of the shards" 600 at_least $((shards / 4))
# The daemon of the second node, and the tasks that run: these end as failed members of the array.
kill -9 "$second"
# Between two tasks there is none for a moment.
kills_a_task() {
  tasks=$(pgrep -f "efam sweep run --quiet --plan $dir/sweep") && kill -9 $tasks 2>/dev/null
}
until_true "a task to kill" 60 kills_a_task
say "killed one daemon and the tasks $(echo $tasks), with $(done_shards) of $shards shards there"
until_true "the end of the array" 900 none_waits
missing=$("$efam" -q sweep status --plan "$dir/sweep")
[ -n "$missing" ] || failed "a killed task is a missing shard"
[ ! -e "$dir/sweep/sweep.parquet" ] || failed "a sweep that lacks shards must not be merged"
grep -q "shards are missing: $missing;" "$dir"/sweep/log/*-merge.txt || failed "the merge says what is missing"
say "the array ended; missing: $missing"

"$efam" sweep submit --plan "$dir/sweep" -- --mem=100 | sed 's/^/          /'
until_true "the second array and the merge" 900 none_waits
[ -z "$("$efam" -q sweep status --plan "$dir/sweep")" ] || failed "shards are still missing"
[ -e "$dir/sweep/sweep.parquet" ] || failed "the merge behind the array did not come"
say "handed in again, the rest was run and merged on the node that is left"

# The same plan on this machine alone.
mkdir "$dir/alone"
cp "$dir"/sweep/{plan.json,points.csv} "$dir/alone"
"$efam" -q sweep run --plan "$dir/alone"
"$efam" -q sweep merge --plan "$dir/alone"
cmp "$dir/sweep/sweep.parquet" "$dir/alone/sweep.parquet" || failed "the tables differ"
for part in "$dir"/alone/shard=*/part.parquet; do
  cmp "$part" "${part/alone/sweep}" || failed "a shard differs"
done
say "$points releases: the tables of Slurm and of one machine are equal, byte for byte"

# Names that a shell or Slurm would take for more than names. `PWNED` must never come to be.
cat >"$dir/one.toml" <<TOML
[sweep]
scenario = "$scenario"
design = "grid"
[[sweep.parameter]]
path = "muscle.pressure"
values = ["15 psi"]
TOML
"$efam" -q sweep plan "$dir/one.toml" --out "$dir/one"
mkdir "$dir/names"
placed() {
  mkdir "$dir/names/$1"
  cp "$dir"/one/{plan.json,points.csv} "$dir/names/$1"
}
fitting=('a b' "o'neil" '$(touch PWNED)' '; touch PWNED;' '`touch PWNED`' '#1 & touch PWNED' '--wrap=touch PWNED' '{a,b}*?~'
  'größe $HOME')
for name in "${fitting[@]}"; do
  placed "$name"
  (cd "$dir/names/$name" && "$efam" -q sweep submit --plan . -- --mem=100) || failed "the folder $name is not handed in"
done
for name in $'new\n#SBATCH --wrap=touch\nline' '50%A' 'quote"' 'back\slash'; do
  placed "$name"
  code=0
  (cd "$dir/names" && "$efam" -q sweep submit --plan "./$name") 2>"$dir/refusal" || code=$?
  [ "$code" = 2 ] && grep -q "no job script can name it" "$dir/refusal" || failed "the folder $name is not refused"
  # A name may be of several lines.
  [ "$(find "$dir/names/$name" -type f -printf x | wc -c)" = 2 ] || failed "the folder $name is refused, and something is there"
done
until_true "the sweeps in folders of all names" 300 none_waits
for name in "${fitting[@]}"; do
  [ -e "$dir/names/$name/sweep.parquet" ] || failed "nothing is merged in the folder $name"
done
strays=$(find "$dir" "$PWD" /root /tmp -maxdepth 4 -name 'PWNED*' 2>/dev/null || true)
[ -z "$strays" ] || failed "a name was run: $strays"
strays=$(find "$dir/names" -mindepth 2 -maxdepth 2 ! -name 'plan.json' ! -name 'points.csv' ! -name 'shard=*' ! -name log \
  ! -name 'array.sh' ! -name 'merge.sh' ! -name 'sweep.*' ! -name 'over-*' ! -name report.html ! -name summary.json ! -name efam-files.json)
[ -z "$strays" ] || failed "a script made more than it should: $strays"
say "${#fitting[@]} folders of strange names are swept and merged, and made nothing else"
