#!/usr/bin/env python3
"""Do two builds of the program write the same bytes? Both get the same commands and the same
input, which the first one made, so that a difference shows where it arises; then all that they
wrote and printed is compared. How long it took, and in how much memory, may differ.

  tests/processors/check_same_bytes.py FIRST -- SECOND        two commands that run the program
  tests/processors/check_same_bytes.py build/release/bin/loopstone -- \\
      qemu-aarch64-static -L build/arm/sysroot build/arm/bin/loopstone
  tests/processors/check_same_bytes.py --near FIRST -- SECOND
  tests/processors/check_same_bytes.py --self-test

With --near, numbers in texts may be apart by 1e-8 (of 1, or of their size), and what is no text may
differ: for processors on which sine and exponential may differ in their last bit (docs/arm.md).
"""
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import time

# What is written, and by which command; ../1 is the folder of the first program. Loops are closed,
# people walk, the robot is searched for on the whole map, graphs are solved and certified.
STEPS = {
    "office": "simulate office -o office --seed 1 --duration 240 --beams 181",
    "map": "map ../1/office -o map --json",
    "where": "localize ../1/office --map ../1/map -o where.tum --global --duration "
    "30 --report where --json",
    "solved": "optimize ../1/map/graph.g2o -o solved.g2o --edges solved.csv --tum "
    "solved.tum --certify --json",
    "kernels": "optimize ../1/map/graph.g2o -o kernels.g2o --robust gnc --json",
    "errors": "evaluate --estimate ../1/map/trajectory.tum --reference "
    "../1/office/truth.tum --json",
    "walls": "evaluate --map ../1/map/map.yaml --true-map ../1/office/map.yaml --json",
    "loops": "simulate loops -o loops --seed 3 --duration 10 --beams 61 --people 3 "
    "--realism usual,uneven",
    "hall": "simulate hall -o hall --seed 2 --duration 3 --beams 31 --realism "
    "usual --format carmen",
    "lit": "simulate warehouse -o lit --seed 3 --duration 40 --beams 361 "
    "--reflectors 40 --format mcap",
    "beacons": "localize ../1/lit/log.mcap --landmarks ../1/lit/landmarks.csv -o "
    "beacons.tum --global --json",
    "coloured": "simulate office -o coloured --seed 4 --duration 4 --beams 91 --rgbd",
    "floor": "map ../1/coloured -o floor --cloud --json",
}
NEAR = 1e-8

# What tells of the run and not of its result.
RUN_KEYS = re.compile(
    r"wall_time_s|cpu_time_s|\w+_wall_s|realtime_factor|scans_per_s|peak_memory_bytes"
)
RUN_KEYS_BESIDE_CPU_TIME = ("read_s", "start_s", "certify_s", "solve_s")
RUN_ROW = re.compile(
    r'<tr><th scope="row">([^<]*, wall|wall time|CPU time[^<]*|speed|peak memory)</th>'
    r"|\(\d[\d.,]* times real time\)"
)
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def without_run(value):
    """A JSON value without what tells of the run."""
    if isinstance(value, list):
        return [without_run(v) for v in value]
    if not isinstance(value, dict):
        return value
    beside = RUN_KEYS_BESIDE_CPU_TIME if "cpu_time_s" in value else ()
    return {
        k: without_run(v) for k, v in value.items() if not RUN_KEYS.fullmatch(k) and k not in beside
    }


def contents(name, data):
    """What is compared of a file."""
    if name.endswith((".json", "stdout")) and data.startswith(b"{"):
        return json.dumps(without_run(json.loads(data)), indent=1).encode()
    if name.endswith(".html"):
        lines = data.decode().split("\n")
        return "\n".join(line for line in lines if not RUN_ROW.search(line)).encode()
    return data


def is_near(a, b):
    """Are two texts the same but for the last digits of their numbers? Also true of what is no
    text."""
    try:
        first, second = a.decode(), b.decode()
    except UnicodeDecodeError:
        return True
    if NUMBER.sub("#", first) != NUMBER.sub("#", second):
        return False
    pairs = zip(NUMBER.findall(first), NUMBER.findall(second))
    return all(math.isclose(float(x), float(y), rel_tol=NEAR, abs_tol=NEAR) for x, y in pairs)


def first_difference(a, b):
    """Words on where two files part."""
    lines = [data.split(b"\n") for data in (a, b)]
    for number, (x, y) in enumerate(zip(*lines), 1):
        if x != y:
            column = next((i for i, (p, q) in enumerate(zip(x, y)) if p != q), min(len(x), len(y)))
            parts = [repr(line[max(column - 30, 0) : column + 30]) for line in (x, y)]
            return f"line {number}: {parts[0]} and {parts[1]}"
    return f"{len(a)} and {len(b)} bytes"


def do_step(program, name, folder):
    words = [*program, *STEPS[name].split(), "--quiet"]
    done = subprocess.run(words, cwd=folder, capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}: exit code {done.returncode}\n{done.stderr.decode()}")
    (folder / f"{name}.stdout").write_bytes(done.stdout)
    (folder / f"{name}.stderr").write_bytes(done.stderr)


def files_in(folder):
    return {str(p.relative_to(folder)): p for p in folder.rglob("*") if p.is_file()}


def compare(folders, near, done):
    """Says what differs, of what is not in `done` yet. Returns how much, and of how many."""
    first, second = (files_in(folder) for folder in folders)
    different, count = 0, 0
    for name in sorted({*first, *second} - done):
        count += 1
        done.add(name)
        if name not in first or name not in second:
            print(f"  {name}: written by one alone")
            different += 1
            continue
        a, b = (contents(name, files[name].read_bytes()) for files in (first, second))
        if a == b:
            continue
        if near and is_near(a, b):
            print(f"  {name}: near")
            continue
        print(f"  {name} differs, {first_difference(a, b)}")
        different += 1
    return different, count


def main(programs, near):
    # They are called from elsewhere.
    programs = [
        [str(pathlib.Path(w).resolve()) if pathlib.Path(w).exists() else w for w in p]
        for p in programs
    ]
    different, count, done = 0, 0, set()
    with tempfile.TemporaryDirectory() as work:
        folders = [pathlib.Path(work) / "1", pathlib.Path(work) / "2"]
        for folder in folders:
            folder.mkdir()
        for name in STEPS:
            start = time.monotonic()
            for program, folder in zip(programs, folders):
                do_step(program, name, folder)
            more_different, more = compare(folders, near, done)
            different, count = different + more_different, count + more
            seconds = time.monotonic() - start
            same = more - more_different
            print(f"{name}: {same} of {more} the same, {seconds:.1f} s", flush=True)
    print(f"{different} of {count} files differ")
    return 1 if different or not count else 0


def self_test():
    """A planted difference of each kind is found, and what tells of the run is none."""
    run = b'{"a": 1.5, "cpu_time_s": 3.0, "start_s": 2.0, "b": [{"start_s": 1.0}]}'
    assert contents("x.json", run) == contents("x.json", run.replace(b"3.0", b"4.0"))
    assert contents("x.json", run) == contents("x.json", run.replace(b"2.0", b"4.0"))
    assert contents("x.json", run) != contents("x.json", run.replace(b"1.0", b"4.0"))
    assert contents("x.json", run) != contents("x.json", run.replace(b"1.5", b"1.6"))
    row = b'<tr><th scope="row">wall time</th><td>1 s</td></tr>\n<p>2 m</p>'
    assert contents("r.html", row) == contents("r.html", row.replace(b"1 s", b"2 s"))
    assert contents("r.html", row) != contents("r.html", row.replace(b"2 m", b"3 m"))
    assert contents("map.pgm", b"1") != contents("map.pgm", b"2")
    assert is_near(b"x 1.00000000001, 7", b"x 1.00000000002, 7")
    assert not is_near(b"x 1.001", b"x 1.002")
    assert not is_near(b"x 1.0", b"y 1.0")
    assert not is_near(b"1 2", b"1 2 3")
    with tempfile.TemporaryDirectory() as work:
        folders = [pathlib.Path(work) / "1", pathlib.Path(work) / "2"]
        for folder, text in zip(folders, ("1 0", "1 1")):
            folder.mkdir()
            (folder / "same").write_text("1")
            (folder / "seen").write_text(text)
            (folder / "other").write_text(text)
        (folders[0] / "alone").write_text("")
        done = {"seen"}
        assert compare(folders, False, done) == (2, 3)
        assert compare(folders, True, done) == (0, 0)
    print("planted differences are found")
    return 0


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        sys.exit(self_test())
    is_for_near = arguments[:1] == ["--near"]
    if "--" not in arguments:
        sys.exit(__doc__)
    words = arguments[1:] if is_for_near else arguments
    between = words.index("--")
    sys.exit(main((words[:between], words[between + 1 :]), is_for_near))
