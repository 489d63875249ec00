#!/usr/bin/env python3
"""Proves that the attack can fail: planted faults are found, and its inputs are what they should
be.

    self_test.py PROGRAMS      the folder of attack_planted, loopstone and the fuzz targets
"""

import json
import pathlib
import random
import stat
import subprocess
import sys
import tempfile
import unittest

import formats as table
from good_files import GoodFiles
from mutate import BYTES, TEXT, spoil
from tries import Limits, Program, Target, wrong_figures

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = None
LIMITS = Limits(seconds=2, megabytes=200)
#: An attacked program that has the fault that its input names.
FAULTY = (
    """#!%s
import os, pathlib, sys, time
given = pathlib.Path(sys.argv[2])
word = given.read_text()
if word == "crash": os.abort()
if word == "odd exit": sys.exit(9)
if word == "hang":
    while True: pass
if word == "bloat": kept = b"x" * (250 << 20)
if word == "half": (given.parent / ".out.1-0.partial").write_text("x")
if word == "overwrite": given.write_text("")
if word == "escape": sys.exit("loopstone: input.tum: \\033[2J")
if word == "nameless": sys.exit("loopstone: something is wrong")
if word == "wordless": sys.exit(1)
if word == "foreign": sys.exit("loopstone: input.tum: [json.exception.parse_error.101]")
if word == "digits": sys.exit("loopstone: input.tum: " + "9" * 309)
if word == "no json": print("NaN")
if word == "share": print('{"kept_share": 1.5}')
if word in ("good", "half", "overwrite", "bloat"): print("{}")
if word == "refused": sys.exit("loopstone: input.tum:1: no number")
"""
    % sys.executable
)


class FindsPlantedFaults(unittest.TestCase):
    def test_in_a_target(self):
        with Target(PROGRAMS / "attack_planted", LIMITS) as target:
            for word, expected in (
                ("crash", ""),
                ("trap", ""),
                ("overflow", ""),
                ("hang", "hang"),
                ("bloat", ""),
                ("throw", "exception: uncaught: nobody"),
                ("throw a number", "exception"),
                ("exit", "exit 5"),
            ):
                fault = target.attack(word.encode()).fault
                self.assertTrue(fault and fault.startswith(expected), "%s: %r" % (word, fault))
                self.assertEqual(target.attack(b"good").fault, "")

    def test_in_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            faulty = pathlib.Path(folder) / "faulty"
            faulty.write_text(FAULTY)
            faulty.chmod(faulty.stat().st_mode | stat.S_IXUSR)
            good = type("Good", (), {"arguments": {}, "folder": pathlib.Path(folder)})
            program = Program(faulty, good, pathlib.Path(folder) / "work", LIMITS)
            fmt = table.Format("tum", "tum", [], ".tum")

            def fault_of(word):
                return program.attack(fmt, "evaluate {in} --json", word.encode(), "seed").fault

            for word, expected in (
                ("crash", "exit code -6"),
                ("odd exit", "exit code 9"),
                ("hang", "hang"),
                ("bloat", "bloat"),
                ("half", "left behind"),
                ("overwrite", "its input"),
                ("escape", "words"),
                ("nameless", "words"),
                ("wordless", "words"),
                ("foreign", "words"),
                ("digits", "words"),
                ("no json", "figures"),
                ("share", "figures"),
            ):
                fault = fault_of(word)
                self.assertTrue(fault.startswith(expected), "%s: %r" % (word, fault))
            self.assertEqual(fault_of("good"), "")
            self.assertEqual(fault_of("refused"), "")

    def test_in_figures(self):
        self.assertEqual(wrong_figures({"a": [{"kept_share": 1.0}, {"length": 7}]}), "")
        self.assertNotEqual(wrong_figures({"a": [{"kept_share": 1.01}]}), "")


class MakesInputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.good = GoodFiles(
            PROGRAMS / "loopstone",
            pathlib.Path(cls.folder.name) / "good",
            ROOT / "robots" / "ucsd.toml",
        )

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_every_target_is_attacked(self):
        targets = {path.stem[len("fuzz_") :] for path in (ROOT / "fuzz").glob("fuzz_*.cpp")}
        self.assertEqual(targets, {fmt.target for fmt in table.FORMATS})

    def test_every_log_format_of_the_program_is_attacked(self):
        told = subprocess.run(
            [PROGRAMS / "loopstone", "info", "--formats", "--json"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        self.assertEqual(
            {entry["name"] for entry in json.loads(told)["formats"]},
            {fmt.log for fmt in table.FORMATS} - {""},
        )

    def test_every_format_has_seeds_of_each_kind(self):
        for fmt in table.FORMATS:
            for pattern in fmt.seeds:
                one = table.Format(fmt.name, fmt.target, [pattern], fmt.suffix)
                self.assertTrue(
                    table.seeds_of(one, ROOT / "fuzz" / "corpus", self.good.folder),
                    "%s: %s" % (fmt.name, pattern),
                )

    def test_what_is_packed_again_without_damage_reads_as_before(self):
        for fmt in table.FORMATS:
            if fmt.wrap is None or fmt.name == "session":
                continue
            for name, data in table.seeds_of(fmt, ROOT / "fuzz" / "corpus", self.good.folder):
                parts = fmt.wrap.unpack(data)
                self.assertEqual(
                    fmt.wrap.unpack(fmt.wrap.pack(parts)), parts, "%s: %s" % (fmt.name, name)
                )

    def test_the_program_takes_what_is_not_spoiled(self):
        """Else an attack would knock at the door and never get in."""
        limits = Limits(seconds=30, megabytes=1024, addresses=False)
        program = Program(
            PROGRAMS / "loopstone", self.good, pathlib.Path(self.folder.name) / "work", limits
        )
        for fmt in filter(lambda fmt: fmt.commands, table.FORMATS):
            seeds = table.seeds_of(fmt, ROOT / "fuzz" / "corpus", self.good.folder)
            with self.subTest(format=fmt.name):
                self.assertTrue(
                    any(
                        program.attack(fmt, command, data, name).code == 0
                        for command in fmt.commands
                        for name, data in seeds
                    )
                )

    def test_the_same_seed_spoils_alike(self):
        text, donor = b"a 1 2\nb 3 4\n" * 20, b"c 5 6\n" * 20
        for mutators in (TEXT, BYTES):
            made = [
                [spoil(text, random.Random("1/%d" % i), donor, mutators) for i in range(300)]
                for _ in range(2)
            ]
            self.assertEqual(made[0], made[1])
            self.assertGreater(len(set(made[0])), 250)


if __name__ == "__main__":
    PROGRAMS = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main(verbosity=1)
