"""Small good files that the program itself makes: seeds to spoil, and company for the spoiled file
in a command."""

import bz2
import gzip
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import time

from bombs import MAT_HEAD, mat_matrix, npy_of
from wraps import Png

ROOM = """image: room.pgm
mode: trinary
resolution: 0.2
origin: [0, 0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
DRIVE = [
    "--duration",
    "5",
    "--beams",
    "41",
    "--fov",
    "240",
    "--scan-rate",
    "3",
    "--max-range",
    "20",
]


def room_picture(width=80, height=60):
    """Walls all around and a block in the middle."""
    rows = bytearray()
    for row in range(height):
        for column in range(width):
            inside = min(row, column, width - 1 - column, height - 1 - row)
            block = 30 <= column <= 44 and 24 <= row <= 36
            rows.append(205 if inside == 0 else 0 if inside == 1 or block else 254)
    return b"P5\n%d %d\n255\n" % (width, height) + bytes(rows)


def png_of(pgm):
    """The same picture as PNG, rows not filtered."""
    width, height = map(int, pgm.split()[1:3])
    pixels = pgm[-width * height :]
    rows = b"".join(b"\0" + pixels[row * width : (row + 1) * width] for row in range(height))
    return Png().pack(
        [b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0), b"IDAT" + rows, b"IEND"]
    )


def relations_of(truth):
    """The motions between poses of a trajectory that drives straight ahead, as good as any to be
    spoiled."""
    stamps = [line.split()[0] for line in truth.splitlines() if line and line[0] != "#"]
    return "".join("%s %s 0.1 0 0 0 0 0.01\n" % pair for pair in zip(stamps, stamps[1:]))


def save_session(program, log, out):
    """A run that is interrupted as soon as it has saved its state."""
    process = subprocess.Popen(
        [
            program,
            "map",
            str(log),
            "-o",
            str(out),
            "--threads",
            "1",
            "--realtime",
            "2",
            "--checkpoint",
            "0.3",
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    session = out / "session.loopstone"
    end = time.monotonic() + 20
    while not session.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    process.wait()
    return session


class GoodFiles:
    """In a folder of their own; made once for a program and used again."""

    def __init__(self, program, folder, robot_file):
        self.folder = pathlib.Path(folder)
        self.program = str(program)
        stamp = "%d" % os.stat(self.program).st_mtime_ns
        mark = self.folder / "made"
        if not mark.exists() or mark.read_text() != stamp:
            shutil.rmtree(self.folder, ignore_errors=True)
            self.make(pathlib.Path(robot_file))
            mark.write_text(stamp)
        self.arguments = {
            "log": self.folder / "carmen" / "log.clf",
            "map": self.folder / "sim" / "map.yaml",
            "truth": self.folder / "carmen" / "truth.tum",
            "cloud": self.folder / "simulated" / "corner.ply",
            "space": self.folder / "simulated" / "cloud.npy",
        }

    def run(self, *arguments):
        done = subprocess.run(
            [self.program, *map(str, arguments)],
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        if done.returncode != 0:
            raise SystemExit(
                "attack: good files can't be made: %s\n%s"
                % (" ".join(map(str, arguments)), done.stderr)
            )
        return done.stdout

    def make(self, robot_file):
        folder, seeds = self.folder, self.folder / "simulated"
        seeds.mkdir(parents=True)
        (folder / "room.yaml").write_text(ROOM)
        (folder / "room.pgm").write_bytes(room_picture())
        self.run("simulate", folder / "room.yaml", "-o", folder / "sim", *DRIVE)
        self.run(
            "simulate", folder / "room.yaml", "-o", folder / "carmen", "--format", "carmen", *DRIVE
        )
        self.run(
            "simulate",
            folder / "room.yaml",
            "-o",
            folder / "rgbd",
            "--duration",
            "1",
            "--beams",
            "41",
            "--rgbd",
        )
        log = folder / "carmen" / "log.clf"
        self.run("map", log, "-o", folder / "out", "--threads", "1")
        self.run(
            "localize",
            log,
            "--map",
            folder / "sim" / "map.yaml",
            "-o",
            folder / "where.tum",
            "--global",
        )
        self.run("match", "%s#3" % log, "%s#0" % log, "--aligned", seeds / "corner.ply")
        self.run("match", "%s#3" % log, "%s#0" % log, "--aligned", seeds / "corner.pcd")
        text = log.read_bytes()
        (seeds / "log.clf").write_bytes(text)
        (seeds / "log.clf.gz").write_bytes(gzip.compress(text, 9, mtime=0))
        (seeds / "log.clf.bz2").write_bytes(bz2.compress(text))
        for name in ("drive.mcap", "drive.bag"):
            self.run("convert", folder / "sim", seeds / name)
        self.run("convert", folder / "sim", folder / "drive", "--format", "rosbag2")
        shutil.copy(folder / "drive" / "drive_0.db3", seeds / "drive.db3")
        for path in (folder / "sim").glob("*20.npz"):
            shutil.copy(path, seeds / path.name)
        shutil.copy(folder / "out" / "graph.g2o", seeds / "graph.g2o")
        shutil.copy(folder / "out" / "trajectory.tum", seeds / "trajectory.tum")
        shutil.copy(folder / "where.csv", seeds / "where.localization.csv")
        shutil.copy(folder / "sim" / "map.yaml", seeds / "room.map.yaml")
        shutil.copy(folder / "room.pgm", seeds / "room.pgm")
        (seeds / "room.png").write_bytes(png_of(room_picture()))
        shutil.copy(robot_file, seeds / "robot.toml")
        shutil.copy(
            next((folder / "rgbd" / "dataRGBD").glob("Disparity*/*_1.png")),
            seeds / "depth.disparity.png",
        )
        numbers = (
            [0.1 * i for i in range(40)]
            + [0.05 * i * i for i in range(40)]
            + [float(i % 3) for i in range(40)]
        )
        columns = struct.pack("<120d", *numbers)
        (seeds / "cloud.mat").write_bytes(MAT_HEAD + mat_matrix(40, 3, len(columns), columns))
        (seeds / "cloud.npy").write_bytes(npy_of("(40, 3)", body=columns, fortran=True))
        (seeds / "cloud.csv").write_text(
            "x,y,z\n"
            + "".join("%g,%g,%g\n" % row for row in zip(numbers, numbers[40:], numbers[80:]))
        )
        (seeds / "options.toml").write_text(self.run("config"))
        (seeds / "truth.relations").write_text(
            relations_of((folder / "carmen" / "truth.tum").read_text())
        )
        session = save_session(self.program, log, folder / "broken_off")
        if session.exists():
            shutil.copy(session, seeds / "run.loopstone")
