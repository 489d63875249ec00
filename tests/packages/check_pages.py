#!/usr/bin/env python3
"""Manual pages and completions, held against the program's --help.

  tests/packages/check_pages.py PROGRAM
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from program_help import parse_help, read_help  # noqa: E402

problems = []


def expect(is_so, what):
    if not is_so:
        problems.append(what)


def check_parser():
    text = """Do it
Usage: loopstone do [OPTIONS] IN

Positionals:
  IN TEXT REQUIRED            what to do

Options:
  -o,--out TEXT REQUIRED      where to
  --speed X:FLOAT in [0 - 1e+06]=1
                              how fast
  --order first|last=first    which comes
                              before
  --topic ROLE=NAME ...       who plays it
  --quiet                     say nothing


The end.
"""
    command = parse_help("do", text)
    options = {one.names[-1]: one for one in command.options}
    expect(command.summary == "Do it" and command.footer == "The end.", "summary and footer")
    expect(command.positionals[0].names == ["IN"], "the positional's name")
    expect(options["--out"].is_required and options["--out"].names == ["-o", "--out"], "--out")
    expect(options["--speed"].value == "X" and "default: 1" in options["--speed"].text, "--speed")
    expect(options["--order"].words == ["first", "last"], "the words of --order")
    expect(options["--order"].text.startswith("which comes before"), "a text of two lines")
    expect(options["--topic"].value == "ROLE=NAME", "what --topic takes")
    expect(not options["--quiet"].takes_value, "--quiet is a flag")


def plain(page):
    """A manual page without its formatting."""
    return (
        page.replace("\\fB", "")
        .replace("\\fI", "")
        .replace("\\fR", "")
        .replace("\\-", "-")
        .replace("\\e", "\\")
    )


def check_contents(commands, folder):
    shells = {
        one: (folder / one).read_text()
        for one in ("bash/loopstone", "zsh/_loopstone", "fish/loopstone.fish")
    }
    for command in commands:
        name = "loopstone" + (f"-{command.name}" if command.name else "")
        page = plain((folder / f"man1/{name}.1").read_text())
        for option in command.all_options():
            for one in option.names:
                expect(
                    re.search(rf"^(.*, )?{re.escape(one)}\b", page, re.M), f"{name}.1 lacks {one}"
                )
                if command.name:
                    expect(one in shells["bash/loopstone"], f"bash lacks {command.name} {one}")
                    expect(
                        f"*{one}[" in shells["zsh/_loopstone"], f"zsh lacks {command.name} {one}"
                    )
                    flag = f"-l {one[2:]}" if one.startswith("--") else f"-s {one[1:]}"
                    line = rf"from {command.name}'.*{flag}\b"
                    expect(
                        re.search(line, shells["fish/loopstone.fish"]),
                        f"fish lacks {command.name} {one}",
                    )
        expect(".SH NAME" in page and ".SH OPTIONS" in page, f"{name}.1 lacks a section")
    lines = [line for line in "".join(shells.values()).splitlines() if line.startswith(("<", ">"))]
    expect(not lines, "completions hold what is none")


def completed(folder, *words):
    """What bash offers for the last word."""
    script = """source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _loopstone
    printf '%s\\n' "${COMPREPLY[@]}" """
    run = ["bash", "-c", script, "bash", folder / "bash/loopstone", "loopstone", *words]
    return subprocess.run(run, check=True, stdout=subprocess.PIPE, text=True).stdout.split()


def check_bash(commands, folder):
    expect(completed(folder, "") == list(commands[0].commands), "bash offers all commands")
    expect(completed(folder, "loc") == ["localize"], "bash ends a command's name")
    expect(
        completed(folder, "map", "--odometry", "") == ["check", "trust", "ignore"],
        "bash offers values",
    )
    expect(completed(folder, "map", "--odometry", "t") == ["trust"], "bash ends a value")
    expect("--view" in completed(folder, "map", "--vi"), "bash ends a flag")
    expect("--view" not in completed(folder, "evaluate", "--"), "bash keeps to the command's flags")
    expect(
        "loop.min_score=" in completed(folder, "map", "--set", "loop."), "bash knows option keys"
    )
    expect(completed(folder, "map", "lo") == [], "bash leaves files to the shell")
    expect(completed(folder, "site", "ch") == ["changes", "check"], "bash offers inner commands")
    expect(completed(folder, "site", "map", "o") == [], "bash leaves a site to the shell")


def check_by_others(folder):
    """What judges these files by itself, where it is there."""
    judges = {
        "bash": (["-n"], ["bash/loopstone"]),
        "zsh": (["-n"], ["zsh/_loopstone"]),
        "fish": (["-n"], ["fish/loopstone.fish"]),
        "groff": (
            ["-man", "-ww", "-Tutf8", "-z"],
            [f"man1/{one.name}" for one in (folder / "man1").iterdir()],
        ),
    }
    for judge, (flags, files) in judges.items():
        if shutil.which(judge) is None:
            print(f"{judge} is not there and was not asked")
            continue
        for file in files:
            said = subprocess.run([judge, *flags, folder / file], capture_output=True, text=True)
            expect(said.returncode == 0 and not said.stderr, f"{judge} of {file}: {said.stderr}")


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    check_parser()
    with tempfile.TemporaryDirectory() as name:
        folder, again = pathlib.Path(name) / "pages", pathlib.Path(name) / "again"
        for one in (folder, again):
            subprocess.run([ROOT / "scripts/write_pages.py", program, one], check=True)
        commands = read_help(program)
        check_contents(commands, folder)
        check_bash(commands, folder)
        check_by_others(folder)
        for path in folder.rglob("*.*"):
            if path.is_file():
                other = again / path.relative_to(folder)
                expect(
                    path.read_bytes() == other.read_bytes(), f"{path.name} differs the second time"
                )
    for problem in problems:
        print(problem)
    print(f"{len(commands)} manual pages, {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
