"""What every generated table says of itself: what was run, of which commit, when, where. It is
written and read here alone."""
import datetime
import os
import pathlib
import platform
import re
import shlex
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# What a figure can depend on; docs/ is not among it, since writing the tables changes that.
SOURCES = [
    "include",
    "src",
    "apps",
    "bench",
    "scripts",
    "python/fleet/loopstone_fleet",
    "robots",
    "cmake",
    "CMakeLists.txt",
    "CMakePresets.json",
]
BUSY_LOAD = 0.3

STAMP = re.compile(
    r"`([^`]+)`, loopstone ([\w.+-]+), commit (\w+)(?: with changes in [^,]+)?, (\d{4}-\d\d-\d\d),"
)


def git(*words, root=ROOT):
    """The answer of git, or None where there is no repository, no git, or no such thing."""
    try:
        done = subprocess.run(
            ["git", "-C", str(root), *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            check=False,
        )
    except OSError:
        return None
    return done.stdout.decode() if done.returncode == 0 else None


def changed_sources(root=ROOT):
    """Sources that are not as the commit has them, without what git ignores."""
    lines = (git("status", "--porcelain", "--", *SOURCES, root=root) or "").splitlines()
    return [line[3:] for line in lines]


def processor_ticks():
    """Of all processors since the machine was started: at work, and altogether."""
    with open("/proc/stat", encoding="utf-8") as stat:
        ticks = [int(word) for word in stat.readline().split()[1:9]]
    idle = ticks[3] + ticks[4]  # waiting for a disk included
    return sum(ticks) - idle, sum(ticks)


def load_now(seconds=1.0):
    """How many processors are at work. What ran before does not count, as it would in a mean over
    the last minute."""
    try:
        work, total = processor_ticks()
        time.sleep(seconds)
        more_work, more_total = processor_ticks()
    except OSError:
        return os.getloadavg()[0]
    return os.cpu_count() * (more_work - work) / max(more_total - total, 1)


def machine():
    """The processor and how many of it there are, and how busy it is."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as info:
            names = [
                line.split(":", 1)[1].strip() for line in info if line.startswith("model name")
            ]
        model = names[0] if names else model
    except OSError:
        pass
    count = len(os.sched_getaffinity(0))
    return {"processor": model, "processors": count, "load": load_now()}


def command_line(arguments):
    """As it was called, with paths from the repository's root."""
    first, *rest = (word.replace(f"{ROOT}{os.sep}", "") for word in arguments)
    script = pathlib.Path(first)
    if not script.is_absolute() and (ROOT / "bench" / script.name).exists():
        first = f"bench/{script.name}"
    return shlex.join([first, *rest])


def circumstances(version):
    """Kept beside the figures of a section. `version` is what `loopstone --version` says."""
    return {
        "machine": machine(),
        "version": version,
        "commit": (git("rev-parse", "--short=10", "HEAD") or "").strip(),
        "changed": changed_sources(),
        "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
        "command": command_line(sys.argv),
    }


def told(section):
    commit = f"commit {section['commit']}" if section.get("commit") else "commit not recorded"
    if section.get("changed"):
        names = section["changed"]
        commit += " with changes in " + (names[0] if len(names) == 1 else f"{len(names)} files")
    return (
        f"`{section['command']}`, {section['version']}, {commit},"
        f" {section.get('date', 'date not recorded')}, {section['machine']['processors']} x"
        f" {section['machine']['processor']}."
    )


def provenance(*sections):
    """What was run, of which commit, when, where, and how busy the machine was; once where sections
    share it."""
    sentences = list(dict.fromkeys(told(section) for section in sections))
    load = max(section["machine"]["load"] for section in sections)
    if load > BUSY_LOAD:
        sentences.append(
            f"The machine was busy with other work ({load:.1f} processors at work before the"
            " run), so wall times are longer than on a quiet one; CPU times suffer less."
        )
    return " ".join(sentences)


def stamps_of(text):
    """(script, version, commit) of every stamp in a block."""
    return [
        (found.group(1).split()[0], found.group(2), found.group(3))
        for found in STAMP.finditer(text)
    ]
