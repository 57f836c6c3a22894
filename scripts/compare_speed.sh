#!/bin/bash
# Builds two commits and measures both on one recording, in turns, since a machine does not stay as fast as it was.
#   scripts/compare_speed.sh A B [RAWLOG]
#     A, B     commits, or folders in which one is built already (build/bin/vir-slam in it)
#     RAWLOG   recording with one camera and an IMU (default: the sample)
# Prints the CPU time per image of the whole process and of the estimator alone, wall time, peak memory, the
# median of all rounds with its half spread, and B's part of A's; and whether both wrote the same trajectory.
# Environment: ROUNDS (5), INI (ini/euroc.ini of this source tree), SET ("Section.key=value ..." for both),
# JOBS (all cores) and CMAKE_ARGS to build with, KEEP=folder for the builds (default: one that is removed at the end).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

if [ $# -lt 2 ] || [ $# -gt 3 ]; then
  sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
recording=${3:-$root/rawlog/two_A.rawlog}
ini=${INI:-$root/ini/euroc.ini}
rounds=${ROUNDS:-5}
case "$rounds" in
  '' | *[!0-9]* | 0) echo "compare_speed.sh: ROUNDS must be a number above 0, not '$rounds'" >&2; exit 2 ;;
esac
for file in "$recording" "$ini"; do
  [ -f "$file" ] || { echo "compare_speed.sh: there is no such file: $file" >&2; exit 2; }
done
sets=()
for assignment in ${SET:-}; do sets+=(--set "$assignment"); done
read -ra more <<<"${CMAKE_ARGS:-}"

scratch=$(mktemp -d)
folder=${KEEP:-$scratch}
mkdir -p "$folder"
trees=()
cleanUp() {
  if [ -z "${KEEP:-}" ]; then
    for tree in "${trees[@]}"; do git -C "$root" worktree remove --force "$tree" 2>/dev/null || true; done
  fi
  rm -rf "$scratch"
}
trap cleanUp EXIT

# Prints the program of a commit, built if it is not there.
programOf() {
  if [ -x "$1/build/bin/vir-slam" ]; then
    (cd "$1" && echo "$PWD/build/bin/vir-slam")
    return
  fi
  local commit tree
  commit=$(git -C "$root" rev-parse --verify --quiet "$1^{commit}") || {
    echo "compare_speed.sh: '$1' is neither a commit nor a folder with build/bin/vir-slam" >&2
    exit 2
  }
  tree=$folder/$commit
  if [ ! -d "$tree" ]; then git -C "$root" worktree add --detach "$tree" "$commit" >&2; fi
  local launcher=()
  if command -v ccache >/dev/null; then
    launcher=("-DCMAKE_CXX_COMPILER_LAUNCHER=env;CCACHE_BASEDIR=$tree;CCACHE_NOHASHDIR=1;ccache")
  fi
  cmake -S "$tree" -B "$tree/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DVIR_BUILD_TESTS=OFF "${launcher[@]}" \
    "${more[@]}" >&2
  cmake --build "$tree/build" --parallel "${JOBS:-$(nproc)}" --target vir-slam plugins/all >&2
  echo "$tree/build/bin/vir-slam"
}

# One run; adds a line to the figures of $1: CPU and wall seconds, images, estimator's ms, MB.
measure() {
  local name=$1 program=$2 out=$scratch/$1
  rm -rf "$out"
  TIMEFORMAT='%U %S %R'
  local times
  times=$({ time "$program" run "$ini" --rawlog "$recording" --out "$out" "${sets[@]}" >"$scratch/log" 2>&1; } 2>&1) || {
    cat "$scratch/log" >&2
    echo "compare_speed.sh: the run of $program failed" >&2
    exit 1
  }
  local frames estimator memory
  frames=$(valueOf frames "$out") estimator=$(valueOf cpu_ms_per_frame "$out") memory=$(valueOf peak_rss_mb "$out")
  echo "$times $frames $estimator $memory" |
    awk '{ printf "%.4f %.4f %.3f %.1f\n", 1e3 * ($1 + $2) / $4, $5, $3, $6 }' >>"$scratch/$name.figures"
}

valueOf() {
  sed -n "s/^ *\"$1\": \([-0-9.e+]*\),\{0,1\}\$/\1/p" "$2/summary.json" | head -1
}

# Median and half of the distance between the quartiles of column $2 of the figures of $1.
medianOf() {
  cut -d' ' -f"$2" "$scratch/$1.figures" | sort -g |
    awk '{ v[NR] = $1 } END { m = (v[int((NR + 1) / 2)] + v[int(NR / 2) + 1]) / 2
           printf "%.4f %.4f", m, (v[int((3 * NR + 3) / 4)] - v[int((NR + 3) / 4)]) / 2 }'
}

a=$(programOf "$1")
[ -d "$1" ] || trees+=("$folder/$(git -C "$root" rev-parse "$1^{commit}")")
b=$(programOf "$2")
[ -d "$2" ] || trees+=("$folder/$(git -C "$root" rev-parse "$2^{commit}")")

measure warm_up "$a"
for ((i = 0; i < rounds; ++i)); do
  measure a "$a"
  measure b "$b"
done

printf '%-34s %18s %18s %8s\n' "median of $rounds" "A $1" "B $2" "B / A"
row() {
  local column=$1 name=$2 of_a of_b
  of_a=$(medianOf a "$column") of_b=$(medianOf b "$column")
  awk -v name="$name" -v a="$of_a" -v b="$of_b" 'BEGIN {
    split(a, x, " "); split(b, y, " ")
    printf "%-34s %10.2f +-%5.2f %10.2f +-%5.2f %8.3f\n", name, x[1], x[2], y[1], y[2], y[1] / x[1] }'
}
row 1 'CPU of the process [ms/image]'
row 2 'CPU of the estimator [ms/image]'
row 3 'wall time [s]'
row 4 'peak memory [MB]'
if cmp -s "$scratch/a/trajectory.tum" "$scratch/b/trajectory.tum"; then
  echo "trajectories: the same bytes"
else
  echo "trajectories: they differ"
fi
