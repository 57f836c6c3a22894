#!/bin/bash
# Records and estimates live for long, at real rate, while something goes wrong every minute, and says whether it
# held: memory flat within 5 MB, nothing lost but what was cut off, latency as at the start. Exit code 1 if not.
#   scripts/soak.sh [--build-dir DIR] [--keep DIR] [--images] [--calm] MINUTES
#     --build-dir DIR  where the program was built (default build)
#     --keep DIR       work there and leave recording, results and log, and take the flight that is there already
#                      (default: a folder that is removed)
#     --images         images of 752x480 instead of tracks (some 100 MB a minute, and half a minute to render)
#     --calm           nothing goes wrong: what the latency is (memory rises with --images: by the places)
# A flight is simulated (tracks, IMU, ranges); vir-device-emulator plays IMU and radio on pseudo-terminals, with a
# clock 200 ppm off, garbage and damaged bytes, and pulls both out for 1.5 s. Besides, each minute the host's clock
# is set, 60 clients that do not read come to the stream, and the program is stopped for 0.3 s.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build keep='' minutes='' look='tracks = true' labels=TRACKS0 calm=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build-dir) build=$(cd "$2" && pwd) && shift ;;
    --keep) keep=$2 && shift ;;
    --images) look='images = external' labels=CAM0 ;;
    --calm) calm=(--calm) ;;
    -h | --help)
      sed -n '2,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *) minutes=$1 ;;
  esac
  shift
done
[[ $minutes =~ ^[0-9]+$ ]] && [ "$minutes" -gt 0 ] || { "${BASH_SOURCE[0]}" --help >&2; exit 2; }
work=$keep
if [ -z "$keep" ]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
fi
mkdir -p "$work"
work=$(cd "$work" && pwd)

cat >"$work/world.ini" <<END
[simulator]
$look
gt_rate_hz = 5
[Robot_A]
flight = eight
length_m = $((minutes * 90 + 60))
speed_mps = 1.2
duration_s = $((minutes * 60 + 5))
[SimulatedRanges]
anchor_m = 3 2 2
END
if ! [ -f "$work/flight.rawlog" ] || ! cmp -s "$work/world.ini" "$work/made_of.ini"; then
  "$build/bin/vir-slam" simulate "$work/world.ini" --out "$work/flight.rawlog" >"$work/simulate.log" 2>&1 ||
    { cat "$work/simulate.log" >&2; exit 1; }
  cp "$work/world.ini" "$work/made_of.ini"
fi
python3 "$root/scripts/soak.py" --build-dir "$build" --work "$work" --minutes "$minutes" --labels "$labels" ${calm[@]+"${calm[@]}"}
