#!/usr/bin/env python3
"""How much of a live recording is missing after the power goes?

Records the sample onto an ext4 file system of its own, cuts that off at random moments without
writing its journal (what a power failure leaves), mounts it again and reads what is there.
Needs root, mkfs.ext4, loop devices and a built program:
  sudo scripts/check_power_loss.py [--times 20] [--program build/bin/vir-slam]
"""
import argparse
import fcntl
import os
import random
import re
import struct
import subprocess
import tempfile
import time

EXT4_IOC_SHUTDOWN = 0x8004587D  # _IOR('X', 125, __u32)
WITHOUT_JOURNAL = 2
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def shell(*words, check=True):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if check and done.returncode != 0:
        raise SystemExit(f"{' '.join(words)}: {done.stdout}")
    return done.stdout


def cut_off(folder):
    fd = os.open(folder, os.O_RDONLY)
    fcntl.ioctl(fd, EXT4_IOC_SHUTDOWN, struct.pack("I", WITHOUT_JOURNAL))
    os.close(fd)


def recorded_seconds(program, rawlog, out):
    """Length of the recording, its images, and those that cannot be read."""
    text = shell(program, "export", rawlog, "--format", "euroc", "--out", out)
    images = re.search(r"CAM0\s+(\d+)\s+(\d+)", text)
    stamps = []
    for folder, _, files in os.walk(out):
        for name in files:
            if not name.endswith(".csv"):
                continue
            with open(os.path.join(folder, name), encoding="ascii") as lines:
                stamps += [int(m.group(1)) for m in re.finditer(r"^(\d{15,})", lines.read(), re.M)]
    return (max(stamps) - min(stamps)) * 1e-9, int(images.group(1)), int(images.group(2))


def once(program, folder):
    image, mount = os.path.join(folder, "disk.img"), os.path.join(folder, "disk")
    os.makedirs(mount)
    shell("truncate", "-s", "400M", image)
    device = shell("losetup", "-f", "--show", image).strip()
    try:
        shell("mkfs.ext4", "-q", device)
        shell("mount", device, mount)
        rawlog = os.path.join(mount, "a.rawlog")
        recorder = subprocess.Popen(
            [program, "record", os.path.join(ROOT, "ini", "live_replay.ini"), "--out", rawlog,
             "--set", "Recording.estimate=false"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        recorder.stdout.readline()  # "recording 4 sensors to ..."
        start = time.time()
        time.sleep(random.uniform(1.5, 9))
        played = time.time() - start
        cut_off(mount)
        recorder.kill()
        recorder.wait()
        shell("umount", mount)
        shell("mount", device, mount)
        length, images, unreadable = recorded_seconds(program, rawlog,
                                                      os.path.join(folder, "euroc"))
        return played, played - length, images, unreadable
    finally:
        shell("umount", mount, check=False)
        shell("losetup", "-d", device, check=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "bin", "vir-slam"))
    arguments = parser.parse_args()
    if os.geteuid() != 0:
        raise SystemExit("file systems are made and mounted: root is needed")
    random.seed(1)
    worst, bad = 0, 0
    for i in range(arguments.times):
        with tempfile.TemporaryDirectory() as folder:
            played, missing, images, unreadable = once(arguments.program, folder)
        worst, bad = max(worst, missing), bad + unreadable
        print(f"{i + 1}: cut after {played:.2f} s, {missing:.2f} s missing, {images} images, "
              f"{unreadable} unreadable", flush=True)
    print(f"at most {worst:.2f} s missing, {bad} images unreadable")
    raise SystemExit(1 if worst > 1 or bad > 0 else 0)


if __name__ == "__main__":
    main()
