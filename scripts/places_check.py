#!/usr/bin/env python3
"""How well do two robots with cameras find one another's world: by ranges, by images, by both?

Simulates pairs in one scene (ini/simulate_two_robots.ini with other seeds, both on eights that lie
beside one another), runs each robot with --save-map, and asks `vir-slam rendezvous`: by ranges alone,
by places alone, by both, each with and without the common anchor, and of strangers, whose scenes
differ:
  scripts/places_check.py FOLDER [--seeds 1 2 3] [--program build/bin/vir-slam]
What is in FOLDER already is used again. Exit code 0 if nothing was called `unique` that is off by
more than 0.5 m or 6 degrees.
"""
import argparse
import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WRONG_M, WRONG_DEG = 0.5, 6
RANGES, PLACES, ANCHORS = "Rendezvous.peer_label=", "Rendezvous.use_places=", "Rendezvous.use_anchors="
PATHS = ["Robot_B.flight=eight", "Robot_B.start_m=0.6 -0.8 0.3", "Robot_B.start_heading_deg=25"]
WAYS = {
    "ranges": [PLACES + "false"],
    "ranges, no anchor": [PLACES + "false", ANCHORS + "false"],
    "places": [RANGES + "NOBODY", ANCHORS + "false"],
    "both": [],
    "both, no anchor": [ANCHORS + "false"],
}


def shell(*words, allowed=(0,)):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode not in allowed:
        raise SystemExit(f"{' '.join(words)}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout


def flown(program, folder, seed):
    """Two robots' finished runs."""
    there = os.path.join(folder, f"seed{seed}")
    os.makedirs(there, exist_ok=True)
    if not os.path.exists(f"{there}/two_B.rawlog"):
        words = [program, "simulate", f"{ROOT}/ini/simulate_two_robots.ini", "--out",
                 f"{there}/two.rawlog"]
        for setting in PATHS + [f"simulator.seed={seed}"]:
            words += ["--set", setting]
        shell(*words)
    for robot in "AB":
        run = f"{there}/{robot}"
        if not os.path.exists(f"{there}/{robot}.virmap"):
            shell(program, "run", f"{there}/two_{robot}.rawlog", "--out", run, "--save-map",
                  f"{there}/{robot}.virmap", "--force")
    return there


def meet(program, a, b, out, way):
    words = [program, "rendezvous", f"{ROOT}/ini/two_robots.ini", "--rawlog", f"A={a}", "--rawlog",
             f"B={b}", "--out", out, "--force"]
    for setting in WAYS[way]:
        words += ["--set", setting]
    shell(*words, allowed=(0, 1))
    with open(f"{out}/transforms.json", encoding="utf-8") as file:
        transform = json.load(file)["transforms"][0]
    with open(f"{out}/summary.json", encoding="utf-8") as file:
        errors = json.load(file)["merge_errors"]
    return transform, errors[0] if errors else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--program", default=os.path.join(ROOT, "build/bin/vir-slam"))
    given = parser.parse_args()
    runs = {seed: flown(given.program, given.folder, seed) for seed in given.seeds}
    wrong = 0
    print("seed way                status       merged_m offset_m yaw_deg sigma_m places used")
    for seed, there in runs.items():
        for way in WAYS:
            out = f"{there}/{way.replace(', ', '_').replace(' ', '_')}"
            t, error = meet(given.program, f"{there}/A", f"{there}/B", out, way)
            numbers = "       -        -       -       -"
            if error:
                sigma = sum(t["covariance"][k][k] for k in (1, 2)) ** 0.5
                numbers = (f"{error['merged_rmse_m']:8.3f} {error['offset_error_m']:8.3f} "
                           f"{error['yaw_error_deg']:7.2f} {sigma:7.3f}")
                off = error["merged_rmse_m"] > WRONG_M or error["yaw_error_deg"] > WRONG_DEG
                wrong += t["status"] == "unique" and off
            print(f"{seed:4d} {way:18s} {t['status']:12s} {numbers} {t['places']:6d} {t['places_used']:4d}",
                  flush=True)
    seeds = list(runs)
    for one, other in zip(seeds, seeds[1:]):
        t, _ = meet(given.program, f"{runs[one]}/A", f"{runs[other]}/B", f"{runs[one]}/stranger", "places")
        print(f"A of {one} and B of {other}, of other scenes: {t['status']}, {t['places']} places", flush=True)
        wrong += t["status"] == "unique"
    print(f"{wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
