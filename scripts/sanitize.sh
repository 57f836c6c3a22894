#!/bin/bash
# The test suite with sanitizers, whole or a part of it.
#   scripts/sanitize.sh [address|thread] [SHARD/SHARDS] [--build TARGET]... [CTEST_ARGUMENT...]
#     address       address and undefined behaviour on all tests (build-asan/); the default
#     thread        the thread sanitizer on the tests of pipeline, live recording, hand-over and streams (build-tsan/)
#     SHARD/SHARDS  e.g. 1/4: every fourth test beginning with the first
#     --build TARGET  only this is built, e.g. --build test_imu with -R '^Imu' (default: everything)
# Environment: VIR_JOBS = compilers at a time, VIR_TEST_JOBS = tests at a time (default 2).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-asan
kind=--sanitize
select=()
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    address) ;;
    thread | --thread)
      build=$root/build-tsan
      kind=--sanitize=thread
      select+=(-R 'live|Live|Pipeline|HandOver|LineServer|Acquisition|record_cli|Record|uwb_plugin|UwbClock|ImuClock|OfflineRun|Foxglove|TeamLink|OpenLink|RosTopics|RigTracker')
      ;;
    [0-9]*/[0-9]*)
      if [ "${1%/*}" -lt 1 ] || [ "${1%/*}" -gt "${1#*/}" ]; then
        echo "sanitize: there is no shard $1 (1/4 to 4/4)" >&2
        exit 2
      fi
      # The last number of -I is what follows "every".
      select+=(-I "${1%/*},,${1#*/}")
      ;;
    --build)
      [ $# -ge 2 ] || { echo "sanitize: --build needs a target" >&2; exit 2; }
      targets+=(--target "$2")
      shift
      ;;
    -h | --help)
      sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -*) break ;;  # the rest is for ctest
    *)
      echo "sanitize: unknown argument '$1' (see --help)" >&2
      exit 2
      ;;
  esac
  shift
done
"$root/scripts/build.sh" "$kind" ${targets[@]+"${targets[@]}"}
# MRPT and OpenCV are not built with sanitizers: what they leave to the end of the program is theirs.
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=0:detect_container_overflow=0}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1:halt_on_error=1}
# What is suppressed and why stands in the file.
export TSAN_OPTIONS=${TSAN_OPTIONS:-second_deadlock_stack=1:suppressions=$root/scripts/sanitize_thread.supp}
# Sanitized programs are five to ten times as slow as the tests' own bounds expect.
ctest --test-dir "$build" --output-on-failure --parallel "${VIR_TEST_JOBS:-2}" --timeout 1800 \
  ${select[@]+"${select[@]}"} "$@"
