#!/bin/bash
# Configures and builds (Release) into build/; what is up to date is not built again.
#   scripts/build.sh [--build-dir DIR] [--sanitize[=thread]] [--app-only] [--target TARGET]... [CMAKE_ARGUMENT...]
#     --build-dir DIR  another folder than build/ (relative to the checkout)
#     --sanitize       address and undefined behaviour sanitizers, in build-asan/; =thread: of threads, in build-tsan/
#     --app-only       a new build folder leaves the tests out
#     --target TARGET  only this (default: everything)
# Environment: VIR_JOBS = number of compilers at a time (default: by cores and free memory).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

build_dir=build
app_only=false
options=()
first_options=()  # of a new build folder
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build-dir)
      [ $# -ge 2 ] || { echo "build: --build-dir needs a folder" >&2; exit 2; }
      build_dir=$2
      shift
      ;;
    --sanitize | --sanitize=thread)
      build_dir=build-asan
      kinds=address,undefined
      if [ "$1" = --sanitize=thread ]; then build_dir=build-tsan kinds=thread; fi
      # Asserts count. gcc takes twice as long with -O2 -g, and clang, where it is, half of what gcc takes with these.
      options+=("-DVIR_SANITIZE=$kinds" -DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1")
      if command -v clang++ >/dev/null; then
        first_options+=(-DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++)
      fi
      ;;
    --app-only) app_only=true ;;
    --target)
      [ $# -ge 2 ] || { echo "build: --target needs a name" >&2; exit 2; }
      targets+=("$2")
      shift
      ;;
    -h | --help)
      sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -D*) options+=("$1") ;;
    *)
      echo "build: unknown argument '$1' (see --help)" >&2
      exit 2
      ;;
  esac
  shift
done
case "$build_dir" in /*) ;; *) build_dir=$root/$build_dir ;; esac

# A translation unit may take 2 GB: as many compilers at a time as fit, at most one per core.
jobs=${VIR_JOBS:-}
if [ -z "$jobs" ]; then
  jobs=$(nproc)
  free_kb=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo 2>/dev/null || true)
  if [ -n "$free_kb" ]; then
    by_memory=$((free_kb / (2 * 1024 * 1024)))
    [ "$by_memory" -ge "$jobs" ] || jobs=$by_memory
  fi
  [ "$jobs" -ge 1 ] || jobs=1
fi

cache=$build_dir/CMakeCache.txt
if [ -f "$cache" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$cache"; then
  echo "build: $build_dir was made for another folder, configuring anew" >&2
  rm -rf "$cache" "$build_dir/CMakeFiles"
fi
if [ ! -f "$cache" ]; then
  options=(-G Ninja -DCMAKE_BUILD_TYPE=Release ${first_options[@]+"${first_options[@]}"} "${options[@]}")
  if $app_only; then options+=(-DVIR_BUILD_TESTS=OFF); fi
  # Paths below the checkout count as relative ones, so that objects of another checkout are found.
  if command -v ccache >/dev/null; then
    launcher="env;CCACHE_BASEDIR=$root;CCACHE_NOHASHDIR=1;ccache"
    options+=("-DCMAKE_CXX_COMPILER_LAUNCHER=$launcher")
  fi
elif ! $app_only; then
  options+=(-DVIR_BUILD_TESTS=ON)
fi
cmake -S "$root" -B "$build_dir" "${options[@]}"
cmake --build "$build_dir" --parallel "$jobs" ${targets[@]+--target "${targets[@]}"}
