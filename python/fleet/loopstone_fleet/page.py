"""One page for a fleet: what came of all logs, whom to call, and what to look at."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import datetime, timezone
from html import escape
from typing import NamedTuple
from urllib.parse import quote

from loopstone_fleet.overview import Overview, Robot, number
from loopstone_fleet.page_style import STYLE
from loopstone_fleet.progress import duration_text
from loopstone_fleet.result_store import Row
from loopstone_fleet.status import DONE, STATUSES

GALLERY_SHOWN = 6
ROBOTS_SHOWN = 200
SITES_SHOWN = 200
RENEWED_EVERY_S = 30
ROBOT_VERDICTS = ("service", "watch", "fine")


class State(NamedTuple):
    """Of the run, as the page tells it."""

    is_running: bool
    logs_of: int
    """That the manifest has."""
    table: str = "fleet.parquet"
    """Beside the page."""


def page_of(over: Overview, state: State) -> str:
    """The page as HTML. Maps are linked where they lie, beside it."""
    sections = [
        _head(over, state),
        _robots(over.robots.values()),
        _suspects(over),
        _failed(over),
        _slowest(over),
        _sites(over),
    ]
    renew = f'<meta http-equiv="refresh" content="{RENEWED_EVERY_S}">' if state.is_running else ""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"{renew}<title>{over.logs} logs</title>\n<style>{STYLE}</style></head>\n<body>\n"
        + "\n".join(section for section in sections if section)
        + "\n</body></html>\n"
    )


def _head(over: Overview, state: State) -> str:
    made = datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    failed = over.logs - over.statuses[DONE]
    counts = {
        "good": over.verdicts["good"],
        "doubtful": over.verdicts["doubtful"],
        "bad": over.verdicts["bad"],
        "unknown": over.verdicts["unknown"],
        "none": failed,
    }
    words = {"unknown": "not known", "none": "no map"}
    bar = "".join(
        f'<span class="bg-{name}" style="flex:{count}" title="{words.get(name, name)}: {count}">'
        "</span>"
        for name, count in counts.items()
        if count
    )
    key = "".join(
        f'<span><i class="bg-{name}"></i>{words.get(name, name)} {count:,}</span>'
        for name, count in counts.items()
    )
    service = [robot.name for robot in over.robots.values() if robot.verdict == "service"]
    running = f"{over.logs:,} of {state.logs_of:,} logs so far" if state.is_running else ""
    title = running or f"{over.logs:,} logs"
    versions = ", ".join(sorted(over.versions))
    where = f" Logs in {escape(over.folder)}." if over.folder else ""
    return (
        f"<h1>{title}</h1>\n<p class='verdict'>{_sentence(over, failed, len(service))}</p>\n"
        f"<div class='bar' role='img' aria-label='verdicts'>{bar}</div><div class='key'>{key}</div>"
        f"{_figures(over)}<p class='soft'>Made {made} of rows by loopstone {escape(versions)}."
        f"{where} All figures of all logs: <a href='{state.table}'>{state.table}</a>.</p>"
    )


def _sentence(over: Overview, failed: int, service: int) -> str:
    mapped = over.statuses[DONE]
    text = f"{_share(over.verdicts['good'], mapped)} of {mapped:,} maps are good"
    text += f"; {_logs(failed)} gave none. " if failed else ". "
    if service:
        text += f"{service} robot{'s need' if service > 1 else ' needs'} service."
    elif any(robot.faulty_logs for robot in over.robots.values()):
        text += "No robot needs service; some are to be watched."
    elif mapped:
        text += "No robot needs service."
    return text


def _figures(over: Overview) -> str:
    recorded, cpu = over.sums["duration_s"], over.sums["process_cpu_s"]
    cards = [
        (f"{over.sums['log_bytes'] / 1e9:.2f} GB", "of logs"),
        (duration_text(recorded), "recorded"),
        (f"{over.sums['path_length_m'] / 1e3:.2f} km", "driven"),
        (duration_text(cpu), "of processor"),
        (f"{recorded / cpu:.0f} x" if cpu else "-", "recorded time, per processor"),
        (f"{over.most['memory'] / 1e6:.0f} MB", "most memory of a log"),
    ]
    return (
        "<div class='figures'>"
        + "".join(f"<div><b>{value}</b><span>{name}</span></div>" for value, name in cards)
        + "</div>"
    )


def _robots(robots: Iterable[Robot]) -> str:
    named = [robot for robot in robots if robot.name]
    if not named:
        return ""
    named.sort(
        key=lambda robot: (ROBOT_VERDICTS.index(robot.verdict), -_share_of(robot), robot.name)
    )
    rows = []
    for robot in named[:ROBOTS_SHOWN]:
        faults = ", ".join(
            f"{kind} in {count}" for kind, count in sorted(robot.faults.items(), key=_by_count)
        )
        doubted = robot.distrusted_s / robot.recorded_s if robot.recorded_s else 0.0
        rows.append(
            [
                ("log", escape(robot.name)),
                ("", f"<span class='state {robot.verdict}'>{robot.verdict}</span>"),
                ("n", f"{robot.logs:,}"),
                ("n", f"{robot.faulty_logs:,}"),
                ("n", f"{doubted:.0%}"),
                ("", escape(faults)),
            ]
        )
    names = [
        "robot",
        "verdict",
        "maps>",
        "with faults>",
        "odometry distrusted>",
        "what, in how many logs",
    ]
    note = (
        "service: faults of odometry or laser in at least 2 logs and a quarter of all; watch: in"
        " one, or the laser does not sit where its robot's file or log says"
    )
    return _section(
        "Which robot needs service", _table(names, rows), note, len(named), ROBOTS_SHOWN
    )


def _suspects(over: Overview) -> str:
    if not over.suspects:
        return ""
    rows = [
        [
            ("log", _link(row, over.folder)),
            ("", f"<span class='state {row['quality.verdict']}'>{row['quality.verdict']}</span>"),
            ("n", f"{number(row, 'quality.possible_error_m'):.2f} m"),
            ("robot", escape(row.get("robot") or "")),
            ("", escape(str(row.get("quality.sentence") or ""))),
        ]
        for row in over.suspects
    ]
    table = _table(["log", "verdict", "may be off by>", "robot", "why"], rows)
    pictures = "".join(
        f"<figure><a href='{_address(row, 'report.html')}'><img loading='lazy' alt='map'"
        f" src='{_address(row, 'map.png')}'></a><figcaption>{_short(row, over.folder)}:"
        f" {row['quality.verdict']}</figcaption></figure>"
        for row in over.suspects[:GALLERY_SHOWN]
    )
    all_of = over.verdicts["bad"] + over.verdicts["doubtful"]
    text = f"{table}<div class='gallery'>{pictures}</div>"
    return _section("Maps not to be trusted as they are", text, "", all_of, len(rows))


def _failed(over: Overview) -> str:
    if not over.failed:
        return ""
    counts = [
        f"<b>{status}</b> {over.statuses[status]:,}: {STATUSES[status].meaning}"
        for status in STATUSES
        if status != DONE and over.statuses[status]
    ]
    rows = [
        [
            ("log", _short(row, over.folder)),
            ("", escape(row["status"])),
            ("n", str(row.get("attempts", ""))),
            ("robot", escape(row.get("robot") or "")),
            ("", escape(str(row.get("reason") or ""))),
        ]
        for row in over.failed
    ]
    table = _table(["log", "status", "tries>", "robot", "reason"], rows)
    text = f"<p>{'<br>'.join(counts)}</p>{table}"
    return _section("Logs without a map", text, "", over.logs - over.statuses[DONE], len(rows))


def _slowest(over: Overview) -> str:
    rows = [
        [
            ("log", _link(row, over.folder)),
            ("n", duration_text(number(row, "process_wall_s"))),
            ("n", duration_text(number(row, "duration_s")) if row["status"] == DONE else ""),
            ("n", f"{number(row, 'process_peak_memory_bytes') / 1e6:.0f} MB"),
            ("n", f"{number(row, 'log_bytes') / 1e6:.1f} MB"),
            ("", "" if row["status"] == DONE else escape(row["status"])),
        ]
        for row in over.slowest
        if number(row, "process_wall_s")
    ]
    if not rows:
        return ""
    names = ["log", "took>", "recorded>", "memory>", "log's size>", ""]
    return _section("Slowest", _table(names, rows), "", 0, 0)


def _sites(over: Overview) -> str:
    if not over.sites:
        return ""
    rows = [
        [
            ("log", escape(site)),
            ("n", f"{sum(counts.values()):,}"),
            ("", ", ".join(f"{count} {word}" for word, count in sorted(counts.items()))),
        ]
        for site, counts in sorted(over.sites.items())[:SITES_SHOWN]
    ]
    table = _table(["site", "logs>", "of them"], rows)
    return _section("Sites", table, "", len(over.sites), SITES_SHOWN)


# ---- parts


def _section(title: str, text: str, note: str, count: int, shown: int) -> str:
    more = f"{count - shown:,} more are in the table." if count > shown else ""
    soft = " ".join(part for part in (f"{note}." if note else "", more) if part)
    return f"<h2>{title}</h2>\n{text}" + (f"<p class='soft'>{soft}</p>" if soft else "")


def _table(names: Sequence[str], rows: Sequence[Sequence[tuple[str, str]]]) -> str:
    """Cells are a class and HTML; a column whose name ends in '>' is right-aligned."""
    titles = [name.rstrip(">") for name in names]
    head = "".join(
        f"<th{' class=n' if name.endswith('>') else ''}>{title}</th>"
        for name, title in zip(names, titles)
    )
    body = "\n".join(
        "<tr>"
        + "".join(
            f"<td class='{kind}' data-name='{title}'>{cell}</td>"
            for (kind, cell), title in zip(row, titles)
        )
        + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"


def _link(row: Row, folder: str) -> str:
    name = _short(row, folder)
    return f"<a href='{_address(row, 'report.html')}'>{name}</a>" if row.get("result") else name


def _address(row: Row, file: str) -> str:
    return quote(f"{row['result']}/{file}")


def _short(row: Row, folder: str) -> str:
    return escape(row["log"].removeprefix(folder))


def _logs(count: int) -> str:
    return f"{count:,} log{'' if count == 1 else 's'}"


def _share(count: int, of: int) -> str:
    return f"{count / of:.0%}" if of else "None"


def _share_of(robot: Robot) -> float:
    return robot.faulty_logs / max(robot.logs, 1)


def _by_count(item: tuple[str, int]) -> tuple[int, str]:
    return -item[1], item[0]
