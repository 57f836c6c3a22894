#!/usr/bin/env python3
"""What the defaults of keyframes, iterations and patch are worth: one table over many runs.

  scripts/defaults_table.py OUT [RAWLOG ...] [--program PROGRAM] [--seeds 1 2]

Each RAWLOG is run from its beginning, with and without its ranges if it has any, and without from 4, 8 and 12 s on. Besides
come simulated flights as feature tracks with ranges to one anchor (ini/simulate_benchmark.ini): for every seed six as they
are, six hard ones (dark, losses, outliers) and three fast ones. Everything is kept in OUT, and what is there is not computed
again. Exit code: 0 the table is complete, 1 a run failed, 2 wrong usage.
"""
import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

SETTINGS = {
    "default": {},
    "10 keyframes": {"Window.keyframes": 10},
    "every 20 px": {"Window.keyframe_parallax_px": 20},
    "10, 20 px": {"Window.keyframes": 10, "Window.keyframe_parallax_px": 20},
    "1 iteration": {"Window.iterations": 1},
    "patch of 11 px": {"Tracker.patch_px": 11},
    "10, 20 px, 1, 11 px": {
        "Window.keyframes": 10,
        "Window.keyframe_parallax_px": 20,
        "Window.iterations": 1,
        "Tracker.patch_px": 11,
    },
}

FLIGHTS = {
    "eight": {},
    "corridor": {"Flight.length_m": 150, "Scene.layout": "corridors", "SimulatedRanges.anchor_m": "10 1 2"},
    "route": {"Flight.length_m": 120, "SimulatedRanges.anchor_m": "8 6 2.5"},
    "helix": {"Flight.length_m": 90},
    "warehouse": {"Flight.length_m": 150, "SimulatedRanges.anchor_m": "6 8 3"},
    "stop_and_go": {"Flight.length_m": 80},
}
# As [Condition_hard] of ini/benchmark.ini.
HARD = {
    "SimulatedRanges.nlos_share": 0.15,
    "SimulatedRanges.nlos_burst_s": 2,
    "SimulatedRanges.outage_s": "40 48",
    "SimulatedRanges.dropped_share": 0.1,
    "SimulatedTracks.blackout_s": "20 22 50 52",
    "SimulatedTracks.outlier_share": 0.05,
    "SimulatedTracks.mean_track_images": 20,
}
FAST = {"Flight.speed_mps": 3.5}
FAST_FLIGHTS = ("eight", "warehouse", "route")
OFFSETS_S = (4, 8, 12)
NO_RANGES = "_no_ranges"


def assignments(values):
    words = []
    for key, value in values.items():
        words += ["--set", f"{key}={value}"]
    return words


def call(command):
    """True if it succeeds; what it says is shown if it does not."""
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or [""]
        print(f"defaults_table: exit code {done.returncode} of {' '.join(command)}: {last[0]}", file=sys.stderr)
    return done.returncode == 0


def simulated(program, out, name, values):
    """The rawlog; None if it cannot be made."""
    rawlog = out / "recordings" / f"{name}.rawlog"
    ready = rawlog.with_suffix(".ready")
    if not ready.exists():
        rawlog.parent.mkdir(parents=True, exist_ok=True)
        world = str(ROOT / "ini" / "simulate_benchmark.ini")
        if not call([program, "--force", "simulate", world, "--out", str(rawlog)] + assignments(values)):
            return None
        ready.touch()
    return rawlog


def cases(rawlogs, seeds):
    """Name, rawlog or what to simulate, settings of the run."""
    no_ranges = {"Estimator.use_ranges": "false"}
    for path in rawlogs:
        name = pathlib.Path(path).stem
        yield name, path, {}
        yield name + NO_RANGES, path, no_ranges
        for offset in OFFSETS_S:
            yield f"{name}_from_{offset}_s", path, {**no_ranges, "Estimator.start_offset_s": offset}
    for seed in seeds:
        for flight, world in FLIGHTS.items():
            base = {"Robot_A.flight": flight, "simulator.seed": seed, **world}
            yield f"{flight}-{seed}", base, {}
            yield f"{flight}-hard-{seed}", {**base, **HARD}, {}
            if flight in FAST_FLIGHTS:
                yield f"{flight}-fast-{seed}", {**base, **FAST}, {}


def compute(program, out, rawlogs, seeds):
    """{case: {setting: summary}}; None in place of a summary where a run failed."""
    results = {}
    for name, source, values in cases(rawlogs, seeds):
        with_ranges = name.endswith(NO_RANGES) and results[name[: -len(NO_RANGES)]]["default"]
        if with_ranges and with_ranges["ranges"]["collected"] == 0:
            continue
        rawlog = source if isinstance(source, str) else simulated(program, out, name, source)
        results[name] = {}
        for number, (setting, changed) in enumerate(SETTINGS.items()):
            folder = out / "runs" / name / str(number)
            summary = folder / "summary.json"
            command = [program, "--force", "run", str(ROOT / "ini" / "euroc.ini"), "--rawlog", str(rawlog)]
            command += ["--out", str(folder)] + assignments({**values, **changed})
            good = summary.exists() or (rawlog is not None and call(command))
            results[name][setting] = json.loads(summary.read_text()) if good else None
        print(f"defaults_table: {name}", file=sys.stderr)
    return results


def table(results):
    """Markdown: per setting its errors, each run's as a ratio to the default's of the same recording, and CPU time."""
    whole = [r for r in results.values() if all(r.values())]
    lines = [
        f"{len(whole)} runs of each setting.",
        "",
        "| setting | ATE: mean [m] | ratio: geometric mean | worst | NEES: mean | not `good` | CPU [ms/image]: of images | of tracks |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for setting in SETTINGS:
        rows = [r[setting] for r in whole]
        ratios = [r[setting]["ate_posyaw_m"] / r["default"]["ate_posyaw_m"] for r in whole]
        cpu = {"images": [], "tracks": []}
        for name, r in results.items():
            if all(r.values()):
                cpu["tracks" if "-" in name else "images"].append(r[setting]["cpu_ms_per_frame"])
        mean = lambda values: f"{statistics.mean(values):.2f}" if values else "-"
        lines.append(
            f"| {setting} | {statistics.mean(r['ate_posyaw_m'] for r in rows):.4f} "
            f"| {math.exp(statistics.mean(map(math.log, ratios))):.3f} | {max(ratios):.2f} "
            f"| {mean([r['nees_position'] for r in rows])} | {sum(r['verdict'] != 'good' for r in rows)} "
            f"| {mean(cpu['images'])} | {mean(cpu['tracks'])} |"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("rawlog", nargs="*")
    parser.add_argument("--program", default=str(ROOT / "build" / "bin" / "vir-slam"))
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    arguments = parser.parse_args()
    for path in [arguments.program] + arguments.rawlog:
        if not os.path.isfile(path):
            parser.error(f"there is no file {path}")
    results = compute(arguments.program, arguments.out, arguments.rawlog, arguments.seeds)
    print(table(results))
    return 0 if all(all(r.values()) for r in results.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
