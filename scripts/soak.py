#!/usr/bin/env python3
"""The part of scripts/soak.sh that runs the programs, does the harm and judges."""
import argparse
import json
import os
import re
import signal
import socket
import statistics
import struct
import subprocess
import sys
import threading
import time

FLAT_MB = 5
SETTLE_S = 0.1  # what was on its way when a device was pulled out may go with it
RATES = {"imu": 200, "uwb": 20}
CLOCK_STEPS_S = (-3600, -3600.4, 5, 0)
START_IN_S = 8
READ_S_PER_MINUTE = 3  # that the emulator takes to read the flight, on a busy machine
LATENCY_FROM_MINUTES = 10  # a shorter run has too few images to compare
MOST_LEFT_OUT = 0.001  # of the images

INI = """[Recording]
rawlog-grabber-ignore = true
estimate = true
stream_port = {port}
images = embed
[Estimator]
rawlog-grabber-ignore = true
driver = vir
[camera]
driver = RawlogReplay
process_rate = 200
rawlog = flight.rawlog
labels = {labels}
stamps = now
start_at_s = {start}
[truth]
driver = RawlogReplay
process_rate = 50
rawlog = flight.rawlog
labels = GT
stamps = now
start_at_s = {start}
[device_imu]
driver = SerialImu
process_rate = 500
sensorLabel = IMU0
protocol = binary
port = {work}/imu
[device_uwb]
driver = UwbSerial
process_rate = 500
sensorLabel = UWB0
protocol = nlink
std_error_m = 0.05
port = {work}/uwb
"""


class Clock:
    """That of tests/support/clock, if it was built."""

    def __init__(self, build, work):
        self.library = os.path.join(build, "lib", "libvir_test_clock.so")
        self.file = os.path.join(work, "clock")
        self.there = os.path.exists(self.library)
        self.set_by(0)

    def set_by(self, seconds):
        with open(self.file, "r+b" if os.path.exists(self.file) else "w+b") as out:
            out.write(struct.pack("qq", round(seconds * 1e9), 0))

    def environment(self):
        if not self.there:
            return dict(os.environ)
        return dict(os.environ, LD_PRELOAD=self.library, VIR_TEST_CLOCK=self.file)


class Listener(threading.Thread):
    """A client of the stream: when was which image's pose there?"""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port = port
        self.latencies = []  # [s since the start, ms]

    def run(self):
        connection = None
        while connection is None:
            try:
                connection = socket.create_connection(("127.0.0.1", self.port), 1)
            except OSError:
                time.sleep(0.1)
        connection.settimeout(None)
        start = time.monotonic()
        with connection, connection.makefile("rb") as lines:
            for line in lines:
                now = time.time_ns()
                if b'"estimate"' not in line:
                    continue
                latency = (now - json.loads(line)["t_ns"]) * 1e-6
                self.latencies.append((time.monotonic() - start, latency))

    def between(self, begin, end):
        return sorted(ms for s, ms in self.latencies if begin <= s < end)


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def crowd(port, stop):
    """60 clients, none of which reads."""
    clients = []
    for _ in range(60):
        try:
            clients.append(socket.create_connection(("127.0.0.1", port), 1))
        except OSError:
            pass
    stop.wait(20)
    for c in clients:
        c.close()


def resident_mb(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as lines:
        for line in lines:
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
    return None


class Soak:
    def __init__(self, arguments):
        self.a = arguments
        self.seconds = arguments.minutes * 60
        self.start_in = START_IN_S + READ_S_PER_MINUTE * arguments.minutes
        self.port = free_port()
        self.clock = Clock(arguments.build_dir, arguments.work)
        self.memory = []  # [s since it plays, MB]
        self.harm = {"clock": 0, "crowd": 0, "stop": 0}
        self.stop = threading.Event()

    def file(self, name):
        return os.path.join(self.a.work, name)

    def program(self, name):
        return os.path.join(self.a.build_dir, "bin", name)

    def begin(self):
        start = int(time.time() + self.start_in)
        with open(self.file("live.ini"), "w", encoding="ascii") as out:
            out.write(INI.format(port=self.port, start=start, work=self.a.work, labels=self.a.labels))
        self.emulator = subprocess.Popen(
            [self.program("vir-device-emulator"), self.file("flight.rawlog"),
             "--uwb", "nlink=" + self.file("uwb"), "--imu", "binary=" + self.file("imu"),
             "--start-at", str(start), "--summary", self.file("sent.json"), *self.faults_of_devices()],
            stdout=subprocess.DEVNULL)
        while not (os.path.exists(self.file("uwb")) and os.path.exists(self.file("imu"))):
            time.sleep(0.05)
        self.log = open(self.file("record.log"), "w", encoding="utf-8")
        self.recorder = subprocess.Popen(
            [self.program("vir-slam"), "record", self.file("live.ini"), "--out",
             self.file(f"live{os.getpid()}.rawlog"), "--results", self.file("results")],
            stdout=self.log, stderr=subprocess.STDOUT, env=self.clock.environment())
        self.listener = Listener(self.port)
        self.listener.start()
        if time.time() > start - 1:
            sys.exit("the emulator took too long to read the flight")
        time.sleep(start - time.time())

    def faults_of_devices(self):
        if self.a.calm:
            return []
        return ["--clock-drift", "200", "--garbage", "0.001", "--corrupt", "0.0005",
                "--unplug-every", "60" if self.a.minutes > 1 else "25", "--unplug-for", "1.5"]

    def watch(self):
        """Until the time is over, or when calm the flight, so that no image waits for readings that were not sent; harm is
        done at the same seconds of every minute."""
        begun = time.monotonic()
        due = {} if self.a.calm else {"clock": 10, "crowd": 15, "stop": 40}
        while self.recorder.poll() is None:
            s = time.monotonic() - begun
            if s > self.seconds and not self.a.calm or self.emulator.poll() is not None:
                break
            self.memory.append((s, resident_mb(self.recorder.pid)))
            for what, at in due.items():
                if s >= at + 60 * self.harm[what]:
                    self.do(what)
                    self.harm[what] += 1
            time.sleep(0.5)
        self.stop.set()
        if not self.a.calm:
            self.emulator.terminate()  # it waits until what it sent has been read

    def do(self, what):
        if what == "clock" and self.clock.there:
            self.clock.set_by(CLOCK_STEPS_S[self.harm["clock"] % len(CLOCK_STEPS_S)])
        elif what == "crowd":
            threading.Thread(target=crowd, args=(self.port, self.stop), daemon=True).start()
        elif what == "stop":
            self.recorder.send_signal(signal.SIGSTOP)
            time.sleep(0.3)
            self.recorder.send_signal(signal.SIGCONT)

    def end(self):
        self.emulator.wait()
        time.sleep(2)
        if self.recorder.poll() is None:
            self.recorder.terminate()
        self.code = self.recorder.wait()
        self.log.close()

    def median_memory(self, begin, end):
        values = [mb for s, mb in self.memory if begin <= s < end and mb is not None]
        return statistics.median(values) if values else float("nan")

    def judge_memory(self):
        # What is needed once is there after five minutes, or a third.
        warm = min(300, self.seconds / 3)
        piece = min(60, self.seconds / 6)
        first = self.median_memory(warm, warm + piece)
        last = self.median_memory(self.seconds - piece, self.seconds)
        print(f"memory: {first:.1f} MB after {warm:.0f} s, {last:.1f} MB at the end: "
              f"{last - first:+.1f} MB (allowed: {FLAT_MB})")
        step = max(piece, self.seconds / 12)
        series = [self.median_memory(k * step, k * step + piece)
                  for k in range(int(self.seconds / step))]
        print("  over time: " + " ".join(f"{mb:.1f}" for mb in series))
        return last - first <= FLAT_MB

    def judge_loss(self):
        with open(self.file("record.log"), encoding="utf-8") as log:
            text = log.read()
        with open(self.file("sent.json"), encoding="ascii") as sent_file:
            sent = json.load(sent_file)
        good = self.code == 0
        print(f"record: exit code {self.code}")
        for device, counter in (("imu", "imu_readings"), ("uwb", "ranges")):
            found = re.search(rf"^device_{device}: {counter} (\d+)", text, re.M)
            got = int(found.group(1)) if found else 0
            d = sent[device]
            lost = d["sent"] - got
            allowed = round(d["unplugs"] * SETTLE_S * RATES[device])
            print(f"{device}: {d['messages']} due, {d['unplugged']} while unplugged ({d['unplugs']} times), "
                  f"{d['damaged']} damaged, {d['sent']} sent; {got} recorded: {lost} lost "
                  f"(allowed: {allowed}, on their way when the device was pulled out)")
            good = good and d["sent"] > 0 and (d["unplugs"] > 0 or self.a.calm) and 0 <= lost <= allowed
        # Sensors' counts with their notes of the clock, in the table of the report.
        seen = sum(int(n) for n in re.findall(r"^(?:camera|truth|device_\w+) +(\d+) +\d+  ", text, re.M))
        written = re.search(r"written (\d+) in order, (\d+) too late or far ahead, (\d+) lost", text)
        if not written:
            print(text)
            return False
        order, aside, lost = map(int, written.groups())
        print(f"recorder: {seen} handed over, {order} written in order, {aside} aside, {lost} lost")
        for line in (re.search(r"^image to pose.*$", text, re.M), re.search(r"^ATE.*$", text, re.M)):
            if line:
                print("  " + line.group(0))
        return good and lost == 0 and seen == order + aside and self.judge_images(text)

    def judge_images(self, text):
        """Images that the estimator did not get round to; a short run may be on a machine that builds as well."""
        told = re.search(r"^(\d+) images, \d+ poses, (\d+) images left out", text, re.M)
        images, left_out = map(int, told.groups()) if told else (0, 0)
        most = round(MOST_LEFT_OUT * images)
        print(f"images: {images}, {left_out} left out because newer ones waited (allowed: {most})")
        return self.a.minutes < LATENCY_FROM_MINUTES or (images > 0 and left_out <= most)

    def judge_latency(self):
        part = min(self.seconds / 4, 600)
        ends = self.listener.latencies[-1][0] if self.listener.latencies else 0
        begins = self.listener.latencies[0][0] if self.listener.latencies else 0
        first = self.listener.between(begins + 5, begins + 5 + part)
        last = self.listener.between(ends - part, ends)
        if len(first) < 20 or len(last) < 20:
            print("latency: too few poses came over the stream")
            return False
        at = lambda values, share: values[int(share * (len(values) - 1))]
        print(f"latency from image to pose at a client, median / 95 %: {at(first, .5):.1f} / {at(first, .95):.1f} ms "
              f"at first, {at(last, .5):.1f} / {at(last, .95):.1f} ms at last ({len(self.listener.latencies)} poses)")
        if self.a.minutes < LATENCY_FROM_MINUTES:
            return True
        return at(last, .5) <= 1.25 * at(first, .5) + 2

    def run(self):
        self.begin()
        self.watch()
        self.end()
        print(f"{self.a.minutes} min; clock set {self.harm['clock'] if self.clock.there else 0} times, "
              f"crowds {self.harm['crowd']}, stood still {self.harm['stop']} times")
        verdicts = [self.judge_memory(), self.judge_loss(), self.judge_latency()]
        print("PASS" if all(verdicts) else "FAIL")
        return 0 if all(verdicts) else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build-dir", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--minutes", type=int, required=True)
    parser.add_argument("--labels", default="TRACKS0")
    parser.add_argument("--calm", action="store_true")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # the programs below end with it
    soak = Soak(parser.parse_args())
    try:
        sys.exit(soak.run())
    finally:
        for process in (getattr(soak, "recorder", None), getattr(soak, "emulator", None)):
            if process is not None and process.poll() is None:
                process.kill()


if __name__ == "__main__":
    main()
