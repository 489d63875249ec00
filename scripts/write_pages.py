#!/usr/bin/env python3
"""Makes of the program's --help its manual pages and what shells complete.

  scripts/write_pages.py PROGRAM FOLDER

Leaves in FOLDER man1/loopstone.1 and a page for each command, bash/loopstone, zsh/_loopstone and
fish/loopstone.fish. The same program gives the same bytes.
"""
import argparse
import pathlib
import re
import sys

from program_help import output_of, read_help

EXIT_STATUS = [
    ("0", "done"),
    ("1", "bad data"),
    ("2", "bad usage or options"),
    ("3", "a --require bound was missed"),
    ("130", "interrupted"),
]
FOLDERS = re.compile(r"\bfolder\b")


# Manual pages: man(7) of groff and mandoc.


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    text = re.sub(r"`([^`]*)`", r"\\fB\1\\fR", text)
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def option_roff(option):
    names = ", ".join(f"\\fB{roff(name)}\\fR" for name in option.names)
    value = f" \\fI{roff(option.value)}\\fR" if option.takes_value else ""
    return f".TP\n{names}{value}\n{roff(option.text)}\n"


def arguments_roff(command):
    return "".join(
        f".TP\n\\fI{roff(one.names[0])}\\fR\n{roff(one.text)}\n" for one in command.positionals
    )


def inner_roff(command):
    """A command of a command: on the page of that."""
    parts = [f".SS {roff(command.name)}\n{roff(command.summary)}\n"]
    parts.append(f".PP\n.nf\n{roff(command.usage)}\n.fi\n" + arguments_roff(command))
    parts += map(option_roff, command.options)
    if command.footer:
        parts.append(f".PP\n.nf\n{roff(command.footer)}\n.fi\n")
    return "".join(parts)


def man_page(command, program_page, version):
    name = "loopstone" + (f"-{command.name}" if command.name else "")
    parts = [f'.TH {name.upper()} 1 "" "loopstone {version}" "Loopstone"\n']
    parts.append(f".SH NAME\n{roff(name)} \\- {roff(command.summary)}\n")
    parts.append(f".SH SYNOPSIS\n.nf\n{roff(command.usage)}\n.fi\n")
    if command.positionals:
        parts.append(".SH ARGUMENTS\n" + arguments_roff(command))
    parts.append(".SH OPTIONS\n" + "".join(map(option_roff, command.options)))
    if command.inner:
        parts.append(".SH COMMANDS\n" + "".join(map(inner_roff, command.inner)))
    elif command.commands:
        parts.append(".SH COMMANDS\n")
        for one, summary in command.commands.items():
            parts.append(f".TP\n.BR loopstone\\-{roff(one)} (1)\n{roff(summary)}\n")
    if command.footer:
        parts.append(f".SH NOTES\n.nf\n{roff(command.footer)}\n.fi\n")
    parts.append(".SH EXIT STATUS\n")
    parts += [f".TP\n.B {code}\n{roff(what)}\n" for code, what in EXIT_STATUS]
    if command.name:
        others = ["loopstone"]
    else:
        others = [f"loopstone-{one}" for one in program_page.commands]
    parts.append(".SH SEE ALSO\n" + ",\n".join(f".BR {roff(one)} (1)" for one in others) + "\n")
    return "".join(parts)


# Completion: what a word may be, by what stands before it.


def option_keys(program, command):
    """For --set, of the commands that `loopstone config` knows."""
    keys, group = [], ""
    for line in output_of(program, "config", command).splitlines():
        if line.startswith("["):
            group = line.strip("[]") + "."
        elif "=" in line and not line.startswith("#"):
            keys.append(group + line.partition("=")[0].strip())
    return keys


def bash_values(command, keys):
    """What stands after an option, as cases of COMMAND OPTION."""
    lines = []
    for option in command.options:
        for name in option.names:
            where = f"    '{command.name} {name}')"
            if option.words:
                lines.append(f"{where} words='{' '.join(option.words)}' ;;")
            elif name == "--set" and command.name in keys:
                words = " ".join(keys[command.name])
                lines += [
                    where,
                    f"      COMPREPLY=($(compgen -S = -W '{words}' -- \"$current\"))",
                    "      compopt -o nospace 2>/dev/null",
                    "      return ;;",
                ]
    return lines


def bash_completion(commands, keys):
    whole, *rest = commands
    lines = [
        "# bash completion for loopstone",
        "_loopstone() {",
        "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}",
        "  local command=${COMP_WORDS[1]} words=",
        "  COMPREPLY=()",
        "  if ((COMP_CWORD == 1)); then",
        f"    words='{' '.join(whole.commands)}'",
        "    [[ $current == -* ]] && words='--help --version'",
        '    COMPREPLY=($(compgen -W "$words" -- "$current"))',
        "    return",
        "  fi",
        '  case "$command $before" in',
    ]
    for command in rest:
        lines += bash_values(command, keys)
    lines += ["  esac", "  if [[ -z $words && $current == -* ]]; then", "    case $command in"]
    for command in rest:
        flags = [name for option in command.all_options() for name in option.names]
        lines.append(f"      {command.name}) words='{' '.join(flags)}' ;;")
    lines += ["    esac", "  fi"]
    for command in rest:
        if command.inner:
            lines.append(f"  [[ -z $words && $command == {command.name} && $COMP_CWORD -eq 2 ]] &&")
            lines.append(f"    words='{' '.join(command.commands)}'")
    for command in rest:
        for one in command.positionals:
            if one.words:
                lines.append(f"  [[ -z $words && $command == {command.name} ]] &&")
                lines.append(f"    words='{' '.join(one.words)}'")
    lines += [
        "  # With no words of ours, files: what -o default does.",
        '  [[ -n $words ]] && COMPREPLY=($(compgen -W "$words" -- "$current"))',
        "}",
        "complete -o bashdefault -o default -F _loopstone loopstone",
    ]
    return "\n".join(lines) + "\n"


def zsh_quoted(text):
    return re.sub(r"([\[\]:\\])", r"\\\1", text).replace("'", "'\\''")


def zsh_value(option):
    if not option.takes_value:
        return ""
    label = zsh_quoted(option.value)
    if option.words:
        return f":{label}:({' '.join(option.words)})"
    return f":{label}:" + ("_files -/" if FOLDERS.match(option.text) else "_files")


def zsh_completion(commands):
    whole, *rest = commands
    lines = ["#compdef loopstone", "_loopstone() {", "  local -a commands", "  commands=("]
    lines += [f"    '{name}:{zsh_quoted(text)}'" for name, text in whole.commands.items()]
    lines += [
        "  )",
        "  if ((CURRENT == 2)); then",
        "    _describe command commands",
        "    return",
        "  fi",
        "  local command=${words[2]}",
        "  shift words",
        "  ((CURRENT--))",
        "  case $command in",
    ]
    for command in rest:
        lines.append(f"    {command.name})")
        lines.append("      _arguments \\")
        if command.inner:
            lines.append(f"        '1:command:({' '.join(command.commands)})' '*:file:_files' \\")
        for option in command.all_options():
            for name in option.names:
                lines.append(f"        '*{name}[{zsh_quoted(option.text)}]{zsh_value(option)}' \\")
        for one in command.positionals:
            files = f":{zsh_quoted(one.names[0])}:_files"
            lines.append(f"        '{zsh_value(one) if one.words else files}' \\")
        lines.append("        && return 0")
        lines.append("      ;;")
    lines += ["  esac", "}", '_loopstone "$@"']
    return "\n".join(lines) + "\n"


def fish_quoted(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


def fish_completion(commands):
    whole, *rest = commands
    lines = ["# fish completion for loopstone", "complete -c loopstone -n __fish_use_subcommand -f"]
    for name, text in whole.commands.items():
        lines.append(
            f"complete -c loopstone -n __fish_use_subcommand -a {name} -d {fish_quoted(text)}"
        )
    for command in rest:
        where = f"complete -c loopstone -n '__fish_seen_subcommand_from {command.name}'"
        for name, text in command.commands.items():
            lines.append(f"{where} -a {name} -d {fish_quoted(text)}")
        for option in command.all_options():
            parts = [where]
            for name in option.names:
                parts.append(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}")
            if option.takes_value:
                parts.append(
                    f"-x -a {fish_quoted(' '.join(option.words))}" if option.words else "-r"
                )
            parts.append(f"-d {fish_quoted(option.text)}")
            lines.append(" ".join(parts))
        for one in command.positionals:
            if one.words:
                lines.append(f"{where} -f -a {fish_quoted(' '.join(one.words))}")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    commands = read_help(program)
    version = output_of(program, "--version").split()[-1]
    known = next(one for one in commands if one.name == "config").positionals[0].words
    keys = {name: option_keys(program, name) for name in known if name in commands[0].commands}
    files = {
        "bash/loopstone": bash_completion(commands, keys),
        "zsh/_loopstone": zsh_completion(commands),
        "fish/loopstone.fish": fish_completion(commands),
    }
    for command in commands:
        name = "loopstone" + (f"-{command.name}" if command.name else "")
        files[f"man1/{name}.1"] = man_page(command, commands[0], version)
    for name, text in files.items():
        path = arguments.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
