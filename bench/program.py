"""Runs the program and measures what it takes: wall time, CPU time, peak memory, for the whole
process."""
import json
import os
import pathlib
import statistics
import subprocess
import sys

MEGABYTE = 1e6
ONE_PROCESSOR = ["taskset", "--cpu-list", "0"]


class Failed(Exception):
    """The program ended with an error; the text has the command and what it said."""


LAUNCHER = [sys.executable, "-I", "-S", str(pathlib.Path(__file__).with_name("launch.py"))]


def run(command, check=True, folder=None):
    """Runs a command; returns its stdout and what it took, as measured by the kernel for this one
    process (launch.py)."""
    words = [str(word) for word in command]
    books, report = os.pipe()
    process = subprocess.Popen(
        [*LAUNCHER, str(report), *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=folder,
        pass_fds=[report],
    )
    os.close(report)
    output, errors = (text.decode() for text in process.communicate())
    with os.fdopen(books) as pipe:
        figures = pipe.read().split()
    if check and process.returncode != 0 or len(figures) != 3:
        raise Failed(f"{' '.join(words)}\nended with {process.returncode}\n{errors}")
    wall_s, cpu_s, peak_bytes = map(float, figures)
    return output, {"wall_s": wall_s, "cpu_s": cpu_s, "peak_mb": peak_bytes / MEGABYTE}


class Loopstone:
    """The program, with the commands that the tables need. Outputs go into folders of their own
    under `work`."""

    def __init__(self, program, work):
        self.program = pathlib.Path(program)
        self.work = pathlib.Path(work)
        if not os.access(self.program, os.X_OK):
            raise SystemExit(f"{self.program}: no such program; `make build` leaves it there")

    def version(self):
        return run([self.program, "--version"])[0].strip()

    def simulate(self, world, seed, flags=()):
        folder = self.work / "-".join(
            ["sim", world, str(seed), *[str(f).strip("-") for f in flags]]
        )
        if not (folder / "truth.tum").exists():
            run(
                [
                    self.program,
                    "simulate",
                    world,
                    "-o",
                    folder,
                    "--seed",
                    seed,
                    *flags,
                    "--force",
                    "--quiet",
                ]
            )
        return folder

    def odometry(self, log):
        path = self.work / "odometry.tum"
        run([self.program, "odometry", log, "-o", path, "--force", "--quiet"])
        return path

    def map(self, log, name, flags=(), pinned=True):
        """Maps a log; returns the output folder, the figures of summary.json and what the process
        took.

        With one thread everything is on one processor, and always the same: the search for loops
        has a thread of its own in any case. Runs side by side are not to be pinned."""
        folder = self.work / ("map-" + name)
        words = [str(flag) for flag in flags]
        one = pinned and "--threads" in words and words[words.index("--threads") + 1] == "1"
        _, cost = run(
            [
                *(ONE_PROCESSOR if one else []),
                self.program,
                "map",
                log,
                "-o",
                folder,
                "--force",
                "--quiet",
                *flags,
            ]
        )
        return folder, json.loads((folder / "summary.json").read_text()), cost

    def evaluate(self, *flags):
        return json.loads(run([self.program, "evaluate", *flags, "--json", "--quiet"])[0])


def log_of(folder):
    """What is to be mapped of a simulation, in the format that it was asked for."""
    log = pathlib.Path(folder) / "log.clf"
    return log if log.exists() else folder


def median(values):
    return statistics.median(values)


def say(text):
    print(text, file=sys.stderr, flush=True)
