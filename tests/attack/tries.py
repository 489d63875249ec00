"""Tries an input, in a fuzz target or in the program, and judges how that went. A verdict is an
empty text, or the fault."""

import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import struct
import subprocess
import time
from dataclasses import dataclass, replace

#: A process may wait so many times its processor time.
WAIT_FACTOR = 6
CONTROL = re.compile(rb"[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]")
FOREIGN = re.compile(
    rb"\[json\.exception|std::|basic_string|vector::|yaml-cpp|terminate"
    rb" called|[Ss]egmentation|libpng|what\(\)"
)
SANITIZER = re.compile(
    rb"(?:ERROR|WARNING): (?:Address|Leak|Memory|Thread)Sanitizer[^\n]*|runtime error:[^\n]*"
)
#: All files are given by their full names; another one than the input may be at fault.
NAMES_A_FILE = re.compile(rb"loopstone: [^:\n]*/")
NAME_BEFORE = re.compile(rb"/[^\s:']*$")
DIGITS = re.compile(rb"\d{61}")
EXIT_CODES = (0, 1, 2, 3)


@dataclass
class Limits:
    seconds: int = 10
    megabytes: int = 1024
    addresses: bool = True  # a sanitizer's shadow takes terabytes of them

    def for_file(self, size):
        """What the memory budget grants a picture of that size comes on top."""
        return replace(self, megabytes=self.megabytes + (2048 * size >> 20))


@dataclass
class Trial:
    fault: str = ""
    ms: int = 0
    kb: int = 0
    code: int = 0


class Target:
    """A fuzz target that tries inputs, each in a process of its own (attack_server.cpp)."""

    def __init__(self, program, limits):
        self.command = [str(program), "--attack", str(limits.seconds), str(limits.megabytes)]
        self.process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process:
            self.process.stdin.close()
            self.process.wait()
            self.process.stdout.close()

    def attack(self, data):
        if self.process is None:
            self.process = subprocess.Popen(
                self.command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        self.process.stdin.write(struct.pack("<I", len(data)) + data)
        self.process.stdin.flush()
        words = self.process.stdout.readline().decode("utf-8", "replace").rstrip("\n").split(" ", 3)
        if words[0] not in ("ok", "fault"):
            raise SystemExit("attack: %s ended" % " ".join(self.command))
        return Trial(words[3] if words[0] == "fault" else "", int(words[1]), int(words[2]))


def run_limited(command, folder, limits):
    """\\return exit code as subprocess gives it, stdout, stderr, usage; code None when it took too
    long"""

    def limit():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (limits.seconds, limits.seconds))
        if limits.addresses:
            # Threads take stacks and arenas of addresses that they never touch.
            resource.setrlimit(resource.RLIMIT_AS, (2 * limits.megabytes << 20,) * 2)

    with open(folder / "stdout", "w+b") as out, open(folder / "stderr", "w+b") as err:
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, preexec_fn=limit, cwd=folder
        )
        end = time.monotonic() + WAIT_FACTOR * limits.seconds
        pause, code = 0.001, None
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                code = os.waitstatus_to_exitcode(status)
                process.returncode = code
                break
            if time.monotonic() > end:
                process.kill()
                _, _, usage = os.wait4(process.pid, 0)
                process.returncode = -9
                break
            time.sleep(pause)
            pause = min(0.02, 1.5 * pause)
        out.seek(0)
        err.seek(0)
        return code, out.read(1 << 22), err.read(1 << 22), usage


def digest(path):
    if path.is_dir():
        return [
            (str(inner.relative_to(path)), digest(inner))
            for inner in sorted(path.rglob("*"))
            if inner.is_file()
        ]
    return hashlib.sha256(path.read_bytes()).hexdigest()


def wrong_figures(value, key=""):
    """Of a result: what is no figure, or a share that is none."""
    if isinstance(value, dict):
        return next(filter(None, (wrong_figures(inner, name) for name, inner in value.items())), "")
    if isinstance(value, list):
        return next(filter(None, (wrong_figures(inner, key) for inner in value)), "")
    if (
        isinstance(value, (int, float))
        and key.endswith("_share")
        and not -1e-9 <= value <= 1 + 1e-9
    ):
        return "%s is %r" % (key, value)
    return ""


def refuse_constant(text):
    raise ValueError(text)


def wrong_words(code, out, err, named, given):
    """What a user would rightly complain about. Errors may quote what they were given."""
    said = SANITIZER.search(err)
    if said:
        return "sanitizer: " + said.group().decode("utf-8", "replace")
    for name, stream in (("stderr", err), ("stdout", out)):
        found = CONTROL.search(stream)
        if found:
            return "words: control character %r on %s" % (found.group(), name)
        try:
            stream.decode("utf-8")
        except UnicodeDecodeError as error:
            if error.end < 1 << 22:
                return "words: no UTF-8 on %s: %r" % (
                    name,
                    error.object[error.start : error.start + 8],
                )
    for pattern, reason in (
        (FOREIGN, "another library's sentence"),
        (DIGITS, "a number of more than 60 digits"),
    ):
        found = pattern.search(err)
        # Names of files are told in full.
        if found and pattern is DIGITS and NAME_BEFORE.search(err[: found.start()]):
            continue
        if found and (pattern is DIGITS or found.group() not in given):
            return "words: %s: %r" % (reason, err[max(0, found.start() - 60) : found.end() + 40])
    if len(err) > 200_000:
        return "words: %d bytes on stderr" % len(err)
    if b"out of memory" in err:
        return "bloat: out of memory"
    if code in (1, 2) and b"loopstone: " not in err:
        return "words: exit code %d without an error" % code
    if code == 1 and named not in err and not NAMES_A_FILE.search(err):
        return "words: the error does not name the file: %r" % err[-200:]
    return ""


def judge(code, out, err, usage, limits, named, is_json, given=b""):
    kb = usage.ru_maxrss
    if code is None or code in (-24, -9):
        return "hang: no end within %d s" % limits.seconds
    said = SANITIZER.search(err)
    if code not in EXIT_CODES:
        return "exit code %d%s" % (
            code,
            ": " + said.group().decode("utf-8", "replace") if said else "",
        )
    if kb > limits.megabytes << 10:
        return "bloat: %d MB" % (kb >> 10)
    fault = wrong_words(code, out, err, named, given)
    if not fault and is_json and code == 0:
        try:
            fault = wrong_figures(json.loads(out, parse_constant=refuse_constant))
        except ValueError as error:
            fault = "no JSON: %s" % error
        if fault:
            fault = "figures: " + fault
    return fault


class Program:
    """The program, given spoiled files as a user would."""

    def __init__(self, program, good, folder, limits):
        self.program, self.good, self.limits = str(program), good, limits
        self.folder = pathlib.Path(folder)

    def attack(self, fmt, command, data, seed):
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        given = fmt.place(self.folder, data, fmt.suffix, seed, self.good.folder)
        before = digest(given)
        words = dict(self.good.arguments)
        words["in"], words["out"] = given, self.folder / "out"
        arguments = [word.format(**words) for word in command.split()]
        limits = self.limits.for_file(len(data))
        code, out, err, usage = run_limited([self.program, *arguments], self.folder, limits)
        fault = judge(code, out, err, usage, limits, b"input", "--json" in command, data)
        if not fault:
            fault = self.spoilt_by_it(fmt, given, before)
        spent = int(1000 * (usage.ru_utime + usage.ru_stime))
        return Trial(
            "%s  [loopstone %s]" % (fault, command) if fault else "",
            spent,
            usage.ru_maxrss,
            code if code is not None else -9,
        )

    def spoilt_by_it(self, fmt, given, before):
        """Whether the program left half a file behind, or changed its input."""
        half = [path.name for path in self.folder.rglob("*") if ".partial" in path.name]
        if half:
            return "left behind: %s" % half[0]
        if fmt.name != "session" and digest(given) != before:
            return "its input was changed"
        return ""
