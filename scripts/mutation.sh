#!/bin/bash
# Does the suite notice? Puts one-line faults into libs/, one at a time, each into a copy of the tree, and runs the
# unit tests of the library that has it, then, if those pass, the cheapest test of the whole program that uses it.
#   scripts/mutation.sh FIRST LAST [LIBRARY...]
#     FIRST LAST  seeds; the same seed is the same fault in the same tree (scripts/mutate.py)
#     LIBRARY     only faults in these; none: in all
# The copy and its build are in VIR_MUTATION_DIR (default build-mutation/). Results: one line each in results.txt
# there, `found`, `NOT FOUND`, or `no code` where it does not compile. Exit code 1 if one was not found.
# Environment: VIR_JOBS = compilers at a time, VIR_MUTATION_UNIT_ONLY=1 = without the whole program.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ $# -lt 2 ] || ! [[ $1$2 =~ ^[0-9]+$ ]]; then
  sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit 2
fi
first=$1 last=$2
shift 2
work=${VIR_MUTATION_DIR:-$root/build-mutation}
tree=$work/tree
jobs=${VIR_JOBS:-$(nproc)}
mkdir -p "$tree"
# Files that are the same keep their times: what is built stays built.
(cd "$root" && git ls-files -z | xargs -0 cp -au --parents -t "$tree")
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$tree} CCACHE_NOHASHDIR=1
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake -S "$tree" -B "$tree/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DVIR_BUILD_TESTS=ON \
  "${launcher[@]}" >"$work/cmake.log"

# The cheapest test of the whole program that uses a library.
whole_of() {
  case "$1" in
    evaluation | tables) echo evaluate_cli ;;
    bags | formats) echo bag_import ;;
    check) echo check_cli ;;
    ranging | results | runs | roles) echo ranges_end_to_end ;;
    team) echo rendezvous_cli ;;
    live) echo record_cli ;;
    *) echo simulate_end_to_end ;;
  esac
}

# 0: passed; 1: failed, or took too long, which is found as well; 2: does not compile.
check() {
  # shellcheck disable=SC2086 # one word each
  cmake --build "$tree/build" --parallel "$jobs" --target $2 >>"$work/log" 2>&1 || return 2
  (cd "$tree/build" && timeout 600 "bin/test_$1" >>"$work/log" 2>&1) || return 1
}

missed=0
for seed in $(seq "$first" "$last"); do
  what=$(python3 "$tree/scripts/mutate.py" "$tree" "$seed" "$@")
  lib=${what%% *}
  file=$(cut -d' ' -f2 <<<"$what" | cut -d: -f1)
  printf '\n== %s %s\n' "$seed" "$what" >>"$work/log"
  result=0
  check "$lib" "test_$lib" || result=$?
  if [ $result = 0 ] && [ -z "${VIR_MUTATION_UNIT_ONLY:-}" ]; then
    whole=$(whole_of "$lib")
    check "$whole" "vir-slam plugins/all test_$whole" || result=$?
  fi
  case $result in
    0) said="NOT FOUND" missed=1 ;;
    1) said="found" ;;
    *) said="no code" ;;
  esac
  printf '%s %s %s\n' "$seed" "$said" "$what" | tee -a "$work/results.txt"
  cp -p "$root/$file" "$tree/$file"
  touch "$tree/$file"
done
exit $missed
