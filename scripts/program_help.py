"""What the program's --help says, as data: commands, their options and the values these take."""
import dataclasses
import re
import subprocess

COLUMN = 30  # where the text of an option begins


@dataclasses.dataclass
class Option:
    """An option or a positional argument."""

    names: list  # as -o and --out; of a positional its one name
    value: str  # what it takes, as the help has it: FILE, check|trust|ignore; empty for a flag
    words: list  # the values, where only these are taken
    text: str
    is_required: bool

    @property
    def takes_value(self):
        return bool(self.value)


@dataclasses.dataclass
class Command:
    """The program itself, with an empty name, or one of its commands."""

    name: str
    summary: str
    usage: str
    positionals: list
    options: list
    commands: dict  # name to summary; of the program, and of a command that has its own
    footer: str
    inner: list = dataclasses.field(default_factory=list)  # Command, of a command's own

    def all_options(self):
        """Its own and those of its commands, each name once."""
        known = {}
        for one in [self, *self.inner]:
            for option in one.options:
                known.setdefault(tuple(option.names), option)
        return list(known.values())


def output_of(program, *arguments):
    return subprocess.run([program, *arguments], check=True, stdout=subprocess.PIPE).stdout.decode()


def read_help(program):
    """The program, then all of its commands."""
    whole = parse_help("", output_of(program, "--help"))
    if not whole.commands:
        raise SystemExit("`loopstone --help` lists no subcommands")
    return [whole] + [read_command(program, name) for name in whole.commands]


def read_command(program, *words):
    command = parse_help(" ".join(words), output_of(program, *words, "--help"))
    command.inner = [read_command(program, *words, name) for name in command.commands]
    return command


def parse_help(name, text):
    """Sections have titles at the margin; what follows two empty lines is the footer."""
    head, _, footer = text.partition("\n\n\n")
    lines = [line.rstrip() for line in head.splitlines()]
    sections, title = {}, None
    for line in lines[2:]:
        if re.fullmatch(r"[A-Z]\w*:", line):
            title = line[:-1]
            sections[title] = []
        elif title is not None and line:
            sections[title].append(line)
    known = {"Positionals", "Options", "Subcommands"}
    if not set(sections) <= known or not lines[1].startswith("Usage: "):
        raise SystemExit(f"the help of '{name}' has another shape: {sorted(sections)}")
    entries = {title: list(entries_of(lines)) for title, lines in sections.items()}
    return Command(
        name=name,
        summary=lines[0].rstrip("."),
        usage=lines[1].removeprefix("Usage: "),
        positionals=[option_of(*entry, True) for entry in entries.get("Positionals", [])],
        options=[option_of(*entry, False) for entry in entries.get("Options", [])],
        commands=dict(entries.get("Subcommands", [])),
        footer=footer.strip("\n"),
    )


def entries_of(lines):
    """Pairs of what stands left and its text, which may begin in the next line."""
    left, text = None, []
    for line in lines:
        if line.startswith(" " * COLUMN):
            text.append(line.strip())
            continue
        if left is not None:
            yield left, " ".join(text)
        # A range such as [0 - 1] may lie across the column.
        begin = line[:COLUMN]
        if len(line) > COLUMN and begin[-1] == " " and begin.count("[") == begin.count("]"):
            left, text = line[:COLUMN].strip(), [line[COLUMN:].strip()]
        else:
            left, text = line.strip(), []
    if left is not None:
        yield left, " ".join(text)


def option_of(left, text, is_positional):
    names, _, value = left.partition(" ")
    is_required = value.endswith("REQUIRED")
    value = value.removesuffix("REQUIRED").strip()
    # name|name:{name,name} and N:INT in [0 - 9]=0: what follows the name is the library's own.
    value, _, rest = value.partition(":")
    default = re.search(r"=(.*)$", rest)
    # ROLE=NAME and KEY<=VALUE are what it takes, N=1 ends in a default.
    shown = value if re.search(r"[A-Z]<?=[A-Z]", value) else value.partition("=")[0]
    shown = shown.removesuffix(" ...")
    words = shown.split("|") if re.fullmatch(r"[a-z][\w-]*(\|[a-z][\w-]*)+", shown) else []
    if default and "default" not in text:
        text += f" (default: {default.group(1)})"
    return Option(
        names.split(","), shown or (names if is_positional else ""), words, text, is_required
    )
