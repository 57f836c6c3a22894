#!/bin/bash
# Which lines of libs/ do the unit tests run? Builds with gcov's counters, runs the tests of each library, and
# writes a report per library to build-coverage/report/: NAME.txt, NAME.html, and summary.txt over all.
#   scripts/coverage.sh [LIBRARY...]
#     LIBRARY  only these, each by its own tests (tests/unit/NAME); none: all of them
# At the end come the lines that throw or refuse and that no test reaches: what guards data should be reached.
# Environment: VIR_JOBS = compilers at a time.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=$root/build-coverage
report=$build/report
case "${1:-}" in
  -h | --help)
    sed -n '2,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
command -v gcovr >/dev/null || { echo "coverage: gcovr is missing (scripts/install_dependencies.sh --dev)" >&2; exit 1; }
libraries=("$@")
if [ ${#libraries[@]} -eq 0 ]; then
  for folder in "$root"/tests/unit/*/; do
    name=$(basename "$folder")
    if [ -d "$root/libs/$name/src" ]; then libraries+=("$name"); fi
  done
fi
targets=()
for name in "${libraries[@]}"; do
  [ -d "$root/libs/$name" ] && [ -d "$root/tests/unit/$name" ] ||
    { echo "coverage: no library with tests: $name" >&2; exit 2; }
  targets+=(--target "test_$name")
done
"$root/scripts/build.sh" --build-dir "$build" -DCMAKE_BUILD_TYPE=Debug \
  -DVIR_COVERAGE=ON "-DCMAKE_CXX_FLAGS=-O1 -fprofile-abs-path" "${targets[@]}"
mkdir -p "$report"
: >"$report/summary.txt"
failed=0
for name in "${libraries[@]}"; do
  # What tests of other libraries run does not count.
  find "$build" -name '*.gcda' -delete
  (cd "$build" && "bin/test_$name" >"$report/$name.log" 2>&1) || { echo "$name: tests fail, see $report/$name.log"; failed=1; }
  gcovr --root "$root" --object-directory "$build" --filter "$root/libs/$name/" --exclude-unreachable-branches \
    --txt "$report/$name.txt" --html-details "$report/$name.html" --json "$report/$name.json" \
    --print-summary "$build/libs/$name" "$build/tests/unit/$name" 2>>"$report/$name.log" |
    sed -n "s/^lines: \(.*\)/$name: lines \1/p" | tee -a "$report/summary.txt"
done
echo
python3 - "$report" "$root" "${libraries[@]}" <<'END' | tee "$report/unreached_errors.txt"
import json, re, sys
report, root, libraries = sys.argv[1], sys.argv[2], sys.argv[3:]
guard = re.compile(r"\bthrow\b|\brefuse\w*\(|\bcannot\w*\(|\bfail\w*\(")
for name in libraries:
    for file in json.load(open(f"{report}/{name}.json"))["files"]:
        text = open(f"{root}/{file['file']}", encoding="utf-8").read().split("\n")
        for line in file["lines"]:
            code = text[line["line_number"] - 1].strip()
            if line["count"] == 0 and not line.get("gcovr/noncode") and guard.search(code):
                print(f"{file['file']}:{line['line_number']}: {code}")
END
exit $failed
