"""What the scripts share that measure in sections: flags, the run of the sections, targets met or
not."""
import argparse
import json
import pathlib
import subprocess
import time

from program import Failed, say
from provenance import circumstances
from recorded import data_folder


def plain_parser(doc, root):
    """Programs, data, working folder and --quick."""
    parser = argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=pathlib.Path, default=root / "build/release/bin")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(root))
    parser.add_argument("--work", type=pathlib.Path, default=root / "build/bench")
    parser.add_argument("--quick", action="store_true")
    return parser


def section_parser(doc, sections, root):
    """The same, --only and --resume."""
    parser = plain_parser(doc, root)
    parser.add_argument("--only", nargs="*", choices=sections, default=sections)
    parser.add_argument("--resume", action="store_true", help="leave out what has been measured")
    return parser


def measure_sections(
    script, arguments, loopstone, measure, extra=None, leave_out=lambda name, sections: False
):
    """Measures the sections asked for, each kept in build/bench/SCRIPT.json as soon as it is done.

    measure(name) returns a section's figures, or nothing; extra is kept beside them.
    Returns all sections that are kept, and the names of those that failed."""
    kept = arguments.work / f"{script}{'-quick' if arguments.quick else ''}.json"
    sections = json.loads(kept.read_text()) if kept.exists() else {}
    failed = []
    for name in arguments.only:
        if leave_out(name, sections):
            continue
        say(f"{name}:")
        started = time.monotonic()
        when = circumstances(loopstone.version())
        try:
            figures = measure(name)
        except (Failed, OSError, subprocess.SubprocessError, ValueError, KeyError) as failure:
            say(f"  FAILED: {failure!r}")
            failed.append(name)
            continue
        say(f"  took {time.monotonic() - started:.0f} s")
        if figures:
            sections[name] = {**when, **(extra or {}), "figures": figures}
            kept.write_text(json.dumps(sections, indent=1))
    return sections, failed


def verdicts(targets):
    """A line for each (name, target, measured, met)."""
    return "\n".join(
        f"{'met    ' if met else 'NOT MET'}  {measured:>14}  {target:<18} {name}"
        for name, target, measured, met in targets
    )
