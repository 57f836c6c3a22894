#!/bin/sh
# The figure of docs/uwb.md: the same 600 m through a warehouse without ranges, with one anchor, with two.
#   scripts/uwb_figure.sh [FOLDER]     writes FOLDER/anchors.svg (default: a folder of its own)
# A minute and a half on one core. Turned into the page's picture by a browser and ImageMagick:
#   chromium --headless --screenshot=anchors.png --window-size=1200,1144 anchors.svg
#   convert anchors.png -resize 1000x -colors 32 anchors_small.png
set -eu
case "${1:-}" in
  -h | --help)
    sed -n '2,6s/^# \{0,1\}//p' "$0"
    exit 0
    ;;
  -*)
    echo "uwb_figure: unknown argument '$1' (see --help)" >&2
    exit 2
    ;;
esac
[ $# -le 1 ] || { echo "uwb_figure: unknown argument '$2' (see --help)" >&2; exit 2; }
slam=${VIR_SLAM:-$(dirname "$0")/../build/bin/vir-slam}
slam=$(realpath "$slam")
out=${1:-$(mktemp -d)}
mkdir -p "$out"
cd "$out"

world() {  # NAME ANCHORS
  "$slam" simulate --out "$1.rawlog" --set simulator.tracks=true --set Robot_A.flight=warehouse \
    --set Robot_A.length_m=600 --set "SimulatedRanges.anchor_m=$2"
}
world one '9 -6 2.5'
world two '9 -6 2.5 26 7 2.2'

"$slam" run one.rawlog --out run_none --set Estimator.use_ranges=false
"$slam" run one.rawlog --out run_one
"$slam" run two.rawlog --out run_two
"$slam" export two.rawlog --format tum --out truth
for anchors in none one two; do cp "run_$anchors/trajectory.tum" "$anchors.tum"; done
"$slam" evaluate --reference truth/GT.tum none.tum one.tum two.tum --plot anchors.svg
echo "Written: $out/anchors.svg"
