#!/usr/bin/env python3
"""loopstone-ros2 against other programs that speak DDS, over a network of two machines that is made
for it: a pair of virtual cables between two network namespaces. Needs root.

    check_ros2.py PROGRAM LOOPSTONE          all of it, about a minute and a half
    check_ros2.py PROGRAM LOOPSTONE --only WORD

PROGRAM is loopstone-ros2, LOOPSTONE the other program, which simulates the drive. Ends with 77, and
says why, where what it needs is not there (scripts/install_ros2_peers.sh).
"""

import argparse
import bisect
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PEERS = ROOT / "build" / "ros2_peers"
PYTHON = PEERS / "venv" / "bin" / "python"
RUST = PEERS / "rust" / "debug" / "rust_peer"
IN_NAMESPACE = "LOOPSTONE_ROS2_NAMESPACE"


def skip(reason):
    print(f"skipped: {reason}")
    told = os.environ.get("LOOPSTONE_SKIPPED_TESTS")
    if told:
        with open(told, "a", encoding="utf-8") as file:
            file.write(f"ros2\tnetwork\t{reason}\n")
    sys.exit(77)


# The network.


def enter_namespace():
    """This process again, on a machine of its own as far as its network goes."""
    if os.environ.get(IN_NAMESPACE):
        return
    if not PYTHON.exists():
        skip("no peers (scripts/install_ros2_peers.sh)")
    works = subprocess.run(
        ["unshare", "-n", "sh", "-c", "ip link add here type veth peer name there"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    if works.returncode != 0:
        skip("no network namespaces can be made here (root, and iproute2)")
    os.environ[IN_NAMESPACE] = "1"
    os.execvp("unshare", ["unshare", "-n", sys.executable, *sys.argv])


def run(*command):
    subprocess.run(command, check=True)


class Network:
    """Here and there, with a cable between them."""

    def __enter__(self):
        # There is a machine for as long as a process runs on it.
        self.there = subprocess.Popen(["unshare", "-n", "sleep", "1000"])
        deadline = time.monotonic() + 10
        mine = os.readlink("/proc/self/ns/net")
        while os.readlink(f"/proc/{self.there.pid}/ns/net") == mine:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        run("ip", "link", "add", "here", "type", "veth", "peer", "name", "there")
        run("ip", "link", "set", "there", "netns", str(self.there.pid))
        run("ip", "addr", "add", "10.77.0.1/24", "dev", "here")
        run("ip", "link", "set", "here", "up")
        run("ip", "link", "set", "lo", "up")
        self.run_there("ip", "addr", "add", "10.77.0.2/24", "dev", "there")
        self.run_there("ip", "link", "set", "there", "up")
        self.run_there("ip", "link", "set", "lo", "up")
        return self

    def __exit__(self, *_):
        self.there.kill()
        self.there.wait()

    def run_there(self, *command):
        run(*self.at_there(command))

    def at_there(self, command):
        return ["nsenter", "-t", str(self.there.pid), "-n", *command]

    def cut(self):
        run("ip", "link", "set", "here", "down")

    def mend(self):
        run("ip", "link", "set", "here", "up")


class Process:
    """A program that runs beside this one, and is ended with it."""

    def __init__(self, command, folder, name):
        self.out = folder / f"{name}.out"
        self.err = folder / f"{name}.err"
        self.files = [open(self.out, "w"), open(self.err, "w")]
        self.process = subprocess.Popen(command, stdout=self.files[0], stderr=self.files[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        for file in self.files:
            file.close()

    def end(self, how=signal.SIGINT, patience=60):
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(patience)

    def said(self):
        return self.out.read_text() + self.err.read_text()

    def wait_for(self, text, patience=30):
        deadline = time.monotonic() + patience
        while text not in self.said():
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise AssertionError(f"it did not say '{text}':\n{self.said()}")
            time.sleep(0.02)


class Bench:
    """What the checks have in common."""

    def __init__(self, program, loopstone, folder, network):
        self.program = program
        self.folder = folder
        self.network = network
        run(
            *(loopstone, "simulate", "office", "-o", folder / "sim", "--duration", "60"),
            *("--format", "carmen", "--quiet"),
        )
        self.log = folder / "sim" / "log.clf"
        self.map = folder / "map"
        run(loopstone, "map", self.log, "-o", self.map, "--quiet")

    def loopstone(self, name, *flags):
        return Process([self.program, "--no-view", *flags], self.folder, name)

    def peer(self, name, *words, there=True):
        command = [PYTHON, HERE / "peer.py", *words]
        command = self.network.at_there(command) if there else command
        return Process(command, self.folder, name)

    def listener(self, name, *flags):
        process = self.peer(name, "listener", self.folder / f"{name}.jsonl", *flags)
        process.wait_for("ready")
        return process

    def heard(self, name, kind):
        lines = (self.folder / f"{name}.jsonl").read_text().splitlines()
        return [line for line in map(json.loads, lines) if line["kind"] == kind]

    def truth(self):
        poses = []
        for line in (self.folder / "sim" / "truth.tum").read_text().splitlines():
            if line.startswith("#"):
                continue
            t, x, y, _, _, _, qz, qw = (float(word) for word in line.split())
            poses.append((t, (x, y, 2 * math.atan2(qz, qw))))
        return poses


# Poses in the plane: (x, y, yaw).


def times(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2])


def inverse(a):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2])


def distance(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def nearest(poses, t):
    """Of (t, pose) in the order of t."""
    at = bisect.bisect_left([one[0] for one in poses], t)
    return min(poses[max(at - 1, 0) : at + 1], key=lambda one: abs(one[0] - t))


def errors_of(told, truth, most_s=0.06):
    """How far poses are off, the first one taken for right. [m]"""
    first = nearest(truth, told[0]["t"])[1]
    map_T_world = times(told[0]["pose"], inverse(first))
    errors = []
    for one in told:
        t, pose = nearest(truth, one["t"])
        if abs(t - one["t"]) <= most_s:
            errors.append(distance(times(map_T_world, pose), one["pose"]))
    return errors


def check(condition, what):
    if not condition:
        raise AssertionError(what)


def check_transforms(bench, name):
    """map to odom, then the robot's own odometry, leads to where /pose says that it is."""
    odometry = [(one["t"], one["pose"]) for one in bench.heard(name, "odom")]
    poses = {one["t"]: one["pose"] for one in bench.heard(name, "pose")}
    compared = 0
    for one in bench.heard(name, "tf"):
        if one["parent"] != "map":
            check(one["parent"] == "odom" and one["child"] == "base_link", f"tf of {one}")
            continue
        check(one["child"] == "odom", f"tf of map to {one['child']}")
        t, odom_T_robot = nearest(odometry, one["t"])
        if one["t"] not in poses or abs(t - one["t"]) > 0.02:
            continue
        # Meanwhile the robot drives a hundredth of a metre.
        off = distance(times(one["pose"], odom_T_robot), poses[one["t"]])
        check(off < 0.03, f"tf and pose differ by {off:.3f} m at {one['t']}")
        compared += 1
    check(compared > 100, f"of {compared} transforms the pose is known")


# The checks.


def map_with_listeners(bench):
    """A map arrives where it should, and nowhere else; broken messages do no harm."""
    with (
        bench.listener("early") as early,
        bench.listener("other", "--domain", "7") as other,
        bench.loopstone("mapping", "-o", bench.folder / "out") as mapping,
    ):
        mapping.wait_for("waiting for ROS 2, domain 0")
        with bench.peer("robot", "robot", bench.log, "--pace", "5") as robot:
            time.sleep(4)
            with bench.peer("vandal", "vandal") as vandal:
                check(vandal.process.wait(20) == 0, vandal.said())
            check(robot.process.wait(60) == 0, robot.said())
        time.sleep(2)  # all that was seen has been drawn
        with bench.listener("late") as late:
            time.sleep(2)
            check(len(bench.heard("late", "map")) == 1, "who comes late gets the map, once")
            check(mapping.end() == 0, mapping.said())
            time.sleep(1)
            late.end(signal.SIGTERM)
        for listener in (early, other):
            listener.end(signal.SIGTERM)
    said = mapping.said()
    check("more records were skipped" in said, said)
    maps = bench.heard("early", "map")
    check(len(maps) >= 4, f"{len(maps)} maps came")
    check(all(one["cells"] == one["width"] * one["height"] for one in maps), "cells are missing")
    check(maps[-1]["frame"] == "map" and maps[0]["free"] < maps[-1]["free"], "the map grows")
    check_same_map(maps[-1], bench.folder / "out" / "map.pgm")
    check(bench.heard("late", "map")[-1]["free"] == maps[-1]["free"], "all get the finished map")
    errors = errors_of(bench.heard("early", "pose"), bench.truth())
    check(len(errors) > 400 and max(errors) < 0.25, f"{len(errors)} poses, off by {max(errors)} m")
    covariance = bench.heard("early", "pose")[-1]["covariance"]
    check(all(covariance[i] > 0 for i in (0, 7, 35)) and covariance[14] == 0, f"{covariance}")
    check_transforms(bench, "early")
    tracking = [one for one in bench.heard("early", "diagnostics") if "tracking" in one["name"]]
    check(any(one["level"] == 0 for one in tracking), "diagnostics tell that it is tracked")
    for kind in ("map", "tf", "pose", "diagnostics", "odom"):
        check(not bench.heard("other", kind), f"another domain hears {kind}")


def check_same_map(told, pgm):
    head = pgm.read_bytes().split(b"\n", 20)
    size = next(line for line in head if line and line[:1].isdigit())
    check(size.split() == [b"%d" % told["width"], b"%d" % told["height"]], f"{size} and {told}")


def go_on_after_the_network_was_lost(bench):
    with (
        bench.listener("there") as there,
        bench.loopstone("lost", "-o", bench.folder / "lost_out") as mapping,
        bench.peer("robot2", "robot", bench.log, "--pace", "4", "--stay", "1") as robot,
    ):
        mapping.wait_for("laser    /scan")
        time.sleep(3)
        bench.network.cut()
        mapping.wait_for("no scan for 3 s")
        lost = time.time()
        bench.network.mend()
        mapping.wait_for("scans come again")
        check(robot.process.wait(60) == 0, robot.said())
        check(mapping.end() == 0, mapping.said())
        time.sleep(1)
        there.end(signal.SIGTERM)
    after = [one for one in bench.heard("there", "pose") if one["came"] > lost + 1.0]
    check(len(after) > 50, f"{len(after)} poses came after the network was back")
    poses = bench.heard("there", "pose")
    errors = errors_of(poses, bench.truth())
    check(max(errors) < 0.5, f"poses are off by {max(errors)} m")
    check(len([one for one in bench.heard("there", "map") if one["came"] > lost]) >= 2, "no maps")
    told = [one for one in bench.heard("there", "diagnostics") if "sensors" in one["name"]]
    check(any("scans come again" in one["message"] for one in told), f"{told}")


def localize(bench):
    """On the finished map; where it is lost, somebody says where it is."""
    world_T_robot = bench.truth()[0][1]
    # The map begins where the robot began.
    map_T_world = inverse(world_T_robot)
    with bench.listener("listening") as listening:
        with (
            bench.peer("robot3", "robot", bench.log, "--pace", "4", "--hold", "40") as robot,
            bench.loopstone(
                *("localizing", "--map", bench.map, "--initial", "3,3,1.5"),
                *("--set", "recover=false", "-o", bench.folder / "found.tum"),
            ) as localizing,
        ):
            localizing.wait_for("laser    /scan")
            # It stands where the map begins.
            before = []
            while len(before) < 10:
                time.sleep(0.05)
                before = bench.heard("listening", "pose")
            lost = distance(before[-1]["pose"], (0.0, 0.0, 0.0))
            check(lost > 1.0, f"it is lost at first, by {lost:.2f} m")
            clicked = time.time()
            with bench.peer("click", "click", "0.2,-0.1,0.1") as click:
                check(click.process.wait(20) == 0, click.said())
            check(robot.process.wait(60) == 0, robot.said())
            check(localizing.end() == 0, localizing.said())
            time.sleep(1)
        listening.end(signal.SIGTERM)
    check(len(bench.heard("listening", "map")) == 1, "the map is told once")
    after = [one for one in bench.heard("listening", "pose") if one["came"] > clicked + 2.0]
    found = [
        distance(one["pose"], times(map_T_world, nearest(bench.truth(), one["t"])[1]))
        for one in after
    ]
    check(len(found) > 50 and max(found[10:]) < 0.3, f"{len(found)} poses, {max(found[10:])} m")
    check_transforms(bench, "listening")


def talk_with_another_implementation(bench):
    """RustDDS tells the sensors, and hears the rest."""
    if not RUST.exists():
        print("without RustDDS (scripts/install_ros2_peers.sh, with Cargo)")
        return
    with bench.loopstone("rust", "-o", bench.folder / "rust_out") as mapping:
        command = bench.network.at_there([RUST, bench.log, "5"])
        with Process(command, bench.folder, "rust_peer") as peer:
            check(peer.process.wait(60) == 0, peer.said())
            check(mapping.end() == 0, mapping.said())
    told = json.loads(peer.out.read_text().splitlines()[-1])
    check(told["maps"] >= 3 and told["cells"] == told["width"] * told["height"], f"{told}")
    check(told["poses"] > 300 and told["transforms"] > 300, f"{told}")
    x, y = told["last"][1:]
    t, truth = nearest(bench.truth(), told["last"][0])
    first = bench.truth()[0][1]
    check(distance(times(inverse(first), truth), (x, y)) < 0.25, f"{told}")


def refuse(bench):
    """What makes no sense is refused with the right exit code and nothing left behind."""
    out = bench.folder / "nothing"
    for code, word, flags in (
        (2, "--topic wheels", ("-o", out, "--topic", "wheels=/joint_states")),
        (2, "topics of ROS are named", ("-o", out, "--topic", "laser=scan")),
        (2, "without a laser", ("-o", out, "--topic", "laser=")),
        (2, "--interface", ("-o", out, "--interface", "<eth0>")),
        (1, "can't be entered", ("-o", out, "--interface", "eth99")),
        (2, "--domain", ("-o", out, "--domain", "300")),
        (2, "-o FOLDER", ()),
        (1, "no map.yaml", ("--map", bench.folder)),
    ):
        with bench.loopstone("refused", *flags) as program:
            got = program.process.wait(20)
        check(got == code and word in program.said(), f"{flags}: {got}, {program.said()}")
    check(not out.exists(), "something was written")


CHECKS = [
    map_with_listeners,
    localize,
    go_on_after_the_network_was_lost,
    talk_with_another_implementation,
    refuse,
]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("loopstone", type=pathlib.Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", type=pathlib.Path, help="a new folder for all that is written")
    arguments = parser.parse_args()
    enter_namespace()
    os.environ.pop("CYCLONEDDS_URI", None)
    os.environ.pop("ROS_DOMAIN_ID", None)
    failed = 0
    with tempfile.TemporaryDirectory() as temporary, Network() as network:
        folder = arguments.keep or pathlib.Path(temporary)
        folder.mkdir(exist_ok=arguments.keep is None)
        bench = Bench(arguments.program.resolve(), arguments.loopstone.resolve(), folder, network)
        for one in CHECKS:
            if arguments.only not in one.__name__:
                continue
            begin = time.monotonic()
            try:
                one(bench)
                word = "passed"
            except (AssertionError, subprocess.SubprocessError) as error:
                failed += 1
                word = f"FAILED: {error}"
            print(f"{one.__name__}: {word} ({time.monotonic() - begin:.0f} s)", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
