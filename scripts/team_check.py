#!/usr/bin/env python3
"""Do robots that meet live, each a process of its own, learn where all others are?

Simulates robots with odometry, ranges to one anchor and to each other, plays each as if live into
`vir-slam record` with a team over DDS on this machine, and holds everybody's map of the team
against the truth:
  scripts/team_check.py FOLDER [--robots 10] [--seconds 75] [--lost 0.3] [--late-s 0] [--seed 0]
                        [--program build/bin/vir-slam] [--relay build/bin/vir_test_dds_relay]
With --lost or --late-s what robots tell goes through a relay that loses so much of it, or delivers
it up to so late (built with the tests). Exit code 0 if everybody has placed everybody within
0.15 m horizontally, 1 if not, 2 for wrong usage.

Errors are where a robot is told to be in the common frame, against where it is by the truth (each
one's trajectory laid onto its own truth), in the middle of its path.
"""
import argparse
import glob
import json
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PLACED_M = 0.15
FLIGHTS = ("eight", "letter_s", "helix", "letter_m", "letter_i")


def world(names, seconds, seed):
    text = f"""[simulator]
robots = {' '.join(names)}
seed = {seed}
images = none
odometry = true
gt_rate_hz = 20
[Flight]
length_m = {0.9 * seconds:.0f}
speed_mps = 0.9
rest_s = 2
height_m = 0.6
[SimulatedRanges]
anchor_m = 2.5 3.5 2.2
rate_hz = 10
sigma_m = 0.05
correlated_sigma_m = 0.03
nlos_share = 0.03
[SimulatedTeam]
peer_rate_hz = 5
[SimulatedOdometry]
scale_error = 0.01
scale_wander = 0.004
yaw_walk = 0.001
position_walk = 0.003
"""
    for i, name in enumerate(names):
        text += (f"[Robot_{name}]\nflight = {FLIGHTS[i % len(FLIGHTS)]}\nduration_s = {seconds}\n"
                 f"start_m = {3 * (i % 4)} {3 * (i // 4)} 0.3\nstart_heading_deg = {37 * i % 180}\n")
    return text


def robot_ini(rawlog, number, start_s, domain, team):
    return f"""[Recording]
estimate = true
[Estimator]
driver = odometry
[all]
driver = RawlogReplay
process_rate = 200
rawlog = {rawlog}
labels = ODOM UWB0 PEER GT
clock = keep
stamps = now
start_at_s = {start_s}
[Dds]
robot = {number}
domain = {domain}
team = {team}
"""


def tum(file):
    with open(file, encoding="ascii") as lines:
        return [[float(x) for x in line.split()[:4]] for line in lines if line[0] not in "#\n"]


def laid_onto(path, truth):
    """Yaw and offset that lay a path onto the truth, at the truth's nearest stamps."""
    pairs, k = [], 0
    for t, *p in path:
        while k + 1 < len(truth) and abs(truth[k + 1][0] - t) <= abs(truth[k][0] - t):
            k += 1
        if abs(truth[k][0] - t) < 0.06:
            pairs.append((p, truth[k][1:]))
    n = len(pairs)
    a = [sum(p[i] for p, _ in pairs) / n for i in range(3)]
    b = [sum(q[i] for _, q in pairs) / n for i in range(3)]
    s = sum((p[0] - a[0]) * (q[1] - b[1]) - (p[1] - a[1]) * (q[0] - b[0]) for p, q in pairs)
    c = sum((p[0] - a[0]) * (q[0] - b[0]) + (p[1] - a[1]) * (q[1] - b[1]) for p, q in pairs)
    yaw = math.atan2(s, c)
    turned = moved((yaw, (0, 0, 0)), a)
    return (yaw, tuple(b[i] - turned[i] for i in range(3))), a


def moved(world_of, p):
    yaw, t = world_of
    c, s = math.cos(yaw), math.sin(yaw)
    return (c * p[0] - s * p[1] + t[0], s * p[0] + c * p[1] + t[1], p[2] + t[2])


def back(world_of, p):
    yaw, t = world_of
    d = [p[i] - t[i] for i in range(3)]
    c, s = math.cos(-yaw), math.sin(-yaw)
    return (c * d[0] - s * d[1], s * d[0] + c * d[1], d[2])


def prepared(options):
    os.makedirs(options.folder, exist_ok=True)
    names = [chr(ord("A") + i) for i in range(options.robots)]
    ini = os.path.join(options.folder, "world.ini")
    with open(ini, "w", encoding="ascii") as out:
        out.write(world(names, options.seconds, options.seed))
    for old in glob.glob(os.path.join(options.folder, "team*")):
        os.remove(old)
    subprocess.run([options.program, "simulate", ini, "--out",
                    os.path.join(options.folder, "team.rawlog")], check=True,
                   stdout=subprocess.DEVNULL)
    for old in glob.glob(os.path.join(options.folder, "live_*")):
        shutil.rmtree(old) if os.path.isdir(old) else os.remove(old)
    return names


def played(options, names):
    """Runs all robots; exit codes, and CPU seconds of all of them."""
    start_s = int(time.time()) + 4 + options.robots
    domain = 1 + os.getpid() % 100
    bad = options.lost > 0 or options.late_s > 0
    teams = [f"check{os.getpid()}" + (name if bad else "") for name in names]
    relay = None
    if bad:
        relay = subprocess.Popen([options.relay, str(domain), str(options.lost),
                                  str(options.late_s), "0", *teams])
    robots = []
    for i, name in enumerate(names):
        base = os.path.join(options.folder, f"live_{name}")
        rawlog = os.path.abspath(os.path.join(options.folder, f"team_{name}.rawlog"))
        with open(base + ".ini", "w", encoding="ascii") as out:
            out.write(robot_ini(rawlog, i, start_s, domain, teams[i]))
        with open(base + ".txt", "w", encoding="utf-8") as said:
            robots.append(subprocess.Popen(
                [options.program, "record", base + ".ini", "--out", base + ".rawlog", "--results",
                 base], stdout=said, stderr=subprocess.STDOUT))
    time.sleep(max(0.0, start_s + options.seconds - time.time()))
    for robot in robots:
        robot.send_signal(signal.SIGINT)
    codes = [robot.wait() for robot in robots]
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if relay is not None:
        relay.kill()
        relay.wait()
    return codes, used.ru_utime + used.ru_stime


def judged(options, names):
    """Horizontal errors of everybody in everybody's map; None where somebody is missing."""
    worlds, middles = [], []
    for name in names:
        base = os.path.join(options.folder, f"live_{name}")
        subprocess.run([options.program, "export", base + ".rawlog", "--format", "tum", "--out",
                        base + "_tum"], check=True, stdout=subprocess.DEVNULL)
        truth = tum(glob.glob(base + "_tum/*GT*.tum")[0])
        placed, middle = laid_onto(tum(os.path.join(base, "trajectory.tum")), truth)
        worlds.append(placed)
        middles.append(middle)
    errors = []
    for name in names:
        file = os.path.join(options.folder, f"live_{name}", "team.json")
        team = {}
        if os.path.exists(file):
            with open(file, encoding="utf-8") as text:
                team = json.load(text)
        found = {r["id"]: r for r in team.get("robots", [])}
        root = team.get("frame", {}).get("robot")
        for other in range(len(names)):
            r = found.get(other)
            if r is None or r.get("t") is None or root is None:
                errors.append(None)
                continue
            told = moved((r["yaw"], r["t"]), middles[other])
            true = back(worlds[root], moved(worlds[other], middles[other]))
            errors.append(math.hypot(told[0] - true[0], told[1] - true[1]))
    return errors


def main():
    usage = argparse.ArgumentParser(description=__doc__,
                                    formatter_class=argparse.RawDescriptionHelpFormatter)
    usage.add_argument("folder")
    usage.add_argument("--robots", type=int, default=10, choices=range(2, 27), metavar="2..26")
    usage.add_argument("--seconds", type=int, default=75)
    usage.add_argument("--lost", type=float, default=0.0)
    usage.add_argument("--late-s", type=float, default=0.0)
    usage.add_argument("--seed", type=int, default=0)
    usage.add_argument("--program", default=os.path.join(ROOT, "build/bin/vir-slam"))
    usage.add_argument("--relay", default=os.path.join(ROOT, "build/bin/vir_test_dds_relay"))
    options = usage.parse_args()
    if not 20 <= options.seconds <= 3600:
        usage.error("--seconds: 20 to 3600")
    if not 0 <= options.lost < 1 or not 0 <= options.late_s <= 60:
        usage.error("--lost: from 0 to less than 1; --late-s: 0 to 60")
    bad_network = options.lost > 0 or options.late_s > 0
    for program in [options.program] + [options.relay] * bad_network:
        if not os.access(program, os.X_OK) or os.path.isdir(program):
            usage.error(f"{program} is no program: scripts/build.sh, or --program and --relay")
    names = prepared(options)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    codes, used = played(options, names)
    used -= before.ru_utime + before.ru_stime
    errors = judged(options, names)
    known = [e for e in errors if e is not None]
    print(f"{options.robots} robots, {options.seconds} s, {100 * options.lost:.0f} % lost, up to "
          f"{options.late_s:g} s late: {len(known)} of {len(errors)} placed, mean "
          f"{sum(known) / max(1, len(known)):.3f} m, worst {max(known, default=math.nan):.3f} m; CPU "
          f"{1000 * used / options.robots / options.seconds:.1f} ms per robot and second")
    if any(codes):
        print(f"exit codes {codes}: see live_*.txt", file=sys.stderr)
    placed = len(known) == len(errors) and max(known) <= PLACED_M
    return 0 if placed and not any(codes) else 1


if __name__ == "__main__":
    sys.exit(main())
