#!/bin/bash
# Every fuzz target in turn, with clang's libFuzzer: builds them into build-fuzz/ and says what each was fed.
#   scripts/fuzz.sh MINUTES [PATTERN]
#     MINUTES  for all targets together
#     PATTERN  only targets whose name holds it, e.g. rawlog
# What a target found, and what it learnt (its corpus), stays in build-fuzz/found and build-fuzz/corpus. Exit code 1
# if anything was found.
# Environment: VIR_FUZZ_BYTES = a target ends once it was fed so many, its time may not be up; VIR_JOBS = compilers at
# a time.
set -euo pipefail
if [[ ${1:-} = -h || ${1:-} = --help ]]; then
  sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit 0
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ $# -lt 1 ] || ! [[ $1 =~ ^[0-9]+$ ]]; then
  sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit 2
fi
minutes=$1
pattern=${2:-}
build=$root/build-fuzz
command -v clang++ >/dev/null || { echo "fuzz: needs clang++" >&2; exit 2; }
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$root} CCACHE_NOHASHDIR=1
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=Release \
  -DVIR_BUILD_FUZZERS=ON "${launcher[@]}" >/dev/null
names=$(sed -n 's/^build \(fuzz_[a-z0-9_]*\): phony.*/\1/p' "$build/build.ninja" | grep -F -- "$pattern" | sort -u || true)
[ -n "$names" ] || { echo "fuzz: no target holds '$pattern'" >&2; exit 2; }
# shellcheck disable=SC2086 # one word each
cmake --build "$build" --parallel "${VIR_JOBS:-$(nproc)}" --target $names >"$build/build.log" ||
  { tail -20 "$build/build.log"; exit 1; }
mkdir -p "$build/found"
count=$(wc -w <<<"$names")
each=$((minutes * 60 / count))
[ "$each" -ge 1 ] || each=1
failed=0
total=0
for name in $names; do
  mkdir -p "$build/corpus/$name"
  program=$(find "$build" -type f -name "$name" -perm -u+x | head -1)
  log=$build/found/$name.log
  result=ok
  # A hang is what takes longer than 10 s for one input.
  "$program" -max_total_time="$each" -max_len=4096 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="$build/found/$name-" "$build/corpus/$name" >"$log" 2>&1 || { result=FOUND; failed=1; }
  # A target that found something is stopped before it can tell.
  read -r bytes runs < <(sed -n 's/^fed \([0-9]*\) bytes in \([0-9]*\) runs$/\1 \2/p' "$log" | tail -1) || true
  total=$((total + ${bytes:-0}))
  printf '%-28s %-6s %12s inputs %14s bytes, %s s\n' "$name" "$result" "${runs:-0}" "${bytes:-0}" "$each"
done
echo "$total bytes in all; logs in $build/found"
exit $failed
