#!/bin/bash
# Builds the Debian packages vir-slam_*.deb (programs, plugins, settings) and libvir-slam-dev_*.deb
# (headers and libraries) for the Debian this runs on.
#   scripts/package.sh [--out DIR] [--build-dir DIR] [--no-build]
#     --out DIR        where they go (default: packages/ of the checkout)
#     --build-dir DIR  as for scripts/build.sh (default: build/)
#     --no-build       package what has been built there
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

out=$root/packages
build_dir=$root/build
build=true
while [ $# -gt 0 ]; do
  case "$1" in
    --out | --build-dir)
      [ $# -ge 2 ] || { echo "package: $1 needs a folder" >&2; exit 2; }
      if [ "$1" = --out ]; then out=$2; else build_dir=$2; fi
      shift
      ;;
    --no-build) build=false ;;
    -h | --help)
      sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *)
      echo "package: unknown argument '$1' (see --help)" >&2
      exit 2
      ;;
  esac
  shift
done
command -v dpkg-shlibdeps >/dev/null || {
  echo "package: dpkg-shlibdeps is missing; it is in Debian's dpkg-dev" >&2
  exit 1
}

if $build; then "$root/scripts/build.sh" --build-dir "$build_dir" --app-only; fi
mkdir -p "$out"
out=$(cd "$out" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! cpack --config "$build_dir/CPackConfig.cmake" -B "$work" >"$work/log" 2>&1; then
  cat "$work/log" >&2
  exit 1
fi
mv "$work"/*.deb "$out"
ls "$out"/*.deb
