#!/usr/bin/env python3
"""How often, how soon and how well is a run found in the map of an earlier one?

Renders two flights of one place (ini/simulate_relocalise.ini; other path, other light) and one of
another place, maps the first, and begins short runs at random times of the others:
  scripts/relocalise_check.py FOLDER [--starts 100] [--strangers 20] [--program build/bin/vir-slam]
What is in FOLDER already is used again: recordings of one's own may lie there as map.rawlog,
again.rawlog and strange.rawlog. Ground truth must be in one world for the first two. Exit code 0 if
nothing was found wrong (off by more than 0.3 m or 6 degrees, or in another place).

Errors are against the truth laid onto the map by position and yaw (the map's own error is in them),
and against the truth laid onto the map's keyframes nearby alone.
"""
import argparse
import bisect
import csv
import json
import math
import os
import random
import shutil
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WRONG_M, WRONG_DEG = 0.3, 6
NEAR_M, NEAR_DEG = 0.05, 1
MOVED_M = 1e-6  # in its own frame and in the map's


def shell(*words, allowed=(0,)):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode not in allowed:
        raise SystemExit(f"{' '.join(words)}: exit code {done.returncode}\n{done.stdout}")


def times(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def angle_deg(a, b):
    d = abs(sum(x * y for x, y in zip(a, b)))
    return math.degrees(2 * math.acos(min(1.0, d)))


class Path:
    """Poses of a TUM file: t, position, quaternion x y z w."""

    def __init__(self, file):
        self.rows = []
        if not os.path.exists(file):
            file = os.devnull
        with open(file, encoding="ascii") as lines:
            for line in lines:
                if line.strip() and line[0] != "#":
                    v = [float(x) for x in line.split()]
                    self.rows.append((v[0], v[1:4], v[4:8]))
        self.t = [r[0] for r in self.rows]

    def at(self, t):
        """Between the neighbours by time; None outside."""
        k = bisect.bisect_left(self.t, t)
        if k < len(self.t) and self.t[k] == t:
            return self.rows[k][1:]
        if k == 0 or k == len(self.t):
            return None
        (ta, pa, qa), (tb, pb, qb) = self.rows[k - 1], self.rows[k]
        u = (t - ta) / (tb - ta)
        sign = 1 if sum(x * y for x, y in zip(qa, qb)) >= 0 else -1
        q = [(1 - u) * x + u * sign * y for x, y in zip(qa, qb)]
        n = math.sqrt(sum(x * x for x in q))
        return [x + u * (y - x) for x, y in zip(pa, pb)], [x / n for x in q]


class Level:
    """A turn about z and an offset, fitted to pairs of positions."""

    def __init__(self, pairs):
        n = len(pairs)
        ca = [sum(a[k] for a, _ in pairs) / n for k in range(3)]
        cb = [sum(b[k] for _, b in pairs) / n for k in range(3)]
        s = c = 0.0
        for a, b in pairs:
            ax, ay, bx, by = a[0] - ca[0], a[1] - ca[1], b[0] - cb[0], b[1] - cb[1]
            s += ax * by - ay * bx
            c += ax * bx + ay * by
        self.yaw = math.atan2(s, c)
        self.t = [0, 0, 0]
        self.t = [y - x for x, y in zip(self.point(ca), cb)]

    def point(self, p):
        s, c = math.sin(self.yaw), math.cos(self.yaw)
        return [c * p[0] - s * p[1] + self.t[0], s * p[0] + c * p[1] + self.t[1], p[2] + self.t[2]]

    def pose(self, pose):
        p, q = pose
        return self.point(p), times((0, 0, math.sin(self.yaw / 2), math.cos(self.yaw / 2)), q)


class Map:
    def __init__(self, run, truth):
        path = Path(os.path.join(run, "trajectory_smoothed.tum"))
        self.pairs = [(truth.at(t)[0], p) for t, p, _ in path.rows if truth.at(t)]
        self.world = Level(self.pairs)
        self.error_m = math.sqrt(sum(math.dist(self.world.point(a), b)**2 for a, b in self.pairs) /
                                 len(self.pairs))

    def nearby(self, p, count=12):
        """The world laid onto the keyframes nearest to a place of the truth."""
        return Level(sorted(self.pairs, key=lambda pair: math.dist(pair[0], p))[:count])


def prepare(program, folder):
    ini = os.path.join(ROOT, "ini", "simulate_relocalise.ini")
    dim = ("simulator.robot=B", "SimulatedCamera.exposure_jump=0 0.6")
    for name, settings in (("map", ("simulator.robot=A",)), ("again", dim),
                           ("strange", dim + ("simulator.seed=50",))):
        file = os.path.join(folder, name + ".rawlog")
        if not os.path.exists(file):
            sets = [w for s in settings for w in ("--set", s)]
            shell(program, "simulate", ini, "--out", file, *sets)
    if not os.path.exists(os.path.join(folder, "place.virmap")):
        shell(program, "run", os.path.join(folder, "map.rawlog"), "--out",
              os.path.join(folder, "map_run"), "--save-map", os.path.join(folder, "place.virmap"))
    for name in ("map", "again", "strange"):
        out = os.path.join(folder, name + "_truth")
        if not os.path.exists(out):
            shell(program, "export", os.path.join(folder, name + ".rawlog"), "--format", "tum",
                  "--out", out)


def one_start(program, folder, name, start_s, seconds, extra):
    """What came of it: time of the first image, of the first pose, of the first in the map."""
    out = os.path.join(folder, "run")
    shutil.rmtree(out, ignore_errors=True)
    shell(program, "run", os.path.join(folder, name + ".rawlog"), "--map",
          os.path.join(folder, "place.virmap"), "--out", out, "--set",
          f"Estimator.start_offset_s={start_s}", "--set", f"Estimator.duration_s={seconds}",
          *[w for s in extra for w in ("--set", s)], allowed=(0, 1))
    with open(os.path.join(out, "frames.csv"), encoding="ascii") as rows:
        first = float(next(csv.DictReader(rows))["t_s"])
    poses, own = (Path(os.path.join(out, f"trajectory{x}.tum")) for x in ("", "_odom"))
    found = [(t, (p, q)) for (t, p, q), (_, o, _) in zip(poses.rows, own.rows)
             if math.dist(p, o) > MOVED_M]
    with open(os.path.join(out, "loops.csv"), encoding="ascii") as rows:
        decisions = [r["decision"] for r in csv.DictReader(rows)]
    return first, poses.t[0] if poses.t else None, found, decisions


def errors(where, truth, found):
    """Of the first pose in the map and of the last: m and degrees, by the world and nearby."""
    out = []
    for t, pose in (found[0], found[-1]):
        real = truth.at(t)
        for level in (where.world, where.nearby(real[0])):
            p, q = level.pose(real)
            out.append((math.dist(p, pose[0]), angle_deg(q, pose[1])))
    return out


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))] if values else math.nan


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "bin", "vir-slam"))
    parser.add_argument("--starts", type=int, default=100)
    parser.add_argument("--strangers", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=5, help="of each start")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--set", action="append", default=[], help="Section.key=value of each start")
    parser.add_argument("--csv", help="a row per start")
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    prepare(args.program, args.folder)
    truths = {n: Path(os.path.join(args.folder, n + "_truth", "GT.tum"))
              for n in ("map", "again", "strange")}
    where = Map(os.path.join(args.folder, "map_run"), truths["map"])
    print(f"map: {len(where.pairs)} keyframes, RMS error {where.error_m:.4f} m")
    rows, stranger_rows = [], []
    draw = random.Random(args.seed)
    for name, count, into in (("again", args.starts, rows),
                              ("strange", args.strangers, stranger_rows)):
        length = truths[name].t[-1] - truths[name].t[0]
        for _ in range(count):
            start_s = round(draw.uniform(1.5, length - args.seconds - 1.5), 2)
            first, begun, found, decisions = one_start(args.program, args.folder, name, start_s,
                                                       args.seconds, args.set)
            row = {"start_s": start_s, "begun_s": begun - first if begun else None, "found_s": None,
                   "decisions": " ".join(sorted(set(d.replace(" ", "_") for d in decisions)))}
            if found:
                row["found_s"] = found[0][0] - first
                row["errors"] = errors(where, truths[name], found) if name == "again" else None
            into.append(row)
            print(json.dumps(row), flush=True)
    found = [r for r in rows if r["found_s"] is not None]
    print(f"{len(rows)} starts: first pose after (median, 95 %) "
          f"{quantile([r['begun_s'] for r in rows if r['begun_s']], .5):.2f}, "
          f"{quantile([r['begun_s'] for r in rows if r['begun_s']], .95):.2f} s, "
          f"{sum(r['begun_s'] is None for r in rows)} without any; found {len(found)}")
    late = [r["found_s"] - r["begun_s"] for r in found]
    print(f"  found after the first image (median, 95 %, worst) "
          f"{quantile([r['found_s'] for r in found], .5):.2f}, "
          f"{quantile([r['found_s'] for r in found], .95):.2f}, "
          f"{max([r['found_s'] for r in found], default=math.nan):.2f} s, after the first pose "
          f"{quantile(late, .5):.2f}, {quantile(late, .95):.2f}, {max(late, default=math.nan):.2f} s; "
          f"within 1 s {sum(r['found_s'] <= 1 for r in found)} and {sum(x <= 1 for x in late)}")
    wrong = 0
    for k, what in enumerate(("at once, by the world", "at once, nearby", "at the end, by the world",
                              "at the end, nearby")):
        m, deg = [[r["errors"][k][j] for r in found] for j in (0, 1)]
        near = sum(a < NEAR_M and b < NEAR_DEG for a, b in zip(m, deg))
        off = sum(a > WRONG_M or b > WRONG_DEG for a, b in zip(m, deg))
        wrong = max(wrong, off)
        print(f"  {what}: within 5 cm and 1 deg {near}, wrong {off}; median {quantile(m, .5):.4f} m "
              f"{quantile(deg, .5):.3f} deg, 95 % {quantile(m, .95):.4f} m {quantile(deg, .95):.3f} deg")
    strangers = sum(r["found_s"] is not None for r in stranger_rows)
    print(f"another place: {len(stranger_rows)} starts, {strangers} found")
    if args.csv:
        with open(args.csv, "w", encoding="ascii", newline="") as file:
            out = csv.writer(file)
            out.writerow(["place", "start_s", "begun_s", "found_s", "m", "deg", "decisions"])
            for place, rs in (("again", rows), ("strange", stranger_rows)):
                for r in rs:
                    e = r["errors"][0] if r.get("errors") else ("", "")
                    out.writerow([place, r["start_s"], r["begun_s"], r["found_s"], *e, r["decisions"]])
    return 1 if wrong or strangers else 0


if __name__ == "__main__":
    raise SystemExit(main())
