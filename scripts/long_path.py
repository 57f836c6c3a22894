#!/usr/bin/env python3
"""What a long path of odometry and ranges costs: a simulated mower.

Lanes a metre apart, up and down a field again and again, four anchors around it:
  scripts/long_path.py FOLDER [--metres 1932] [--lane-m 16] [--seed 0]
                       [--program build/bin/vir-slam]
Prints the estimator's CPU time per pose (`cpu_ms_per_frame` of summary.json), the whole process's,
and the ATE. The recording in FOLDER is used again if it is there. Exit code 0, or 1 if the run
failed.
"""
import argparse
import json
import math
import os
import resource
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SPEED_MPS, STEP_S, LANES, LANE_APART_M = 1.0, 0.02, 16, 1.0
RADIUS_M = LANE_APART_M / 2


def lane_of(k):
    """Which lane is the k-th driven: to the far side of the field and back."""
    k %= 2 * LANES
    return k if k < LANES else 2 * LANES - 1 - k


def pose_at(s, length):
    """x, y, heading after `s` metres: a lane, then half a circle to the next."""
    k, r = divmod(s, length + math.pi * RADIUS_M)
    k = int(k)
    ahead = 1 if k % 2 == 0 else -1
    y = lane_of(k) * LANE_APART_M
    heading = 0.0 if ahead > 0 else math.pi
    if r <= length:
        return (r if ahead > 0 else length - r), y, heading
    end_x, turned = (length if ahead > 0 else 0.0), (r - length) / RADIUS_M
    following = lane_of(k + 1) * LANE_APART_M
    side = (following > y) - (following < y)
    if side == 0:  # the last lane is driven twice
        return end_x + ahead * RADIUS_M * math.sin(2 * turned) / 2, y, heading + turned
    return (end_x + ahead * RADIUS_M * math.sin(turned),
            (y + following) / 2 - side * RADIUS_M * math.cos(turned),
            heading + ahead * side * turned)


def make(folder, options):
    rawlog = os.path.join(folder, "mower.rawlog")
    if os.path.exists(rawlog):
        return rawlog
    path = os.path.join(os.path.abspath(folder), "mower.tum")
    with open(path, "w", encoding="ascii") as out:
        for i in range(int(options.metres / SPEED_MPS / STEP_S) + 1):
            x, y, heading = pose_at(i * STEP_S * SPEED_MPS, options.lane_m)
            z = 0.15 * math.sin(0.11 * x) + 0.1 * math.sin(0.13 * y)
            out.write(f"{1000 + i * STEP_S:.3f} {x:.5f} {y:.5f} {z:.5f} 0 0 "
                      f"{math.sin(heading / 2):.7f} {math.cos(heading / 2):.7f}\n")
    ini = os.path.join(folder, "mower.ini")
    with open(ini, "w", encoding="ascii") as out:
        out.write(f"""[simulator]
seed = {options.seed}
images = none
odometry = true
gt_rate_hz = 10
[Robot_A]
trajectory = {path}
[SimulatedRanges]
anchor_m = -3 -4 2 20 -3 3 19 18 2.5 -4 17 3
rate_hz = 2
sigma_m = 0.1
correlated_sigma_m = 0.05
bias_m = 0.1
nlos_share = 0.05
nlos_burst_s = 3
[SimulatedOdometry]
rate_hz = 5
scale_error = 0.02
yaw_walk = 0.003
""")
    subprocess.run([options.program, "simulate", ini, "--out", rawlog], check=True,
                   stdout=subprocess.DEVNULL)
    return rawlog


def main():
    usage = argparse.ArgumentParser(description=__doc__,
                                    formatter_class=argparse.RawDescriptionHelpFormatter)
    usage.add_argument("folder")
    usage.add_argument("--metres", type=float, default=1932)
    usage.add_argument("--lane-m", type=float, default=16)
    usage.add_argument("--seed", type=int, default=0)
    usage.add_argument("--program", default=os.path.join(ROOT, "build/bin/vir-slam"))
    options = usage.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    rawlog = make(options.folder, options)
    results = os.path.join(options.folder, "run")
    shutil.rmtree(results, ignore_errors=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([options.program, "run", os.path.join(ROOT, "ini/odometry_range.ini"),
                          "--rawlog", rawlog, "--out", results], stdout=subprocess.PIPE,
                         stderr=subprocess.STDOUT, text=True, check=False)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode != 0:
        print(run.stdout, file=sys.stderr)
        return 1
    with open(os.path.join(results, "summary.json"), encoding="utf-8") as text:
        summary = json.load(text)
    with open(os.path.join(results, "trajectory.tum"), encoding="ascii") as lines:
        poses = sum(1 for line in lines if line[0] != "#")
    process_s = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
    print(f"{poses} poses: estimator {summary['cpu_ms_per_frame']:.2f} ms of CPU per pose, process "
          f"{process_s:.1f} s, ATE {summary['ate_posyaw_m']:.3f} m")
    return 0


if __name__ == "__main__":
    sys.exit(main())
