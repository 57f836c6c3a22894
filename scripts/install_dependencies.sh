#!/bin/bash
# Installs the Debian packages that building and testing need; installs only what is missing, so a
# second run does nothing and needs no network. Debian 12 and 13.
#   scripts/install_dependencies.sh [--dev] [--browser] [--slurm] [--arm64] [--list]
#     --dev      also the tools of .ci/run (clang, clang-format, clang-tidy, doxygen), Google
#                Benchmark and gcovr
#     --browser  Chromium as well, in which tests look at the pages of results
#     --slurm    a Slurm, of which a test starts one node
#     --arm64    the cross compiler and the emulator of scripts/check_arm64.sh
#     --list     print the packages and stop
set -euo pipefail

packages=(
  build-essential cmake ninja-build
  libeigen3-dev libceres-dev libnlopt-cxx-dev
  libopencv-dev                         # videoio (videos of phones) included
  libmrpt-hwdrivers-dev libmrpt-obs-dev libmrpt-opengl-dev
  mrpt-apps                             # RawLogViewer and rawlog-edit
  libcli11-dev nlohmann-json3-dev libyaml-cpp-dev
  libbz2-dev liblz4-dev libzstd-dev libsqlite3-dev  # bags of ROS and MCAP
  libwebsocketpp-dev                    # Foxglove; headers only
  cyclonedds-dev cyclonedds-tools       # a team over DDS; the rest is built without them too
  libgtest-dev
)
dev_packages=(clang clang-format clang-tidy libbenchmark-dev ccache debootstrap gcovr doxygen)

browser_packages=(chromium)
slurm_packages=(slurmctld slurmd slurm-client munge)
arm64_packages=(g++-aarch64-linux-gnu qemu-user-static)

say() { printf '%s\n' "install_dependencies: $*"; }

list_only=false
for argument in "$@"; do
  case "$argument" in
    --dev) packages+=("${dev_packages[@]}") ;;
    --browser) packages+=("${browser_packages[@]}") ;;
    --slurm) packages+=("${slurm_packages[@]}") ;;
    --arm64) packages+=("${arm64_packages[@]}") ;;
    --list) list_only=true ;;
    -h | --help)
      sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *)
      say "unknown argument '$argument' (known: --dev --browser --slurm --arm64 --list --help)" >&2
      exit 2
      ;;
  esac
done
if $list_only; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  say "this is no Debian (dpkg-query or apt-get is missing); install by hand what corresponds to:" >&2
  printf '  %s\n' "${packages[@]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null || true)
  grep -qx installed <<<"$status" || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  say "nothing to install"
  exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    say "not root and no sudo; run as root: apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

# Waits for a package manager that runs already; lists and archives have a lock apt does not wait
# for by itself, and a mirror may hiccup: hence the tries.
apt() {
  local try
  for try in 1 2 3 4 5; do
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y \
      -o DPkg::Lock::Timeout=600 "$@" </dev/null && return 0
    [ "$try" -lt 5 ] && say "apt-get $1 failed, trying again in $((10 * try)) s" >&2 &&
      sleep $((10 * try))
  done
  say "apt-get $* failed: see its messages above" >&2
  return 1
}

say "missing: ${missing[*]}"
apt update
apt install --no-install-recommends "${missing[@]}"
say "done"
