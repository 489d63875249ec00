#!/usr/bin/env python3
"""Holds functions to 60 lines, so that each can be seen at once.

    check_function_length.py ROOT        include/, src/, apps/ and python/ at ROOT; prints one line
                                         per breach; exits 1 if there is any
    check_function_length.py --self-test

What counts are the lines between the braces of a body, those of lambdas in it too. A function that
is better left whole says why, in the comment directly above it:

    // Over 60 lines: one branch for each kind of record, and nothing else.

It reads code as clang-format lays it out: a space before the brace of a body, none before that of
an initialiser.
"""

import pathlib
import re
import sys

LIMIT = 60
EXCUSE = re.compile(r"\s*///? Over 60 lines: \S")
FOLDERS = ("include", "src", "apps", "python")
SUFFIXES = {".cpp", ".hpp"}

# Numbers come first, for their separators: 1'000 is no character.
NOT_CODE = re.compile(
    r"""\b\d(?:'?[\w.])*"""
    r"""|//[^\n]*|/\*.*?\*/"""
    r"""|R"([^()\\\s]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])+'"""
    r"""|^[ \t]*\#(?:\\\n|[^\n])*""",
    re.DOTALL | re.MULTILINE,
)
INNERMOST = re.compile(r"\([^()]*\)|<[^<>()]*>")
SCOPE = re.compile(r"\b(?:namespace|class|struct|union|enum)\b|\bextern\s*$")
ASSIGNMENT = re.compile(r"(?<![=!<>])=(?!=)")
ACCESS = re.compile(r"\s*(?:public|private|protected)\s*:(?!:)")


def code_of(text):
    """The text with blanks in place of comments, literals, numbers and directives."""
    return NOT_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match.group(0)), text)


def kind_of_brace(head, spaced):
    """What a brace opens outside of functions: a scope, the body of a function, or values."""
    has_parameters = ")" in head
    shorter = INNERMOST.sub("", head)
    while shorter != head:
        head, shorter = shorter, INNERMOST.sub("", shorter)
    if ASSIGNMENT.search(re.sub(r"\boperator\W+", "", head)):
        return "values"
    if SCOPE.search(head):
        return "scope"
    return "body" if has_parameters and spaced else "values"


def functions_of(text):
    """(first line, lines of the body) of each function, lines from 0; ValueError: odd braces."""
    code = code_of(text)
    kinds = []  # of the braces that are open
    parentheses = 0  # that are open in the head of a declaration
    start = 0  # of that head
    opened = 0
    for match in re.finditer(r"[{}();]", code):
        token, at = match.group(0), match.start()
        outside = all(kind == "scope" for kind in kinds)
        if token == "{":
            kind = "values"
            if outside and parentheses == 0:
                kind = kind_of_brace(code[start:at], code[at - 1].isspace())
            kinds.append(kind)
            if kind == "scope":
                start = at + 1
            elif kind == "body":
                opened = at
        elif token == "}":
            if not kinds:
                raise ValueError(f"line {code.count(chr(10), 0, at) + 1} closes what is not open")
            kind = kinds.pop()
            if kind == "body":
                while access := ACCESS.match(code, start):
                    start = access.end()
                first = start + len(code[start:opened]) - len(code[start:opened].lstrip())
                yield code.count("\n", 0, first), code.count("\n", opened, at) - 1
            if kind != "values":
                start = at + 1
        elif outside:
            parentheses += {"(": 1, ")": -1, ";": 0}[token]
            if token == ";" and parentheses == 0:
                start = at + 1
    if kinds or parentheses != 0:
        raise ValueError("braces are left open")


def breaches_of(text):
    """(line, what is wrong) of each breach in a source; lines from 1."""
    lines = text.split("\n")
    excuses = {number for number, line in enumerate(lines) if EXCUSE.match(line)}
    breaches = []
    try:
        for first, length in functions_of(text):
            above = first - 1
            while above >= 0 and lines[above].lstrip().startswith("//") and above not in excuses:
                above -= 1
            excused = above in excuses and length > LIMIT
            if excused:
                excuses.discard(above)
            elif length > LIMIT:
                breaches.append((first + 1, f"a function of {length} lines, more than {LIMIT}"))
    except ValueError as error:
        breaches.append((1, f"can't be read: {error}"))
    breaches += [(line + 1, "excuses no function over 60 lines") for line in excuses]
    return sorted(breaches)


def check(root):
    sources = [path for folder in FOLDERS for path in sorted((root / folder).rglob("*"))]
    sources = [path for path in sources if path.suffix in SUFFIXES]
    if not sources:
        sys.exit(f"{root}: no sources")
    functions = found = 0
    for path in sources:
        text = path.read_text(encoding="utf-8")
        for line, reason in breaches_of(text):
            print(f"{path.relative_to(root)}:{line}: {reason}")
            found += 1
        if found == 0:
            functions += sum(1 for _ in functions_of(text))
    if found == 0:
        print(f"function length: {functions} functions of at most {LIMIT} lines")
    return 1 if found else 0


def body(lines):
    return "  step();\n" * lines


# (what, source, the lines that breach)
CASES = [
    ("sixty lines", "void f() {\n" + body(60) + "}\n", []),
    ("one more", "int a;\n\nvoid f() {\n" + body(61) + "}\n", [3]),
    (
        "in namespaces",
        "namespace a::b {\nnamespace {\nvoid f() {\n" + body(61) + "}\n}  // namespace\n}\n",
        [3],
    ),
    ("excused", "// Over 60 lines: a list.\nvoid f() {\n" + body(61) + "}\n", []),
    (
        "excused above more words",
        "int a;\n// What it does.\n// Over 60 lines: a list\n// of steps.\nvoid f() {\n"
        + body(61)
        + "}\n",
        [],
    ),
    ("no reason", "// Over 60 lines:\nvoid f() {\n" + body(61) + "}\n", [2]),
    ("an excuse apart", "// Over 60 lines: a.\n\nvoid f() {\n" + body(61) + "}\n", [1, 3]),
    ("an excuse too many", "// Over 60 lines: once.\nvoid f() {\n" + body(9) + "}\n", [1]),
    (
        "of a class",
        "class A : public B<int(int)> {\n public:\n  int f(C c = {}) const {\n"
        + body(61)
        + "  }\n};\n",
        [3],
    ),
    (
        "a long class of short functions",
        "struct A {\n" + "  int f() const { return 1; }\n" * 99 + "};\n",
        [],
    ),
    (
        "initialisers of a constructor",
        "A::A(int b)\n    : b_{b},\n      c_(b) {\n" + body(61) + "}\n",
        [1],
    ),
    ("a table", "const std::map<int, A> kTable = {\n" + "    {1, f(2)},\n" * 99 + "};\n", []),
    ("values of a type", "constexpr std::array<A, 99> kAll{\n" + "    A(1),\n" * 99 + "};\n", []),
    (
        "operators, defaults of templates",
        "template <typename T = int>\nA& A::operator=(const A& a) {\n" + body(61) + "}\n"
        "bool operator<=(A a, A b) {\n" + body(61) + "}\n",
        [1, 65],
    ),
    (
        "braces in words",
        "void f() {\n  g('{', \"{\", R\"({)\", 1'0, '}');  // {\n}\nvoid h() {\n"
        + body(61)
        + "}\n",
        [4],
    ),
    ("a lambda", "void f() {\n  const auto g = [](int a) {\n" + body(61) + "  };\n}\n", [1]),
    ("what follows it", "void f() {\n" + body(61) + "}\n\nint g() { return 1; }\n", [1]),
    ("a brace left open", "void f() {\n  if (a) {\n}\n", [1]),
    ("a brace too many", "void f() {\n}\n}\n", [1]),
]


def self_test():
    wrong = 0
    for what, text, expected in CASES:
        lines = [line for line, _ in breaches_of(text)]
        if lines != expected:
            print(f"self-test: {what}: lines {lines}, expected {expected}")
            wrong += 1
    print(f"{len(CASES) - wrong} of {len(CASES)} cases as expected")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(self_test() if sys.argv[1] == "--self-test" else check(pathlib.Path(sys.argv[1])))
