#!/bin/bash
# Builds the fuzzers with clang into build-fuzz/ and feeds each a number of damaged bytes.
#   scripts/fuzz.sh [--bytes N] [NAME...]    NAME as in tests/fuzz, e.g. fuzz_bag_ros1_lz4; default all
# Environment: VIR_JOBS = number of compilers at a time (default 2).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bytes=10000000
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --bytes)
      [ $# -ge 2 ] || { echo "fuzz: --bytes needs a number" >&2; exit 2; }
      bytes=$2
      shift
      ;;
    -h | --help)
      sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -*)
      echo "fuzz: unknown argument '$1' (see --help)" >&2
      exit 2
      ;;
    *) names+=("$1") ;;
  esac
  shift
done
build=$root/build-fuzz
mkdir -p "$build"
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  -DVIR_BUILD_FUZZERS=ON -DVIR_BUILD_TESTS=OFF >"$build/build.log"
if [ ${#names[@]} -eq 0 ]; then
  mapfile -t names < <(ninja -C "$build" -t targets all |
    sed -n 's/^\(fuzz_[a-z0-9_]*\): phony$/\1/p' | sort -u)
fi
ninja -C "$build" -j "${VIR_JOBS:-2}" "${names[@]}" >>"$build/build.log"
failed=0
for name in "${names[@]}"; do
  program=$(find "$build" -type f -name "$name" -perm -u+x | head -n 1)
  if VIR_FUZZ_BYTES=$bytes "$program" -max_len=256 -rss_limit_mb=1024 -timeout=20 -seed=1 \
    >"$build/$name.log" 2>&1; then
    echo "$name: $bytes bytes, no harm"
  else
    echo "$name: FAILED, see $build/$name.log" >&2
    failed=1
  fi
done
exit $failed
