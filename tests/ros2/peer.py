#!/usr/bin/env python3
"""Another program on a robot's network, by the Python of Cyclone DDS.

peer.py robot LOG ...      tells the sensors of a simulated drive, a log of CARMEN
peer.py listener FILE ...  writes what it hears of the map and the robot, a line of JSON each
peer.py click X,Y,YAW ...  tells /initialpose, once somebody listens
peer.py vandal ...         tells noise in the place of messages, on all topics that are listened to
"""

import argparse
import json
import math
import pathlib
import random
import signal
import time
from dataclasses import dataclass, field

from cyclonedds.core import ReadCondition, InstanceState, SampleState, ViewState, WaitSet
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import sequence, uint8
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

import messages as ros


def stamp(seconds):
    nanoseconds = round(seconds * 1e9)
    return ros.Time(nanoseconds // 10**9, nanoseconds % 10**9)


def seconds_of(time_message):
    return time_message.sec + time_message.nanosec * 1e-9


def turned(yaw):
    return ros.Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def yaw_of(q):
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))


def transform(seconds, parent, child, x, y, yaw):
    return ros.TransformStamped(
        ros.Header(stamp(seconds), parent), child, ros.Transform(ros.Vector3(x, y), turned(yaw))
    )


def writer(participant, name, kind, quality):
    return DataWriter(participant, Topic(participant, "rt" + name, kind), qos=quality)


def reader(participant, name, kind, quality):
    return DataReader(participant, Topic(participant, "rt" + name, kind), qos=quality)


def events_of(log):
    """(seconds, scan or odometry) of a log of CARMEN."""
    laser_x = 0.0
    for line in pathlib.Path(log).read_text().splitlines():
        words = line.split()
        if words[0] == "PARAM" and words[1] == "robot_frontlaser_offset":
            laser_x = float(words[2])
        elif words[0] == "ODOM":
            yield float(words[-1]), "odom", [float(word) for word in words[1:4]]
        elif words[0] == "ROBOTLASER1":
            numbers = [float(word) for word in words[2:8]]
            count = int(words[8])
            ranges = [float(word) for word in words[9 : 9 + count]]
            yield float(words[-1]), "scan", (numbers, ranges, laser_x)


def held(events, hold_s):
    """The drive, before which the robot stands for a while."""
    events = list(events)
    first = {kind: (seconds, what) for seconds, kind, what in reversed(events)}
    begin = min(seconds for seconds, _ in first.values()) - hold_s
    for i in range(round(10 * hold_s)):
        for kind in ("odom", "scan"):
            yield begin + i / 10, kind, first[kind][1]
    yield from events


# From the first beam to the last one, of the simulated laser; CARMEN's text does not tell it.
SWEEP_S = 0.01875


def scan_message(seconds, numbers, ranges):
    first, field_of_view, step, most = numbers[:4]
    return ros.LaserScan(
        ros.Header(stamp(seconds), "laser"),
        angle_min=first,
        angle_max=first + field_of_view,
        angle_increment=step,
        time_increment=SWEEP_S / len(ranges),
        range_min=0.05,
        range_max=most,
        ranges=ranges,
    )


def robot(arguments):
    participant = DomainParticipant(arguments.domain)
    scans = writer(participant, "/scan", ros.LaserScan, ros.SENSOR)
    odometry = writer(participant, "/odom", ros.Odometry, ros.DEFAULT)
    moving = writer(participant, "/tf", ros.TFMessage, ros.TRANSFORMS)
    fixed = writer(participant, "/tf_static", ros.TFMessage, ros.LATCHED)
    begin = None
    told = False
    for seconds, kind, what in held(events_of(arguments.log), arguments.hold):
        if begin is None:
            begin = (seconds, time.monotonic())
        late = (seconds - begin[0]) / arguments.pace
        time.sleep(max(0.0, begin[1] + late - time.monotonic()))
        if kind == "odom":
            x, y, yaw = what
            moving.write(ros.TFMessage([transform(seconds, "odom", "base_link", x, y, yaw)]))
            pose = ros.PoseWithCovariance(ros.Pose(ros.Point(x, y), turned(yaw)))
            odometry.write(ros.Odometry(ros.Header(stamp(seconds), "odom"), "base_link", pose))
            continue
        numbers, ranges, laser_x = what
        if not told:
            mount = transform(seconds, "base_link", "laser", laser_x, 0.0, 0.0)
            fixed.write(ros.TFMessage([mount]))
            told = True
        scans.write(scan_message(seconds, numbers, ranges))
    time.sleep(arguments.stay)


def listener(arguments):
    participant = DomainParticipant(arguments.domain)
    latched = ros.LATCHED
    readers = [
        reader(participant, "/map", ros.OccupancyGrid, latched),
        reader(participant, "/tf", ros.TFMessage, ros.TRANSFORMS),
        reader(participant, "/odom", ros.Odometry, ros.DEFAULT),
        reader(participant, "/pose", ros.PoseWithCovarianceStamped, ros.DEFAULT),
        reader(participant, "/diagnostics", ros.DiagnosticArray, ros.DEFAULT),
    ]
    waiting = WaitSet(participant)
    for one in readers:
        waiting.attach(ReadCondition(one, SampleState.NotRead | ViewState.Any | InstanceState.Any))
    with open(arguments.file, "w", encoding="utf-8") as out:
        print("ready", flush=True)
        while True:
            waiting.wait(duration(milliseconds=200))
            for one in readers:
                for sample in one.take(100):
                    for line in lines_of(sample):
                        line["came"] = time.time()
                        out.write(json.dumps(line) + "\n")
            out.flush()


def lines_of(sample):
    if isinstance(sample, ros.OccupancyGrid):
        info = sample.info
        yield {
            "kind": "map",
            "frame": sample.header.frame_id,
            "width": info.width,
            "height": info.height,
            "resolution": info.resolution,
            "origin": [info.origin.position.x, info.origin.position.y],
            "free": sum(0 <= cell < 50 for cell in sample.data),
            "occupied": sum(cell > 50 for cell in sample.data),
            "cells": len(sample.data),
        }
    elif isinstance(sample, ros.TFMessage):
        for one in sample.transforms:
            where = one.transform.translation
            yield {
                "kind": "tf",
                "t": seconds_of(one.header.stamp),
                "parent": one.header.frame_id,
                "child": one.child_frame_id,
                "pose": [where.x, where.y, yaw_of(one.transform.rotation)],
            }
    elif isinstance(sample, (ros.PoseWithCovarianceStamped, ros.Odometry)):
        pose = sample.pose.pose
        yield {
            "kind": "odom" if isinstance(sample, ros.Odometry) else "pose",
            "t": seconds_of(sample.header.stamp),
            "frame": sample.header.frame_id,
            "pose": [pose.position.x, pose.position.y, yaw_of(pose.orientation)],
            "covariance": list(sample.pose.covariance),
        }
    elif isinstance(sample, ros.DiagnosticArray):
        for status in sample.status:
            yield {
                "kind": "diagnostics",
                "name": status.name,
                "level": int(status.level),
                "message": status.message,
            }


def click(arguments):
    participant = DomainParticipant(arguments.domain)
    out = writer(participant, "/initialpose", ros.PoseWithCovarianceStamped, ros.DEFAULT)
    while not out.get_matched_subscriptions():
        time.sleep(0.05)
    x, y, yaw = (float(number) for number in arguments.pose.split(","))
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = 0.25
    covariance[35] = 0.07
    pose = ros.PoseWithCovariance(ros.Pose(ros.Point(x, y), turned(yaw)), covariance)
    out.write(ros.PoseWithCovarianceStamped(ros.Header(stamp(0.0), "map"), pose))
    time.sleep(1.0)


def vandal(arguments):
    noise = random.Random(1)
    outs = []
    for name, kind, quality in (
        ("/scan", ros.LaserScan, ros.SENSOR),
        ("/odom", ros.Odometry, ros.DEFAULT),
        ("/tf", ros.TFMessage, ros.TRANSFORMS),
        ("/tf_static", ros.TFMessage, ros.LATCHED),
        ("/initialpose", ros.PoseWithCovarianceStamped, ros.DEFAULT),
    ):
        outs.append((writer(DomainParticipant(arguments.domain), name, noise_of(kind), quality)))
    while not all(out.get_matched_subscriptions() for out in outs[:4]):
        time.sleep(0.05)
    for size in (0, 1, 4, 12, 60, 500, 5000):
        for out in outs:
            out.write(out.data_type([noise.randrange(256) for _ in range(size)]))
            # As if a string or a list had no end.
            out.write(out.data_type([255] * size))
    time.sleep(1.0)


def noise_of(kind):
    """Bytes under the name of another type."""

    @dataclass
    @final
    class Noise(IdlStruct, typename=kind.__idl_typename__):
        data: sequence[uint8] = field(default_factory=list)

    return Noise


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parts = parser.add_subparsers(required=True)
    one = parts.add_parser("robot")
    one.add_argument("log")
    one.add_argument("--pace", type=float, default=1.0)
    one.add_argument("--hold", type=float, default=0.0, help="it stands before the drive [s]")
    one.add_argument("--stay", type=float, default=0.0, help="after the drive [s]")
    one.set_defaults(run=robot)
    one = parts.add_parser("listener")
    one.add_argument("file")
    one.set_defaults(run=listener)
    one = parts.add_parser("click")
    one.add_argument("pose")
    one.set_defaults(run=click)
    one = parts.add_parser("vandal")
    one.set_defaults(run=vandal)
    for part in parts.choices.values():
        part.add_argument("--domain", type=int, default=0)
    signal.signal(signal.SIGTERM, lambda *_: exit(0))
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
