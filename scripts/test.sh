#!/bin/bash
# Installs what is missing, builds and runs every test.
#   scripts/test.sh [--sanitize] [CTEST_ARGUMENT...]
#     --sanitize   with address and undefined behaviour sanitizers, in build-asan/
# Further arguments go to ctest, e.g. -R Evaluate. Environment: VIR_TEST_DATA = folder with the
# recordings some tests use (default: ../shared/data; without it these tests are skipped).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

build_dir=$root/build
options=()
while [ $# -gt 0 ]; do
  case "$1" in
    --sanitize)
      build_dir=$root/build-asan
      options+=(--sanitize)
      # A sanitizer that only prints would let a test pass.
      export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1${UBSAN_OPTIONS:+:$UBSAN_OPTIONS}
      # What the libraries below keep until exit is not ours to free.
      export ASAN_OPTIONS=detect_leaks=0${ASAN_OPTIONS:+:$ASAN_OPTIONS}
      ;;
    -h | --help)
      sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) break ;;
  esac
  shift
done

"$root/scripts/install_dependencies.sh"
"$root/scripts/build.sh" ${options[@]+"${options[@]}"}
ctest --test-dir "$build_dir" --output-on-failure --no-tests=error -j "$(nproc)" "$@"
