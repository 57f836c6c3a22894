#!/bin/bash
# Builds the program on Debian 13 and compares the sample's figures with those of the program here.
#   scripts/check_debian13.sh [--root DIR] [--reference PROGRAM]
#     --root DIR            where Debian 13 and its compiler cache are kept, and used again the next
#                           time (default: debian13 in $XDG_CACHE_HOME/vir-slam or ~/.cache/vir-slam)
#     --reference PROGRAM   the program to compare with (default: build/bin/vir-slam of this checkout)
# Needs root, debootstrap, and the first time the mirror that apt uses here and 4 GB.
# Environment: VIR_JOBS = number of compilers at a time.
# Exit code: 0 the same figures, 1 others or a failure, 2 wrong usage, 3 this machine cannot do it.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
suite=trixie
chroot=${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/vir-slam/debian13
reference=$root/build/bin/vir-slam

say() { printf 'check_debian13: %s\n' "$*"; }
fail() {
  local code=$1
  shift
  say "$*" >&2
  exit "$code"
}

while [ $# -gt 0 ]; do
  case "$1" in
    --root | --reference)
      [ $# -ge 2 ] || fail 2 "$1 needs a path"
      if [ "$1" = --root ]; then chroot=$2; else reference=$2; fi
      shift
      ;;
    -h | --help)
      sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) fail 2 "unknown argument '$1' (see --help)" ;;
  esac
  shift
done

[ "$(id -u)" -eq 0 ] || fail 3 "must be run as root (a chroot of Debian 13 is made)"
# All mounts are made in a namespace of their own and are gone when its last process is.
unshare --mount --pid --fork true 2>/dev/null ||
  fail 3 "this container does not let root mount anything (unshare --mount failed)"
command -v debootstrap >/dev/null ||
  fail 3 "debootstrap is missing: scripts/install_dependencies.sh --dev"
[ -x "$reference" ] ||
  fail 1 "there is no program $reference to compare with: scripts/build.sh, or --reference PROGRAM"

mkdir -p "$chroot"
chroot=$(cd "$chroot" && pwd)
exec 9>"$chroot.lock"
flock -n 9 || { say "another check uses $chroot: waiting"; flock 9; }

# The mirror of the Debian archive that apt uses on this machine.
mirror() {
  local format='$(REPO_URI) $(COMPONENT)' found
  for origin in Debian ''; do
    found=$(apt-get indextargets --format "$format" "Created-By: Packages" ${origin:+"Label: $origin"} |
      sed -n 's|^\([^ ]*/debian/\{0,1\}\) main$|\1|p' | head -n 1)
    if [ -n "$found" ]; then
      printf '%s\n' "$found"
      return
    fi
  done
  return 1
}

# inside SCRIPT [ARGUMENT...]: a shell script in the chroot, its input from ours.
inside() {
  # shellcheck disable=SC2016 # expanded by the inner shell
  unshare --mount --pid --fork --kill-child --propagation private sh -euc '
    chroot=$1; shift
    mount --rbind /dev "$chroot/dev"
    mount -t proc proc "$chroot/proc"
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
      LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive ${http_proxy:+http_proxy="$http_proxy"} \
      chroot "$chroot" bash -euo pipefail -c "$@"' sh "$chroot" "$1" bash "${@:2}"
}

# The file says that the folder is ours and whole: without it, it is made anew.
ready=$chroot/.vir-slam-debian13
if [ ! -f "$ready" ]; then
  if [ -n "$(ls -A "$chroot")" ] && [ ! -f "$chroot/.vir-slam-unfinished" ]; then
    fail 2 "$chroot holds something else: give an empty folder"
  fi
  find "$chroot" -mindepth 1 -maxdepth 1 ! -name .vir-slam-unfinished -exec rm -rf {} +
  touch "$chroot/.vir-slam-unfinished"
  from=$(mirror) || fail 1 "apt knows no mirror of Debian here (its lists may be empty: apt-get update)"
  say "setting up Debian 13 in $chroot"
  unshare --mount --propagation private \
    debootstrap --variant=minbase "$suite" "$chroot" "$from" >"$chroot.log" 2>&1 ||
    fail 1 "debootstrap failed (no network?): $(tail -n 3 "$chroot.log")"
  printf '#!/bin/sh\nexit 101\n' >"$chroot/usr/sbin/policy-rc.d" # no services in there
  chmod +x "$chroot/usr/sbin/policy-rc.d"
  mv "$chroot/.vir-slam-unfinished" "$ready"
fi
cp /etc/resolv.conf "$chroot/etc/resolv.conf"

# The checkout as it is, what git does not know included, but nothing that was built.
rm -rf "$chroot/src"
mkdir "$chroot/src"
(cd "$root" && git ls-files -z --cached --others --exclude-standard |
  tar --null --ignore-failed-read -T - -cf - 2>/dev/null) | tar -C "$chroot/src" -xf -
[ -f "$chroot/src/CMakeLists.txt" ] || fail 1 "cannot copy the checkout (is it one of git?)"

say "packages"
inside '
  dpkg --configure -a
  command -v ccache >/dev/null || { apt-get -q update; apt-get -q -y install --no-install-recommends ccache; }
  /src/scripts/install_dependencies.sh
  apt-get clean' >"$chroot.log" 2>&1 || fail 1 "packages: $(tail -n 5 "$chroot.log")"

say "building"
start=$SECONDS
# shellcheck disable=SC2016
inside '
  export CCACHE_DIR=/var/cache/ccache CCACHE_MAXSIZE=2G VIR_JOBS=$1
  ccache -z >/dev/null
  # Of the time of a compiler a third is saved; the figures do not depend on it.
  /src/scripts/build.sh --app-only "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG"
  ccache -s' "${VIR_JOBS:-}" >"$chroot.log" 2>&1 || {
  grep -E -A 5 'error|FAILED' "$chroot.log" | head -n 60 >&2 || tail -n 20 "$chroot.log" >&2
  fail 1 "it does not build on Debian 13 (all of it: $chroot.log)"
}
say "built in $((SECONDS - start)) s; compiler cache: $(grep -m 1 Hits: "$chroot.log" | tr -s ' ' || true)"

# Both errors of each robot, with ranges and without: "robot ranges ATE", metres with four decimals.
# shellcheck disable=SC2016
figures='
  program=$1 source=$2 results=$(mktemp -d)
  for rawlog in "$source"/rawlog/*.rawlog; do
    for ranges in true false; do
      "$program" run "$source/ini/euroc.ini" --rawlog "$rawlog" --out "$results/run" \
        --set Estimator.use_ranges=$ranges >"$results/log" 2>&1 </dev/null || { cat "$results/log" >&2; exit 1; }
      ate=$(sed -n "s/^ *\"ate_posyaw_m\": *\([0-9.e+-]*\),\{0,1\}$/\1/p" "$results/run/summary.json" | head -n 1)
      printf "%s ranges=%s %.4f\n" "$(basename "$rawlog" .rawlog)" "$ranges" "$ate"
      rm -rf "$results/run"
    done
  done
  rm -rf "$results"'
say "running the sample there and here"
there=$(inside "$figures" /src/build/bin/vir-slam /src) || fail 1 "the sample does not run on Debian 13"
here=$(bash -euo pipefail -c "$figures" bash "$reference" "$root") ||
  fail 1 "the sample does not run with $reference"
rm -rf "$chroot/src"

paste -d ' ' <(printf '%s\n' "$there") <(printf '%s\n' "$here") |
  awk 'BEGIN { printf "%-8s %-14s %10s %10s\n", "robot", "", "Debian 13", "here" }
       { printf "%-8s %-14s %10s %10s\n", $1, $2, $3, $6 }'
[ "$there" = "$here" ] || fail 1 "the figures of the sample [m] differ"
[ "$(wc -l <<<"$there")" -ge 4 ] || fail 1 "expected four figures"
say "the same figures"
