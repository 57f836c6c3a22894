#!/bin/bash
# From a fresh checkout to a trajectory: installs what is missing, builds, imports a recording, runs
# it, and evaluates it where there is ground truth.
#   scripts/demo.sh [EUROC_FOLDER]
# EUROC_FOLDER is a folder in EuRoC's layout (the one with mav0, or mav0 itself; TUM-VI's have the
# same layout). Without it the sample in rawlog/ is used. Results go to results/demo-<stamp>.
# Exit code: 0 done, 1 a step failed, 2 wrong usage.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() { sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
say() { printf '\n== %s\n' "$*"; }

[ $# -le 1 ] || { usage >&2; exit 2; }
case "${1:-}" in
  -h | --help) usage; exit 0 ;;
  -*) echo "demo: unknown argument '$1'" >&2; exit 2 ;;
esac

source_folder=""
rawlog=""
if [ -n "${1:-}" ]; then
  if [ ! -d "$1" ]; then
    echo "demo: '$1' is not a folder" >&2
    exit 2
  fi
  source_folder=$(cd "$1" && pwd)
  if [ ! -d "$source_folder/mav0" ] && [ ! -d "$source_folder/imu0" ]; then
    echo "demo: '$1' has neither mav0/ nor imu0/: give a folder in EuRoC's layout" >&2
    exit 2
  fi
else
  for file in "$root"/rawlog/*.rawlog; do
    if [ -f "$file" ]; then rawlog=$file; break; fi
  done
  if [ -z "$rawlog" ]; then
    echo "demo: there is no sample in rawlog/ yet: give a folder in EuRoC's layout, e.g." >&2
    echo "  scripts/demo.sh ~/data/MH_01_easy      (the folder that holds mav0/)" >&2
    exit 2
  fi
fi

# The ground truth of a EuRoC folder, in either layout; prints nothing if there is none.
ground_truth() {
  local mav0=$1/mav0 file
  [ -d "$mav0" ] || mav0=$1
  for file in "$mav0"/state_groundtruth_estimate0/{data.csv,gt_tum.txt} "$mav0"/mocap0/data.csv \
    "$mav0/../groundtruth.tum"; do
    if [ -f "$file" ]; then printf '%s\n' "$file"; return; fi
  done
}

say "Installing what is missing"
"$root/scripts/install_dependencies.sh"
say "Building"
"$root/scripts/build.sh" --app-only
vir_slam=$root/build/bin/vir-slam

out=$root/results/demo-$(date +%Y%m%d-%H%M%S)
mkdir -p "$out"
reference=""
if [ -n "$source_folder" ]; then
  say "Importing $source_folder"
  rawlog=$out/recording.rawlog
  "$vir_slam" import euroc "$source_folder" --out "$rawlog"
  reference=$(ground_truth "$source_folder")
elif [ -f "${rawlog%.rawlog}.gt.tum" ]; then
  reference=${rawlog%.rawlog}.gt.tum
fi

say "Running the estimator on $rawlog"
"$vir_slam" run "$root/ini/euroc.ini" --rawlog "$rawlog" --out "$out"

if [ -n "$reference" ]; then
  say "Comparing with $reference"
  images=()
  for file in "$source_folder"/{mav0/,}cam0/data.csv; do
    if [ -n "$source_folder" ] && [ -f "$file" ]; then images=(--images "$file"); fi
  done
  "$vir_slam" evaluate --reference "$reference" "$out/trajectory.tum" \
    ${images[@]+"${images[@]}"} --json "$out/evaluation.json" --plot "$out/evaluation.svg"
else
  say "No ground truth beside the recording: nothing to compare with"
fi

say "Summary"
if [ -f "$out/summary.json" ]; then cat "$out/summary.json"; echo; fi
say "Results are in $out"
ls "$out"
