#!/usr/bin/env python3
"""Stands for the program: what it does with a log, the log says in its first line.

Words of that line: ok, bad, crash, hang, eat, gulp, chatter, full, kill, exit N, lie, slow S,
kill_parent, once WORD (the first time WORD, then ok). Each call of `map` leaves a file in the
folder CALLS of the environment, if that is set.
"""
import json
import os
import signal
import sys
import time

VERSION = os.environ.get("FAKE_VERSION", "9.9.9")


def note(folder, name):
    if folder:
        with open(os.path.join(folder, name), "a", encoding="utf-8") as file:
            file.write(f"{os.getpid()}\n")


def fail(code, text):
    print(f"loopstone: {text}", file=sys.stderr)
    sys.exit(code)


def write_result(out, log, name):
    os.makedirs(out)
    summary = {
        "version": VERSION,
        "log": log,
        "complete": True,
        "duration_s": 10.0,
        "scans": 100,
        "quality": {"verdict": "bad" if "bad_map" in name else "good", "possible_error_m": 0.1},
        "odometry_faults": [{"fault": "stuck"}] if "stuck" in name else [],
        "warnings": [],
    }
    with open(os.path.join(out, "trajectory.tum"), "w", encoding="ascii") as file:
        stamp = float(name.split("at")[-1].split(".")[0]) if "at" in name else 5.0
        file.write(f"# comment\n{stamp} 0 0 0 0 0 0 1\n")
    with open(os.path.join(out, "summary.json"), "w", encoding="utf-8") as file:
        json.dump(summary, file)
    print(json.dumps(summary))


def behave(words, calls, name):
    word = words[0]
    if word == "once":
        if os.path.exists(os.path.join(calls, f"seen-{name}")):
            return
        note(calls, f"seen-{name}")
        behave(words[1:], calls, name)
    elif word == "bad":
        fail(1, f"{name}: holds nothing")
    elif word == "crash":
        print("warning: about to go", file=sys.stderr, flush=True)
        os.kill(os.getpid(), signal.SIGSEGV)
    elif word == "hang":
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(600)
    elif word == "eat":
        held = []
        while True:
            held.append(bytearray(8 << 20))
            time.sleep(0.002)
    elif word == "gulp":
        try:
            bytearray(1 << 44)
        except MemoryError:
            fail(1, "out of memory")
    elif word == "chatter":
        while True:
            sys.stderr.write("again and again " * 65536)
    elif word == "full":
        fail(1, f"{name}/report.html: cannot write to this file: No space left on device")
    elif word == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    elif word == "kill_parent":  # the worker that waits for us
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(600)
    elif word == "exit":
        fail(int(words[1]), "ends strangely")
    elif word == "lie":
        sys.exit(0)
    elif word == "slow":
        time.sleep(float(words[1]))


def main():
    arguments = sys.argv[1:]
    calls = os.environ.get("CALLS", "")
    if arguments[:1] == ["--version"]:
        print(f"loopstone {VERSION}")
    elif arguments[:1] == ["config"]:
        if any(word.startswith("wrong=") for word in arguments):
            fail(2, "--set: wrong: unknown key; `loopstone config` lists all keys")
    elif arguments[:2] == ["site", "add"]:
        add_to_site(arguments, calls)
    elif arguments[:1] == ["map"]:
        log, out = arguments[1], arguments[arguments.index("-o") + 1]
        name = os.path.basename(log)
        note(calls, name)
        with open(log, encoding="utf-8") as file:
            behave(file.readline().split(), calls, name)
        write_result(out, log, name)


def add_to_site(arguments, calls):
    if os.environ.get("FAKE_NO_SITES"):
        fail(2, "there is no command site")
    if "--help" in arguments:
        print("  --topic ROLE=NAME ...  which\n  --slice LOW,HIGH  of clouds")
        return
    site, log = arguments[2:4]
    name = os.path.basename(log)
    if "refused" in name:
        fail(1, f"{name}: does not fit")
    with open(site, "a", encoding="utf-8") as file:
        file.write(f"{name}\n")
    with open(f"{site}.words", "a", encoding="utf-8") as file:
        file.write(json.dumps(arguments[4:]) + "\n")
    note(calls, f"site-{name}")
    print(json.dumps({"status": "pending" if "lonely" in name else "joined"}))


main()
