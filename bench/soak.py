#!/usr/bin/env python3
"""Drives `loopstone live` for a day: 24 simulated hours in an office at 20 times their pace, with
three clients of the view, of which one reads slowly and one leaves and comes back all the time.
Tells whether memory and open files stay bounded, and how good the map is in the end. Writes the
table of docs/live.md.

  bench/soak.py                        an hour and a quarter, of which some minutes to simulate it
  bench/soak.py --quick                half an hour of it, in two minutes; writes nothing into docs/
  bench/soak.py --hours 4 --speed 50   other drives; likewise

What is sampled of the full run is kept in build/bench/soak.json while it goes, of any other in
soak-some.json. A run that ended before its log did writes nothing into docs/.
"""
import json
import math
import os
import pathlib
import shutil
import socket
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from largest_error import largest_error  # noqa: E402
from live import start  # noqa: E402
from program import MEGABYTE, Loopstone, log_of, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser, verdicts  # noqa: E402
from websocket import ViewClient  # noqa: E402

PAGE, BLOCK = "docs/live.md", "live-soak"
HOURS, SPEED = 24.0, 20.0
QUICK_HOURS = 0.5
# 23 MB an hour. Laser and wheels share a clock: two that drift would be 6 s apart after a day.
DRIVE = "--format carmen --beams 181 --scan-rate 5 --set wheels.rate_hz=10 --realism usual".split()
DRIVE += ["--set", "realism.stamps.drift_ppm=0"]
SAMPLES = 144  # of the full run: one each 30 s
SAMPLES_AT_HOME = 6  # then the guest leaves for half a step
SLOW_S = 0.1  # a message of the slow client; some hundred come each second
SLOW_BUFFER = 1 << 16  # what may wait for it in the kernel: no more than on a slow line
LEAVE_S = 5.0
ESTABLISHED = 1  # of TCP_INFO
SILENCE_S = 600.0  # while the map is finished nothing is told
END_AFTER_S = 5.0
SHARES = (1 / 24, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 1)
EARLY = 1 / 8  # what memory in the end is compared with
MEMORY_RATIO, DESCRIPTORS_MORE = 1.2, 0  # what is aimed at
STATUS = ["travelled_m", "map_m2", "submaps", "closures", "rejected", "memory_mb", "realtime"]


class Watcher(threading.Thread):
    """A client of the view that takes all topics, and keeps the last status."""

    def __init__(self, port, pause_s=0.0):
        super().__init__(daemon=True)
        self.client, self.pause_s = ViewClient(port), pause_s
        self.status, self.is_leaving = {}, False
        if pause_s > 0.0:
            self.client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SLOW_BUFFER)
        self.start()

    def run(self):
        try:
            for topic, _, payload in self.client.messages(SILENCE_S):
                if topic == "/loopstone/status":
                    self.status = json.loads(payload)
                if self.is_leaving:
                    break
                time.sleep(self.pause_s)
        except OSError:
            pass  # it was sent away
        self.client.close()

    def leave(self):
        self.is_leaving = True
        self.join(LEAVE_S)

    def is_there(self):
        """As the kernel knows it, before all that waits was read."""
        try:
            state = self.client.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 1)[0]
        except OSError:
            return False
        return state == ESTABLISHED


class Audience:
    """The three clients. Who is sent away comes back, and that is counted."""

    def __init__(self, port):
        self.port, self.sent_away = port, 0
        self.steady, self.guest = Watcher(port), Watcher(port)
        self.slow = Watcher(port, SLOW_S)

    def leave_for(self, seconds):
        """The guest, who is back then."""
        self.guest.leave()
        time.sleep(seconds)
        self.guest = Watcher(self.port)

    def come_back(self):
        for name in ("steady", "guest", "slow"):
            watcher = getattr(self, name)
            if not watcher.is_there():
                watcher.is_leaving = True
                setattr(self, name, Watcher(self.port, watcher.pause_s))
                self.sent_away += 1


def simulated(loopstone, hours):
    """A drive of so many hours: laps of one route. Kept for the next time."""
    lap_s = told(loopstone.simulate("office", 1, DRIVE))["duration_s"]
    # Laps after the first are a little shorter: the robot stands still at first.
    laps = math.ceil(1.1 * 3600 * hours / lap_s) + 1
    flags = [*DRIVE, "--laps", str(laps), "--duration", f"{3600 * hours:g}"]
    drive = loopstone.simulate("office", 1, flags)
    if not told(drive)["complete"]:  # somebody stopped that
        shutil.rmtree(drive)
        drive = loopstone.simulate("office", 1, flags)
    return drive


def told(drive):
    return json.loads((drive / "world.json").read_text())


def first_stamp(drive):
    with open(drive / "truth.tum", encoding="utf-8") as truth:
        return next(float(line.split()[0]) for line in truth if line[0] != "#")


def process_figures(pid):
    """What the kernel knows of a process: memory, open files, CPU time."""
    folder = pathlib.Path(f"/proc/{pid}")
    lines = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines())
    ticks = (folder / "stat").read_text().rsplit(")", 1)[1].split()[11:13]
    # Some are open for a moment only: a state that is saved.
    counts = []
    for _ in range(5):
        counts.append(len(os.listdir(folder / "fd")))
        time.sleep(0.02)
    return {
        "rss_mb": 1024 * int(lines["VmRSS"].split()[0]) / MEGABYTE,
        "anonymous_mb": 1024 * int(lines["RssAnon"].split()[0]) / MEGABYTE,
        "descriptors": min(counts),
        "cpu_s": sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK"),
    }


def ended(process):
    """What the process took in all, once it has ended."""
    pid, status, usage = os.wait4(process.pid, os.WNOHANG)
    if not pid:
        return None
    process.returncode = os.waitstatus_to_exitcode(status)
    return {
        "exit_code": process.returncode,
        "peak_mb": 1024 * usage.ru_maxrss / MEGABYTE,
        "cpu_s": usage.ru_utime + usage.ru_stime,
    }


def sample(process, audience, first_s, wall_s):
    status = audience.steady.status
    return {
        "wall_s": wall_s,
        "log_s": status["t"] - first_s,
        **process_figures(process.pid),
        **{name: status[name] for name in STATUS},
        "clients_sent_away": audience.sent_away,
    }


def follow(process, port, drive, step_s, keep):
    """Samples a run until it ends: what it took and said."""
    said = []
    threading.Thread(target=lambda: said.extend(process.stderr), daemon=True).start()
    audience, first_s, began = Audience(port), first_stamp(drive), time.monotonic()
    count = 0
    while not (cost := ended(process)):
        if time.monotonic() < began + (count + 0.5) * step_s:
            time.sleep(0.1)
            continue
        count += 1
        try:
            audience.come_back()
            if audience.steady.status:
                keep(sample(process, audience, first_s, time.monotonic() - began))
            if count % SAMPLES_AT_HOME == 0:
                audience.leave_for(0.5 * step_s)
        except (OSError, RuntimeError, KeyError, ValueError):
            time.sleep(0.1)  # it is about to end: nobody listens, /proc has nothing
    warnings = [line.strip() for line in said if "warning:" in line or "error:" in line]
    return {**cost, "wall_s": time.monotonic() - began, "warnings": warnings}


def judged(loopstone, out, drive):
    """What was written in the end, and how far from the truth."""
    path, truth = out / "trajectory.tum", drive / "truth.tum"
    error = loopstone.evaluate("--estimate", path, "--reference", truth, "--align", "se2")
    summary = json.loads((out / "summary.json").read_text())
    return {
        "state_mb": (out / "state.loopstone").stat().st_size / MEGABYTE,
        "ate_m": error["ate_rmse_m"],
        "worst_m": largest_error(path, truth)[0],
        "verdict": summary["quality"]["verdict"],
    }


def soak(loopstone, hours, speed, keep):
    drive, out = simulated(loopstone, hours), loopstone.work / "soak-map"
    figures = {"hours": hours, "speed": speed, "duration_s": told(drive)["duration_s"]}
    figures["samples"] = []

    def keep_sample(one):
        figures["samples"].append(one)
        keep(figures)
        say(
            f"  {one['log_s'] / 3600:5.2f} h, {one['travelled_m'] / 1000:.2f} km,"
            f" {one['map_m2']:.0f} m2, {one['submaps']} submaps, {one['closures']} closures,"
            f" {one['rss_mb']:.1f} MB, {one['descriptors']} descriptors, {one['cpu_s']:.0f} s CPU,"
            f" {behind(one, speed):.1f} s behind"
        )

    shutil.rmtree(out, ignore_errors=True)
    source = f"replay:{log_of(drive)}"
    process, port = start(
        loopstone,
        ["live", "--source", source, "--speed", speed, "-o", out, "--end-after", END_AFTER_S],
    )
    step_s = 3600 * hours / speed / SAMPLES
    figures["end"] = follow(process, port, drive, step_s, keep_sample)
    if figures["end"]["exit_code"] == 0:
        figures["end"] |= judged(loopstone, out, drive)
    keep(figures)
    return figures


def behind(one, speed):
    """The pace that was asked for [s]; a second or so is the time between two messages."""
    return one["wall_s"] - one["log_s"] / speed


def driving(figures):
    """Samples from before the log was over."""
    last_s = figures["duration_s"] - 2 * figures["speed"]
    return [one for one in figures["samples"] if one["log_s"] < last_s]


def at(figures, share):
    """The sample next to that part of the drive."""
    wanted_s = share * figures["duration_s"]
    return min(driving(figures), key=lambda one: abs(one["log_s"] - wanted_s))


def is_whole(figures):
    """Whether the log was driven to its end."""
    return at(figures, 1)["log_s"] > 0.98 * figures["duration_s"]


def targets_of(figures):
    early, last = at(figures, EARLY), at(figures, 1)
    ratio = last["rss_mb"] / early["rss_mb"]
    more = last["descriptors"] - early["descriptors"]
    code = figures["end"]["exit_code"]
    return [
        (
            "memory at the end over memory after an eighth of the day",
            f"<= {MEMORY_RATIO:g}",
            f"{ratio:.2f}",
            ratio <= MEMORY_RATIO,
        ),
        ("file descriptors grow by", f"<= {DESCRIPTORS_MORE}", f"{more}", more <= DESCRIPTORS_MORE),
        ("exit code", "0", f"{code}", code == 0),
    ]


def row_of(one):
    return [
        f"{one['log_s'] / 3600:.2f}",
        f"{one['travelled_m'] / 1000:.2f}",
        f"{one['map_m2']:.0f}",
        f"{one['submaps']}",
        f"{one['closures']}",
        f"{one['rss_mb']:.1f}",
        f"{one['descriptors']}",
        f"{one['cpu_s']:.0f}",
    ]


def end_of(figures):
    end = figures["end"]
    finish_s = end["wall_s"] - figures["duration_s"] / figures["speed"]
    late_s = max(behind(one, figures["speed"]) for one in driving(figures))
    sent_away = figures["samples"][-1]["clients_sent_away"]
    text = (
        f"The pace was kept within {late_s:.1f} s; then the map was finished and written within"
        f" {finish_s:.1f} s. Peak memory with that: {end['peak_mb']:.0f} MB. Clients sent away:"
        f" {sent_away}."
    )
    if "verdict" in end:
        text += (
            f" The path in the end is {end['ate_m']:.3f} m off the truth (rms, best aligned), at"
            f" its worst place {end['worst_m']:.3f} m, and the map is called {end['verdict']};"
            f" `state.loopstone` has {end['state_mb']:.1f} MB."
        )
    return text


def text_of(section):
    figures = section["figures"]
    header = [
        "simulated [h]>",
        "travelled [km]>",
        "map [m2]>",
        "submaps>",
        "closures>",
        "memory [MB]>",
        "file descriptors>",
        "CPU so far [s]>",
    ]
    return "\n".join(
        [
            tables.provenance(section),
            "",
            table(header, [row_of(at(figures, share)) for share in SHARES]),
            "",
            end_of(figures),
            "",
            tables.targets_table(targets_of(figures)),
        ]
    )


def main():
    parser = plain_parser(__doc__, ROOT)
    parser.add_argument("--hours", type=float, default=HOURS, help="of the simulated drive")
    parser.add_argument("--speed", type=float, default=SPEED, help="times its pace")
    arguments = parser.parse_args()
    hours = QUICK_HOURS if arguments.quick else arguments.hours
    is_full = (hours, arguments.speed) == (HOURS, SPEED)
    arguments.work.mkdir(parents=True, exist_ok=True)
    kept = arguments.work / f"soak{'' if is_full else '-some'}.json"
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    section = circumstances(loopstone.version())

    def keep(figures):
        section["figures"] = figures
        kept.write_text(json.dumps(section, indent=1))

    figures = soak(loopstone, hours, arguments.speed, keep)
    for warning in figures["end"]["warnings"]:
        say(f"  {warning}")
    text = text_of(section)
    if not (is_full and is_whole(figures)):
        print(text)
    elif write_block(ROOT / PAGE, BLOCK, text):
        say(f"wrote {PAGE}: {BLOCK}")
    print(verdicts(targets_of(figures)))


if __name__ == "__main__":
    main()
