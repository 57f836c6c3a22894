#!/bin/bash
# Builds the unit tests of what computes, and the program, for arm64 with Debian's cross compiler, runs
# them in an emulator, and compares the sample's trajectories with those of the program here.
#   scripts/check_arm64.sh [--root DIR] [--reference PROGRAM] [--tests-only]
#     --root DIR            where the arm64 libraries and the build are kept, and used again the next
#                           time (default: arm64 in $XDG_CACHE_HOME/vir-slam or ~/.cache/vir-slam)
#     --reference PROGRAM   the program to compare with (default: build/bin/vir-slam of this checkout)
#     --tests-only          leave out the program and the sample
# Needs the packages of scripts/install_dependencies.sh --arm64, and the first time the mirror that
# apt uses here and 3 GB. Nothing is installed outside of DIR. Not part of .ci/run.
# Environment: VIR_JOBS = number of compilers at a time.
# Exit code: 0 all passed, 1 a failure or other figures, 2 wrong usage, 3 this machine cannot do it.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
dir=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/vir-slam/arm64
reference=$root/build/bin/vir-slam
sample=true
triple=aarch64-linux-gnu
# Between instruction sets sums are rounded otherwise, and what follows from them differs.
tolerance_m=1e-4
# Stamps are on the IMU's clock, of which the camera's is estimated to be that much apart.
tolerance_s=1e-5

say() { printf 'check_arm64: %s\n' "$*"; }
fail() {
  local code=$1
  shift
  say "$*" >&2
  exit "$code"
}

while [ $# -gt 0 ]; do
  case "$1" in
    --root | --reference)
      [ -n "${2:-}" ] || fail 2 "$1 needs a path"
      if [ "$1" = --root ]; then dir=$2; else reference=$2; fi
      shift
      ;;
    --tests-only) sample=false ;;
    -h | --help)
      sed -n '2,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) fail 2 "unknown argument '$1' (see --help)" ;;
  esac
  shift
done

# Files that say that the folder is ours, and that the libraries in it are whole.
ready=.vir-slam-arm64
unfinished=.vir-slam-unfinished
case "$dir" in *[[:space:]]*) fail 2 "'$dir': a path without blanks is needed" ;; esac
if [ -e "$dir" ] && [ ! -f "$dir/$ready" ] && [ ! -f "$dir/$unfinished" ] &&
  { [ ! -d "$dir" ] || [ -n "$(ls -A "$dir")" ]; }; then
  fail 2 "$dir holds something else: give an empty folder"
fi
for tool in $triple-g++ qemu-aarch64-static apt-get dpkg-deb cmake ninja; do
  command -v $tool >/dev/null || fail 3 "$tool is missing: scripts/install_dependencies.sh --arm64"
done
if $sample && [ ! -x "$reference" ]; then
  fail 1 "there is no program $reference to compare with: scripts/build.sh, or --reference PROGRAM"
fi
mkdir -p "$dir"
dir=$(cd "$dir" && pwd)
exec 9>"$dir.lock"
flock -n 9 || { say "another check uses $dir: waiting"; flock 9; }
sysroot=$dir/sysroot
apt=$dir/apt

# An apt of its own for the other architecture: what it holds is unpacked, not installed.
arm_apt() {
  APT_CONFIG=$apt/apt.conf DEBIAN_FRONTEND=noninteractive apt-get -q "$@"
}

download() {
  mkdir -p "$apt/lists/partial" "$apt/archives/partial"
  : >"$apt/status"
  cat >"$apt/apt.conf" <<EOF
APT::Architecture "arm64";
APT::Architectures { "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "root";
Dir::State::Lists "$apt/lists";
Dir::State::status "$apt/status";
Dir::Cache::archives "$apt/archives";
Dir::Cache::pkgcache "";
Dir::Cache::srcpkgcache "";
Debug::NoLocking "true";
EOF
  arm_apt update
  # Programs run here; of these only what is linked is needed.
  local packages version
  version=$($triple-g++ -dumpversion)
  packages=$("$root/scripts/install_dependencies.sh" --list |
    grep -v -x -e build-essential -e cmake -e ninja-build -e mrpt-apps -e cyclonedds-tools)
  # shellcheck disable=SC2086 # a list of words
  arm_apt -y --download-only install "libstdc++-${version%%.*}-dev" libc6-dev libblas3 liblapack3 $packages
}

unpack() {
  rm -rf "$sysroot"
  mkdir -p "$sysroot"/usr/{bin,sbin,lib}
  for link in bin sbin lib; do ln -s "usr/$link" "$sysroot/$link"; done
  for package in "$apt"/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -C "$sysroot" --keep-directory-symlink -xf - \
      --exclude='./usr/share/'{doc,doc-base,fonts,gdal,icons,locale,man}
  done
  # What the packages' scripts would have done, as far as it matters here.
  local libraries=$sysroot/usr/lib/$triple
  for library in blas lapack; do
    ln -sf "$library/lib$library.so.3" "$libraries/lib$library.so.3"
    ln -sf "lib$library.so.3" "$libraries/lib$library.so"
  done
  find "$sysroot" -type l -lname '/*' -print0 | while IFS= read -r -d '' link; do
    ln -sfn "$(realpath -m --relative-to="$(dirname "$link")" "$sysroot$(readlink "$link")")" "$link"
  done
  # Ceres names its libraries by paths of the machine where it is installed.
  find "$libraries/cmake" -name '*.cmake' -exec sed -Ei \
    "s#([;\" ])/usr/lib/$triple/(lib[^;\" /]*\\.(so|a))#\\1$libraries/\\2#g" {} +
  rm -rf "$apt/archives"
}

if [ ! -f "$dir/$ready" ]; then
  touch "$dir/$unfinished"
  say "libraries for arm64 into $dir"
  # Not in a condition, in which a step that fails would not end the others.
  set +e
  (set -e; download; unpack) >"$dir.log" 2>&1
  status=$?
  set -e
  [ "$status" -eq 0 ] || fail 1 "packages: $(tail -n 5 "$dir.log")"
  mv "$dir/$unfinished" "$dir/$ready"
fi

cat >"$dir/toolchain.cmake" <<EOF
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER $triple-gcc)
set(CMAKE_CXX_COMPILER $triple-g++)
set(CMAKE_SYSROOT $sysroot)
set(CMAKE_LIBRARY_ARCHITECTURE $triple)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_\${kind} ONLY)
endforeach()
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static;-L;$sysroot)
EOF
# build COMMAND...: what it says is shown if it fails.
build() {
  "$@" >"$dir.log" 2>&1 || {
    grep -E -A 5 'error|Error|FAILED' "$dir.log" | head -n 60 >&2 || tail -n 20 "$dir.log" >&2
    fail 1 "it does not build for arm64 (all of it: $dir.log)"
  }
}
jobs=${VIR_JOBS:-$(nproc)}
build env VIR_JOBS="$jobs" "$root/scripts/build.sh" --build-dir "$dir/build" --target vir_core \
  "-DCMAKE_TOOLCHAIN_FILE=$dir/toolchain.cmake" -DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST
# What hangs ends.
emulated() { timeout --foreground 7200 qemu-aarch64-static -L "$sysroot" "$@"; }

# The tests of what computes; the others start programs. First what has vectors in its loops.
tests=(geometry core types camera vision imu factors window ranging initialization places estimator
  evaluation rendering rawlog tables)
failed=()
for test in "${tests[@]}"; do
  start=$SECONDS
  build ninja -C "$dir/build" -j "$jobs" "test_$test"
  built=$((SECONDS - start))
  start=$SECONDS
  if emulated "$dir/build/bin/test_$test" --gtest_brief=1 >"$dir.log" 2>&1 </dev/null; then
    passed=$(sed -n 's/^\[ *PASSED *\] //p' "$dir.log" | head -n 1)
    say "test_$test: ${passed%.}, built in $built s, run in $((SECONDS - start)) s"
  else
    mv "$dir.log" "$dir.test_$test.log"
    { grep -E 'FAILED|Failure' "$dir.test_$test.log" || tail -n 5 "$dir.test_$test.log"; } | head -n 20 >&2
    say "test_$test FAILS (all of it: $dir.test_$test.log)" >&2
    failed+=("test_$test")
  fi
done
[ ${#failed[@]} -eq 0 ] || fail 1 "fails on arm64: ${failed[*]}"
$sample || exit 0

start=$SECONDS
build ninja -C "$dir/build" -j "$jobs" vir-slam vir_plugin_vir
say "vir-slam: built in $((SECONDS - start)) s"
say "running the sample there and here"
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
worst=0
for rawlog in "$root"/rawlog/*.rawlog; do
  name=$(basename "$rawlog" .rawlog)
  emulated "$dir/build/bin/vir-slam" run "$root/ini/euroc.ini" --rawlog "$rawlog" \
    --out "$results/$name.there" >"$dir.log" 2>&1 </dev/null ||
    fail 1 "the sample does not run: $(tail -n 3 "$dir.log")"
  "$reference" run "$root/ini/euroc.ini" --rawlog "$rawlog" --out "$results/$name.here" \
    >"$dir.log" 2>&1 </dev/null || fail 1 "the sample does not run with $reference"
  apart=$(paste -d ' ' <(find "$results/$name.there" -name trajectory.tum -exec cat {} +) \
    <(find "$results/$name.here" -name trajectory.tum -exec cat {} +) | awk -v same=$tolerance_s '
    /^#/ { next }
    { late = $1 - $9 } late > same || late < -same { other = 1; exit }
    { d = sqrt(($2-$10)^2 + ($3-$11)^2 + ($4-$12)^2); if (d > most) most = d; n++ }
    END { if (other || !n) print "of other times"; else printf "%.3g\n", most }')
  say "$name: largest distance of the trajectories [m]: $apart"
  awk -v d="$apart" -v t=$tolerance_m 'BEGIN { exit !(d + 0 == d && d <= t) }' || worst=1
done
[ "$worst" -eq 0 ] || fail 1 "more than $tolerance_m m"
say "the same to $tolerance_m m"
