#!/usr/bin/env python3
"""Attacks every reader, and the program itself, with spoiled files. Nothing may crash, hang, take
much memory, answer in another library's words, or leave half a file behind.

    attack.py --programs build/release/bin                       500 inputs a format
    attack.py --programs build/release/bin --inputs 20000        as `make attack` does
    attack.py ... --format png --format mat                      some formats
    attack.py ... --format png --only 17                         input number 17 again
    attack.py ... --format png --file build/attack/failures/...  a file, in the target and
                                                                 in all commands

The same seed gives the same inputs. What fell lies in OUT/failures under FORMAT-SEED-NUMBER.
"""

import argparse
import collections
import concurrent.futures
import functools
import os
import pathlib
import random
import re
import sys
import time

import formats as table
from good_files import GoodFiles
from tries import Limits, Program, Target

ROOT = pathlib.Path(__file__).resolve().parents[2]
#: One of so many inputs is given to the program, too: a process costs as much as fifty tries in a
#: target.
PROGRAM_SHARE = 20
#: An attack with so many inputs has the time for every command.
THOROUGH = 5000
SLICE = 250
#: Of processor time and of memory, for an input.
SECONDS, MEGABYTES = 10, 1024
SANITIZER_SECONDS, SANITIZER_MEGABYTES = 100, 3072
SANITIZER_OPTIONS = (
    "quarantine_size_mb=8:max_allocation_size_mb=%d:allocator_may_return_null=0" % MEGABYTES
)
KEPT_A_FORMAT = 30


def input_number(fmt, seeds, fixed, seed, number):
    """\\return the bytes and the name of the seed that they were made of"""
    if number < len(fixed):
        return fixed[number]
    rng = random.Random("%s/%s/%d" % (seed, fmt.name, number))
    name, data = rng.choice(seeds)
    _, donor = rng.choice(seeds)
    return name, fmt.spoiled(data, rng, donor)


@functools.cache
def bombs_of(name):
    return [("bomb", data) for data in format_named(name).bombs()]


class Attack:
    def __init__(self, options):
        self.options = options
        self.programs = pathlib.Path(options.programs)
        self.out = pathlib.Path(options.out)
        self.limits = (
            Limits(SANITIZER_SECONDS, SANITIZER_MEGABYTES, False)
            if options.sanitizer
            else Limits(SECONDS, MEGABYTES)
        )
        self.good = GoodFiles(
            self.programs / "loopstone", self.out / "good", ROOT / "robots" / "ucsd.toml"
        )

    def target(self, fmt):
        return Target(self.programs / ("fuzz_" + fmt.target), self.limits)

    def program(self):
        return Program(
            self.programs / "loopstone",
            self.good,
            self.out / "work" / str(os.getpid()),
            self.limits,
        )

    def run_slice(self, name, begin, end):
        """\\return (number, Trial) of the target's tries and of the program's"""
        fmt = format_named(name)
        seeds = table.seeds_of(fmt, ROOT / "fuzz" / "corpus", self.good.folder)
        # What is tried in every attack: the seeds as they are, and the bombs.
        fixed = seeds + bombs_of(name)
        program = self.program()
        in_target, in_program = [], []
        with self.target(fmt) as target:
            for number in range(begin, end):
                made_of, data = input_number(fmt, seeds, fixed, self.options.seed, number)
                trial = target.attack(data)
                in_target.append((number, trial))
                if trial.fault:
                    self.keep(fmt, number, data, trial.fault)
                for command in commands_for(
                    fmt, number, len(fixed), self.options.inputs >= THOROUGH
                ):
                    trial = program.attack(fmt, command, data, made_of)
                    in_program.append((number, trial))
                    if trial.fault:
                        self.keep(fmt, number, data, trial.fault)
        return name, in_target, in_program

    def keep(self, fmt, number, data, fault):
        folder = self.out / "failures"
        folder.mkdir(parents=True, exist_ok=True)
        stem = "%s-%s-%d" % (fmt.name, self.options.seed, number)
        if len(list(folder.glob(fmt.name + "-*.txt"))) >= KEPT_A_FORMAT:
            return
        (folder / (stem + fmt.suffix)).write_bytes(data)
        with open(folder / (stem + ".txt"), "a", encoding="utf-8") as note:
            note.write(fault + "\n")

    def run_file(self, fmt, path):
        """One file, in the target and in every command."""
        data, program = path.read_bytes(), self.program()
        with self.target(fmt) as target:
            trials = [("target", target.attack(data))]
        trials += [
            (command, program.attack(fmt, command, data, path.name.split(".")[0]))
            for command in fmt.commands
        ]
        for what, trial in trials:
            print(
                "%-8s %6d ms %6d MB  %s  %s"
                % ("exit %d" % trial.code, trial.ms, trial.kb >> 10, what, trial.fault or "ok")
            )
        return any(trial.fault for _, trial in trials)


def commands_for(fmt, number, fixed, thorough):
    """Some of what is tried goes to the program, each time to another of the commands; what is
    fixed always does, of a long attack to every command."""
    if not fmt.commands:
        return []
    if number < fixed and thorough:
        return fmt.commands
    if number < fixed:
        return [fmt.commands[number % len(fmt.commands)]]
    if number % PROGRAM_SHARE != 0:
        return []
    return [fmt.commands[number // PROGRAM_SHARE % len(fmt.commands)]]


def format_named(name):
    return next(fmt for fmt in table.FORMATS if fmt.name == name)


def kind_of(fault):
    """The same fault with other numbers is the same."""
    return re.sub(r"\d+", "0", fault)[:90]


ATTACK = None


def start_worker(options):
    global ATTACK
    ATTACK = Attack(options)


def work(task):
    return ATTACK.run_slice(*task)


class Report:
    def __init__(self, options):
        self.options = options
        self.faults = collections.defaultdict(lambda: collections.defaultdict(list))
        self.tries = collections.defaultdict(list)
        self.runs = collections.defaultdict(list)

    def add(self, name, in_target, in_program):
        self.tries[name] += [trial for _, trial in in_target]
        self.runs[name] += [trial for _, trial in in_program]
        for number, trial in in_target + in_program:
            if trial.fault:
                known = self.faults[name][kind_of(trial.fault)]
                known.append(number)
                if len(known) == 1:
                    print(
                        "FAULT %s, seed %s, input %d: %s"
                        % (name, self.options.seed, number, trial.fault),
                        flush=True,
                    )

    def line(self, name):
        tries, runs = self.tries[name], self.runs[name]
        codes = collections.Counter(trial.code for trial in runs)
        both = tries + runs
        return "%-17s %7d %6d %6d ms %5d MB %6d  %s" % (
            name,
            len(tries),
            len(runs),
            max(trial.ms for trial in both),
            max(trial.kb for trial in both) >> 10,
            sum(len(numbers) for numbers in self.faults[name].values()),
            "  ".join("%d: %d" % pair for pair in sorted(codes.items())),
        )

    def print_all(self, seconds):
        print(
            "%-17s %7s %6s %9s %8s %6s  %s"
            % ("format", "inputs", "runs", "slowest", "most", "faults", "exit codes of the runs")
        )
        for name in self.tries:
            print(self.line(name))
        for name, kinds in self.faults.items():
            for kind, numbers in sorted(kinds.items(), key=lambda pair: -len(pair[1])):
                print(
                    "%6d x %s: %s; for example --format %s --seed %s --only %d"
                    % (len(numbers), name, kind, name, self.options.seed, numbers[0])
                )
        count = sum(len(numbers) for kinds in self.faults.values() for numbers in kinds.values())
        print(
            "%d inputs and %d runs of the program in %.0f s: %s"
            % (
                sum(map(len, self.tries.values())),
                sum(map(len, self.runs.values())),
                seconds,
                (
                    "%d faults; the files are in %s"
                    % (count, pathlib.Path(self.options.out) / "failures")
                    if count
                    else "no fault"
                ),
            )
        )
        return count


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--programs",
        required=True,
        type=pathlib.Path,
        help="folder of loopstone and the fuzz targets",
    )
    parser.add_argument("--out", default=ROOT / "build" / "attack", type=pathlib.Path)
    parser.add_argument("--inputs", type=int, default=500, help="a format")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--format", action="append", choices=[fmt.name for fmt in table.FORMATS])
    parser.add_argument("--only", type=int, help="this input's number")
    parser.add_argument("--file", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--sanitizer", action="store_true", help="the programs were built with one")
    options = parser.parse_args(arguments)
    options.programs, options.out = options.programs.resolve(), options.out.resolve()
    return options


def main(arguments):
    options = parse_arguments(arguments)
    if options.sanitizer:
        os.environ["ASAN_OPTIONS"] = ":".join(
            filter(None, (os.environ.get("ASAN_OPTIONS"), SANITIZER_OPTIONS))
        )
    start = time.monotonic()
    names = options.format or [fmt.name for fmt in table.FORMATS]
    attack = Attack(options)
    if options.file:
        return int(any([attack.run_file(format_named(name), options.file) for name in names]))
    numbers = (
        [(options.only, options.only + 1)]
        if options.only is not None
        else [
            (begin, min(begin + SLICE, options.inputs)) for begin in range(0, options.inputs, SLICE)
        ]
    )
    tasks = [(name, *part) for part in numbers for name in names]
    report = Report(options)
    with concurrent.futures.ProcessPoolExecutor(
        options.jobs, initializer=start_worker, initargs=(options,)
    ) as pool:
        for done in pool.map(work, tasks):
            report.add(*done)
    return int(report.print_all(time.monotonic() - start) > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
