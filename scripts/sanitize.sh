#!/bin/bash
# The test suite with sanitizers, whole or a part of it at a time.
#   scripts/sanitize.sh [--thread] [SHARD/SHARDS] [CTEST_ARGUMENT...]
#     --thread      the thread sanitizer on the tests of pipeline, live recording, hand-over and streams
#                   (build-tsan/); else address and undefined behaviour on all tests (build-asan/)
#     SHARD/SHARDS  e.g. 1/4: every fourth test beginning with the first
# Environment: VIR_JOBS = compilers at a time, VIR_TEST_JOBS = tests at a time (default 2).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-asan
sanitizers=address,undefined
select=()
while [ $# -gt 0 ]; do
  case "$1" in
    --thread)
      build=$root/build-tsan
      sanitizers=thread
      select=(-R 'live|Live|Pipeline|HandOver|LineServer|Acquisition|record_cli|RecordCli')
      ;;
    [0-9]*/[0-9]*)
      # The last number of -I is what follows "every".
      select+=(-I "${1%/*},,${1#*/}")
      ;;
    -h | --help)
      sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) break ;;
  esac
  shift
done
"$root/scripts/build.sh" --build-dir "$build" -DVIR_SANITIZE="$sanitizers" -DCMAKE_BUILD_TYPE=RelWithDebInfo
# MRPT and OpenCV are not built with sanitizers: what they leave to the end of the program is theirs.
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=0:detect_container_overflow=0}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1:halt_on_error=1}
export TSAN_OPTIONS=${TSAN_OPTIONS:-second_deadlock_stack=1}
# Sanitized programs are five to ten times as slow as the tests' own bounds expect.
ctest --test-dir "$build" --output-on-failure --parallel "${VIR_TEST_JOBS:-2}" --timeout 1800 "${select[@]}" "$@"
