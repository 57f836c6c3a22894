#!/bin/bash
# Starts the estimator at evenly spaced points of one recording and prints how each start went.
#   scripts/restart_check.sh INI RAWLOG [GT.tum|''] [COUNT]
#     GT.tum   ground truth for a rawlog that holds none; '' or left out: the one in the rawlog
#     COUNT    how many starts (20), spread over the recording except its last 3 s
# Environment: VIR_SLAM = the program (default: build/bin/vir-slam of this source tree, else the one
# in PATH). Exit code 1 when a start found no pose.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

if [ $# -lt 2 ] || [ $# -gt 4 ]; then
  sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
ini=$1 rawlog=$2 truth=${3:-} count=${4:-20}
case "$count" in
  '' | *[!0-9]* | 0) echo "restart_check.sh: COUNT must be a number above 0, not '$count'" >&2; exit 2 ;;
esac
for file in "$ini" "$rawlog" ${truth:+"$truth"}; do
  [ -f "$file" ] || { echo "restart_check.sh: there is no such file: $file" >&2; exit 2; }
done
program=${VIR_SLAM:-$root/build/bin/vir-slam}
[ -x "$program" ] || program=$(command -v vir-slam) || {
  echo "restart_check.sh: build vir-slam first (scripts/build.sh) or set VIR_SLAM" >&2
  exit 2
}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# value FILE KEY: of a number or null on a line of its own in json; - when there is none.
value() {
  local v
  v=$(sed -n 's/^ *"'"$2"'": *\([-+0-9.eE]*\|null\),\{0,1\}$/\1/p' "$1" | head -n 1)
  if [ -z "$v" ] || [ "$v" = null ]; then echo -; else echo "$v"; fi
}

# run OFFSET: "first_pose ate resets".
run() {
  local out=$folder/out ate
  rm -rf "$out"
  "$program" run "$ini" --rawlog "$rawlog" --out "$out" --set "Estimator.start_offset_s=$1" \
    > "$folder/text" 2>&1 || true
  if [ ! -f "$out/summary.json" ]; then
    cat "$folder/text" >&2
    return 1
  fi
  ate=$(value "$out/summary.json" ate_posyaw_m)
  if [ -n "$truth" ] && "$program" evaluate "$out/trajectory.tum" --reference "$truth" \
    --json "$folder/evaluation.json" > /dev/null 2>&1; then
    ate=$(sed -n '/"ate_position_m"/,/}/s/^ *"rmse": *\([-+0-9.eE]*\),\{0,1\}$/\1/p' \
      "$folder/evaluation.json" | head -n 1)
  fi
  echo "$(value "$out/summary.json" init_time_s) ${ate:--} $(value "$out/summary.json" resets)"
}

# The length comes from the first run, which starts where the recording does.
first=$(run 0)
duration=$(value "$folder/out/summary.json" duration_s)
echo "$count starts in $rawlog, $duration s of images"
printf '%10s %16s %9s %7s\n' 'offset [s]' 'first pose [s]' 'ATE [m]' resets
for ((i = 0; i < count; ++i)); do
  offset=$(awk -v d="$duration" -v i="$i" -v n="$count" \
    'BEGIN { d -= 3; if (d < 0) d = 0; printf("%.2f", (n > 1) ? d * i / (n - 1) : 0) }')
  if [ "$i" -eq 0 ]; then line=$first; else line=$(run "$offset"); fi
  # shellcheck disable=SC2086
  set -- $line
  echo "$offset $1 $2 $3" >> "$folder/table"
  awk -v o="$offset" -v p="$1" -v a="$2" -v r="$3" 'BEGIN {
    printf "%10.2f %16s %9s %7s\n", o, p == "-" ? p : sprintf("%.2f", p),
           a == "-" ? a : sprintf("%.4f", a), r }'
done

awk '{ if ($2 == "-") none += 1; else if ($2 + 0 > slow) { slow = $2 + 0; slow_at = $1 }
       if ($3 != "-" && $3 + 0 > ate) { ate = $3 + 0; ate_at = $1 }
       if ($4 != "-") resets += $4 }
     END { printf "\nno pose: %d of %d; resets: %d\n", none, NR, resets
           if (none < NR) printf "slowest start: %.2f s, at offset %s s\n", slow, slow_at
           if (ate != "") printf "largest ATE: %.4f m, at offset %s s\n", ate, ate_at
           exit none > 0 ? 1 : 0 }' "$folder/table"
