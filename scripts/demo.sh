#!/bin/bash
# From a fresh checkout to a trajectory: installs what is missing, builds, imports a recording, runs
# it, and evaluates it where there is ground truth.
#   scripts/demo.sh [EUROC_FOLDER]
# EUROC_FOLDER is a folder in EuRoC's layout (the one with mav0, or mav0 itself; TUM-VI's have the
# same layout). Without it the two-robot sample in rawlog/ is used, with its ranges and without, and
# both errors are shown. Results go to results/demo-<stamp>.
# Exit code: 0 done, 1 a step failed, 2 wrong usage.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() { sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
say() { printf '\n== %s\n' "$*"; }

[ $# -le 1 ] || { usage >&2; exit 2; }
case "${1:-}" in
  -h | --help) usage; exit 0 ;;
  -*) echo "demo: unknown argument '$1'" >&2; exit 2 ;;
esac

source_folder=""
samples=()
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
    if [ -f "$file" ]; then samples+=("$file"); fi
  done
  if [ ${#samples[@]} -eq 0 ]; then
    echo "demo: rawlog/ holds no sample (was the checkout complete?); rawlog/README.md says how it is" >&2
    echo "  made. Or give a folder in EuRoC's layout: scripts/demo.sh ~/data/MH_01_easy" >&2
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

# Both errors of the sample, with its ranges and without.
run_samples() {
  local rawlog name use table=""
  for rawlog in "${samples[@]}"; do
    name=$(basename "$rawlog" .rawlog)
    for use in true false; do
      say "$name, ranges: $use"
      "$vir_slam" run "$root/ini/euroc.ini" --rawlog "$rawlog" --out "$out/$name-ranges-$use" \
        --set Estimator.use_ranges=$use
      table+=$(sed -n 's/^ *"ate_posyaw_m": *\([0-9.e+-]*\).*/\1/p' \
        "$out/$name-ranges-$use/summary.json" | head -n 1)" "
    done
  done
  say "Error of the trajectory (ATE, position and yaw aligned) [m]"
  printf '%-20s %-12s %s\n' robot "with ranges" "without"
  # shellcheck disable=SC2086 # one word per number
  set -- $table
  for rawlog in "${samples[@]}"; do
    printf '%-20s %-12.4f %.4f\n' "$(basename "$rawlog" .rawlog)" "$1" "$2"
    shift 2
  done
}

if [ -z "$source_folder" ]; then
  run_samples
  say "Results are in $out; look at report.html in each folder"
  ls "$out"
  exit 0
fi

say "Importing $source_folder"
rawlog=$out/recording.rawlog
"$vir_slam" import euroc "$source_folder" --out "$rawlog"
reference=$(ground_truth "$source_folder")

say "Running the estimator on $rawlog"
results=$out/run # a run takes no folder that holds anything else
"$vir_slam" run "$root/ini/euroc.ini" --rawlog "$rawlog" --out "$results"

if [ -n "$reference" ]; then
  say "Comparing with $reference"
  images=()
  for file in "$source_folder"/{mav0/,}cam0/data.csv; do
    if [ -f "$file" ]; then images=(--images "$file"); fi
  done
  "$vir_slam" evaluate --reference "$reference" "$results/trajectory.tum" \
    ${images[@]+"${images[@]}"} --json "$results/evaluation.json" --plot "$results/evaluation.svg"
else
  say "No ground truth beside the recording: nothing to compare with"
fi

say "Summary"
cat "$results/summary.json"
say "Results are in $results; the recording is beside them"
ls "$results"
