#!/usr/bin/env python3
"""Measures `loopstone live`: how long after a scan was sent a client of the view has its pose, and
what the view costs the mapper. Writes the table of docs/live.md.

  bench/live.py            two minutes; nothing else should run
  bench/live.py --quick    a quarter of that; writes nothing into docs/
"""
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, log_of, median, run, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser, verdicts  # noqa: E402
from websocket import ViewClient  # noqa: E402

PAGE, BLOCK = "docs/live.md", "live-figures"
LATENCY_S, OVERHEAD_ALONE, OVERHEAD_THREE = 0.1, 0.05, 0.2  # what is aimed at
LOOK_S = 3.0  # until then `live` looks at what a source tells of the robot
CLIENTS = 3


class Pacer(threading.Thread):
    """Sends a CARMEN log to whoever connects, each line when a robot would have, and notes when."""

    def __init__(self, lines, seconds):
        super().__init__(daemon=True)
        self.lines, self.seconds, self.sent = lines, seconds, {}
        self.server = socket.create_server(("127.0.0.1", 0))
        self.url = f"tcp://127.0.0.1:{self.server.getsockname()[1]}"

    def run(self):
        client, _ = self.server.accept()
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        begin, first = time.monotonic(), None
        for stamp, line in self.lines:
            first = stamp if first is None else first
            if stamp - first > self.seconds:
                break
            time.sleep(max(0.0, begin + stamp - first - time.monotonic()))
            self.sent[round(1e9 * stamp)] = time.monotonic()
            client.sendall(line)
        client.close()
        self.server.close()


def lines_of(log):
    """Stamps and lines of the scans and of odometry."""
    lines = []
    for line in log.read_bytes().splitlines(keepends=True):
        words = line.split()
        if words and words[0] in (b"FLASER", b"ROBOTLASER1", b"ODOM"):
            lines.append((float(words[-3]), line))
    return lines


def start(loopstone, arguments):
    """The program, and the port of its view."""
    process = subprocess.Popen(
        [loopstone.program, *map(str, arguments), "--force", "--port", "0", "--no-open"]
        + ["--threads", "2"],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    for line in process.stderr:
        found = re.search(r"view at http://127.0.0.1:(\d+)/", line)
        if found:
            return process, int(found[1])
    raise SystemExit(f"loopstone {arguments[0]} has no view")


def listen(port, topics=None):
    """A client that takes all that comes."""

    def work():
        for _ in ViewClient(port, topics).messages(60.0):
            pass

    thread = threading.Thread(target=work, daemon=True)
    thread.start()


def latency(loopstone, lines, seconds, clients):
    """From a scan's line leaving its sender to the message with its pose at a client [s]."""
    pacer = Pacer(lines, seconds)
    pacer.start()
    out = loopstone.work / f"latency-{clients}"
    process, port = start(loopstone, ["live", "--source", pacer.url, "-o", out, "--end-after", "1"])
    threading.Thread(target=process.stderr.read, daemon=True).start()
    for _ in range(clients - 1):
        listen(port)
    passed = []
    for topic, stamp, _ in ViewClient(port, {"/pose"}).messages(5.0):
        near = min(pacer.sent, key=lambda sent: abs(sent - stamp), default=None)
        if near is None or abs(near - stamp) > 1000:
            continue
        if stamp - min(pacer.sent) > 1e9 * LOOK_S:
            passed.append(time.monotonic() - pacer.sent[near])
    process.kill()
    process.wait()
    passed.sort()
    if len(passed) < 20:
        raise SystemExit(f"only {len(passed)} poses came")
    return {
        "poses": len(passed),
        "median_s": median(passed),
        "p99_s": passed[int(0.99 * (len(passed) - 1))],
    }


def cpu_of(loopstone, log, name, view, clients):
    """CPU time of a map made as fast as it goes [s]."""
    command = ["map", log, "-o", loopstone.work / name]
    if not view:
        return run([loopstone.program, *command, "--force", "--threads", 2])[1]["cpu_s"]
    process, port = start(loopstone, [*command, "--view"])
    for _ in range(clients):
        listen(port)
    for line in process.stderr:
        if "the view stays at" in line:
            break
    # Of this child alone, which is waited for here.
    process.send_signal(signal.SIGINT)
    _, process.returncode, usage = os.wait4(process.pid, 0)
    return usage.ru_utime + usage.ru_stime


def overheads(loopstone, log, rounds):
    """Each round runs all ways one after the other; the median of each way counts."""
    ways = {"without": (False, 0), "alone": (True, 0), "three": (True, CLIENTS)}
    seconds = {way: [] for way in ways}
    for i in range(rounds):
        for way, (view, clients) in ways.items():
            seconds[way].append(cpu_of(loopstone, log, f"cpu-{way}", view, clients))
        say(f"  round {i + 1}: " + ", ".join(f"{w} {s[-1]:.2f} s" for w, s in seconds.items()))
    return {way: median(values) for way, values in seconds.items()}


def text_of(section):
    figures = section["figures"]
    cpu = figures["cpu_s"]
    return "\n".join(
        [
            tables.provenance(section),
            "",
            "From a scan's line on the wire (loopback) to its pose at a client, a simulated "
            "office at its own pace:",
            "",
            table(
                ["clients>", "poses>", "median [ms]>", "99 % within [ms]>"],
                [
                    [
                        str(row["clients"]),
                        str(row["poses"]),
                        f"{1e3 * row['median_s']:.1f}",
                        f"{1e3 * row['p99_s']:.1f}",
                    ]
                    for row in figures["latency"]
                ],
            ),
            "",
            "CPU time of `loopstone map` of a simulated campus, as fast as it goes:",
            "",
            table(
                ["view", "CPU time [s]>", "more than without>"],
                [
                    ["none", f"{cpu['without']:.2f}", ""],
                    ["without clients", f"{cpu['alone']:.2f}", percent(cpu, "alone")],
                    [f"with {CLIENTS} clients", f"{cpu['three']:.2f}", percent(cpu, "three")],
                ],
            ),
            "",
            tables.targets_table(targets_of(figures)),
        ]
    )


def share(cpu, way):
    return cpu[way] / cpu["without"] - 1.0


def percent(cpu, way):
    return f"{100 * share(cpu, way):.1f} %"


def targets_of(figures):
    worst = max(row["p99_s"] for row in figures["latency"])
    cpu = figures["cpu_s"]
    return [
        (
            "from scan to client, 99th percentile",
            f"<= {1e3 * LATENCY_S:.0f} ms",
            f"{1e3 * worst:.1f} ms",
            worst <= LATENCY_S,
        ),
        (
            "CPU time of the view without clients",
            f"<= {100 * OVERHEAD_ALONE:.0f} %",
            percent(cpu, "alone"),
            share(cpu, "alone") <= OVERHEAD_ALONE,
        ),
        (
            f"CPU time of the view with {CLIENTS} clients",
            f"<= {100 * OVERHEAD_THREE:.0f} %",
            percent(cpu, "three"),
            share(cpu, "three") <= OVERHEAD_THREE,
        ),
    ]


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    section = circumstances(loopstone.version())
    office = loopstone.simulate("office", 1, ["--beams", "361"])
    log = loopstone.work / "live-office.clf"
    run([loopstone.program, "convert", office, log, "--force", "--quiet"])
    lines = lines_of(log)
    seconds, rounds = (8.0, 1) if arguments.quick else (30.0, 3)
    rows = []
    for clients in (1, CLIENTS + 1):
        rows.append({"clients": clients, **latency(loopstone, lines, seconds, clients)})
        say(f"  {clients} clients: {1e3 * rows[-1]['p99_s']:.1f} ms")
    campus = log_of(loopstone.simulate("campus", 1, ["--beams", "361"]))
    section["figures"] = {"latency": rows, "cpu_s": overheads(loopstone, campus, rounds)}
    (arguments.work / "live.json").write_text(json.dumps(section, indent=1))
    text = text_of(section)
    if arguments.quick:
        print(text)
    elif write_block(ROOT / PAGE, BLOCK, text):
        say(f"wrote {PAGE}: {BLOCK}")
    print(verdicts(targets_of(section["figures"])))


if __name__ == "__main__":
    main()
