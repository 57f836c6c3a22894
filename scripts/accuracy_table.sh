#!/bin/bash
# Makes README's tables of accuracy again, from recordings to numbers.
#   scripts/accuracy_table.sh [--build-dir DIR] [--out DIR] [--peer NAME=FOLDER]... RECORDING...
#     RECORDING      folder in EuRoC's layout, with its ground truth; the first table has a row each
#     --peer         trajectories of another program for the same recordings, FOLDER/<name of the recording>.tum,
#                    evaluated the same way (causal: each pose as it was known at its image)
#     --made-up      the second table too: made-up flights with ranges (vir-slam batch ini/benchmark.ini; hours)
#     --build-dir    where the program was built (default build)
#     --out          results are kept there (default results/accuracy)
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build out=results/accuracy made_up=false recordings=() peers=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build-dir | --out | --peer)
      [ $# -ge 2 ] || { echo "accuracy_table: $1 needs a value" >&2; exit 2; }
      case "$1" in
        --build-dir) build=$2 ;;
        --out) out=$2 ;;
        --peer) peers+=("$2") ;;
      esac
      shift
      ;;
    --made-up) made_up=true ;;
    -h | --help)
      sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -*)
      echo "accuracy_table: unknown argument '$1' (see --help)" >&2
      exit 2
      ;;
    *)
      [ -d "$1" ] || { echo "accuracy_table: $1 is no folder of a recording" >&2; exit 2; }
      recordings+=("$1")
      ;;
  esac
  shift
done
[ ${#recordings[@]} -gt 0 ] || $made_up || { "${BASH_SOURCE[0]}" --help >&2; exit 2; }
program=$build/bin/vir-slam
[ -x "$program" ] || { echo "accuracy_table: there is no $program: scripts/build.sh" >&2; exit 1; }
mkdir -p "$out"

number() { # FILE KEY DECIMALS
  python3 -c 'import json, sys
value = json.load(open(sys.argv[1])).get(sys.argv[2])
print("-" if value is None else f"{value:.{sys.argv[3]}f}")' "$@"
}

truth_of() { # FOLDER: a file of the reference trajectory
  local state=$1/mav0/state_groundtruth_estimate0
  for file in "$1/groundtruth.tum" "$state/gt_tum.txt" "$state/data.csv"; do
    [ -f "$file" ] && { echo "$file"; return; }
  done
  echo "accuracy_table: $1 has no groundtruth.tum and no $state" >&2
  exit 1
}

[ ${#recordings[@]} -eq 0 ] || echo '| recording | program | error [m] | first pose [s] | CPU per image [ms] | verdict |
|---|---|---|---|---|---|'
for folder in ${recordings[@]+"${recordings[@]}"}; do
  name=$(basename "$folder")
  "$program" --force import euroc "$folder" --out "$out/$name.rawlog" >"$out/$name.import.log" 2>&1
  "$program" run "$out/$name.rawlog" --set Estimator.use_ranges=false --out "$out/$name" >"$out/$name.run.log" 2>&1
  summary=$out/$name/summary.json
  echo "| $name | vir-slam | $(number "$summary" ate_posyaw_m 4) | $(number "$summary" init_time_s 2) |" \
    "$(number "$summary" cpu_ms_per_frame 1) | $(python3 -c 'import json, sys
print(json.load(open(sys.argv[1]))["verdict"])' "$summary") |"
  for peer in ${peers[@]+"${peers[@]}"}; do
    file=${peer#*=}/$name.tum
    [ -f "$file" ] || continue
    "$program" evaluate --reference "$(truth_of "$folder")" "$file" --json "$out/$name.${peer%%=*}.json" >/dev/null
    echo "| $name | ${peer%%=*} | $(python3 -c 'import json, sys
print("%.4f" % json.load(open(sys.argv[1]))["estimates"][0]["ate_position_m"]["rmse"])' "$out/$name.${peer%%=*}.json") | | | |"
  done
done
if $made_up; then "$program" batch "$root/ini/benchmark.ini" --out "$out/made_up"; fi
