#!/usr/bin/env python3
"""Holds the parts of loopstone to their order: reads every include and every use of files, output
and process exit.

    check_layering.py ROOT        checks the tree at ROOT; prints one line per breach; exits 1 if
                                  there is any
    check_layering.py --self-test proves on small trees that each rule is enforced

The order of the parts is read from cmake/Parts.cmake, so that it is written down once.
"""

import pathlib
import re
import sys
import tempfile

# Parts that may open files. The program may too; nothing else does.
FILE_PARTS = {"formats", "report"}
# Parts that may talk to the system, which opens sockets and serial ports: no files.
SYSTEM_PARTS = FILE_PARTS | {"devices"}

# Third-party headers of the private sources, and the parts that may use each.
ANY_PART = None
THIRD_PARTY = {
    "Eigen/": ANY_PART,
    "unsupported/Eigen/": ANY_PART,
    "fmt/": ANY_PART,
    "hwy/": ANY_PART,
    "oneapi/tbb": ANY_PART,
    "tbb/": ANY_PART,
    "malloc.h": {"base"},
    "nlohmann/": FILE_PARTS | {"live", "apps"},
    "toml++/": FILE_PARTS | {"apps"},
    "yaml-cpp/": FILE_PARTS,
    "png.h": FILE_PARTS,
    "zip.h": FILE_PARTS,
    "zlib.h": FILE_PARTS | {"base"},
    "libdeflate.h": FILE_PARTS,
    "bzlib.h": FILE_PARTS,
    "zstd.h": {"formats"},
    "lz4frame.h": {"formats"},
    "lz4.h": {"formats"},
    "sqlite3.h": {"formats"},
    "jpeglib.h": {"formats"},
    "jerror.h": {"formats"},
    "boost/": {"live"},
    "CLI/": {"apps"},
    "spdlog/": {"apps"},
    "dds/": {"apps"},
    "nanobind/": {"python"},
    "Python.h": {"python"},
}
# What stands on top of the library, and uses its public headers only: programs and the Python
# package. Where their sources are, and what each includes of its own from.
ON_TOP = {"apps": "apps", "python": "python/bindings"}

# POSIX and C headers that reach files, the terminal or the process.
SYSTEM_HEADERS = (
    "sys/",
    "unistd.h",
    "fcntl.h",
    "dirent.h",
    "stdio.h",
    "signal.h",
    "termios.h",
    "spawn.h",
    "netdb.h",
    "netinet/",
    "asm/",
)
FILE_HEADERS = {"fstream", "cstdio", "filesystem"}
PRINT_HEADERS = {"iostream", "print", "syncstream"}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.MULTILINE)
COMMENT_OR_LITERAL = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"([^()\\\s]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'',
    re.DOTALL,
)
FILE_CALL = re.compile(r"\b(?:std::)?(?:fopen|freopen|tmpfile|[io]?fstream|filesystem::\w+)\b")
PRINT_CALL = re.compile(
    r"(?:\bstd::c(?:out|err|log)\b"
    r"|(?<![\w:])(?:std::|::)?(?:(?:printf|puts|putchar|perror|vprintf)\s*\("
    r"|fprintf\s*\(\s*std(?:out|err)\b)"
    r"|\bfmt::print(?:ln)?\s*\()"
)
# Of two numbers: that of three is arithmetic.
UNEQUAL_CALL = re.compile(
    r"\bstd::(hypot\((?:[^(),]|\([^()]*\))*,(?:[^(),]|\([^()]*\))*\)|erfc?\()"
)
EXIT_CALL = re.compile(r"(?<![\w:.>])(?:std::|::)?(?:exit|_Exit|quick_exit|abort|terminate)\s*\(")
SUFFIXES = {".cpp", ".hpp", ".h", ".cc"}


def parts_of(root):
    """The parts, lowest first."""
    text = (root / "cmake" / "Parts.cmake").read_text(encoding="utf-8")
    found = re.search(r"set\(LOOPSTONE_PARTS\s+([^)]*)\)", text)
    if not found:
        sys.exit("check_layering: no set(LOOPSTONE_PARTS ...) in cmake/Parts.cmake")
    return found.group(1).split()


def is_standard(name):
    return re.fullmatch(r"[a-z_0-9]+", name) is not None or name in {"stdint.h", "math.h"}


def code_of(text):
    """The text without comments and literals, so that words in them do not count."""
    return COMMENT_OR_LITERAL.sub(lambda match: "\n" * match.group(0).count("\n") or " ", text)


class Checker:
    def __init__(self, root):
        self.root = root
        self.parts = parts_of(root)
        self.breaches = []

    def breach(self, path, line, reason):
        self.breaches.append(f"{path.relative_to(self.root)}:{line}: {reason}")

    def rank(self, part):
        return self.parts.index(part)

    def check(self):
        for folder in ("include/loopstone", "src", *ON_TOP.values()):
            base = self.root / folder
            for path in sorted(base.rglob("*")) if base.is_dir() else []:
                if path.suffix in SUFFIXES and path.is_file():
                    self.check_file(path, path.relative_to(base).parts, folder)
        return self.breaches

    def check_file(self, path, names, folder):
        on_top = [part for part, sources in ON_TOP.items() if sources == folder]
        part = on_top[0] if on_top else names[0] if len(names) > 1 else ""
        public = folder.startswith("include")
        if part not in self.parts and not on_top and not (public and names == ("version.hpp",)):
            self.breach(path, 1, f"'{part}' is not a part: {' '.join(self.parts)}")
            return
        text = path.read_text(encoding="utf-8")
        for match in INCLUDE.finditer(text):
            line = text.count("\n", 0, match.start(2)) + 1
            self.check_include(path, line, part, public, match.group(1) == '"', match.group(2))
        if part != "apps":
            self.check_calls(path, part, code_of(text))

    def check_include(self, path, line, part, public, quoted, name):
        own = re.fullmatch(r"loopstone/(\w+)/.*|loopstone/version\.hpp", name)
        if own:
            if not quoted:
                self.breach(path, line, f'<{name}>: include it as "{name}"')
            if own.group(1):
                self.check_edge(path, line, part, own.group(1), name)
        elif quoted:
            self.check_private(path, line, part, public, name)
        elif name in FILE_HEADERS and part not in FILE_PARTS | {"apps"}:
            self.breach(
                path,
                line,
                f"<{name}>: only {' and '.join(sorted(FILE_PARTS))} and apps touch files",
            )
        elif name in PRINT_HEADERS and part != "apps":
            self.breach(path, line, f"<{name}>: the library never prints")
        elif public and not is_standard(name) and not name.startswith("Eigen/"):
            self.breach(
                path, line, f"<{name}>: a public header includes only std, Eigen and loopstone"
            )
        elif not is_standard(name):
            self.check_third_party(path, line, part, name)

    def check_third_party(self, path, line, part, name):
        for prefix, allowed in THIRD_PARTY.items():
            if name.startswith(prefix):
                if allowed is not ANY_PART and part not in allowed:
                    self.breach(path, line, f"<{name}>: only for {', '.join(sorted(allowed))}")
                return
        if name.startswith(SYSTEM_HEADERS):
            if part not in SYSTEM_PARTS | {"apps"}:
                self.breach(
                    path,
                    line,
                    f"<{name}>: only {', '.join(sorted(SYSTEM_PARTS))} and apps touch the system",
                )
            return
        self.breach(
            path,
            line,
            f"<{name}>: not a known library; add it to THIRD_PARTY with the parts that may use it",
        )

    def check_private(self, path, line, part, public, name):
        target = name.split("/")[0]
        if public:
            self.breach(path, line, f'"{name}": a public header cannot include a private one')
        elif part == "apps" and any((self.root / "apps").glob(f"*/{name}")):
            return
        elif part == "python" and (self.root / ON_TOP[part] / name).exists():
            return
        elif target not in self.parts:
            self.breach(path, line, f'"{name}": write the path from src/, as in "<part>/{name}"')
        elif not (self.root / "src" / name).exists():
            self.breach(path, line, f'"{name}": no such file in src/')
        elif part in ON_TOP:
            self.breach(path, line, f'"{name}": programs and package use public headers only')
        else:
            self.check_edge(path, line, part, target, name)

    def check_edge(self, path, line, part, target, name):
        if target not in self.parts:
            self.breach(path, line, f'"{name}": {target} is not a part')
        elif part == "":
            self.breach(path, line, f'"{name}": version.hpp stands below every part')
        elif part not in ON_TOP and self.rank(target) > self.rank(part):
            self.breach(path, line, f"back edge: {part} includes {target}, which stands above it")

    def check_calls(self, path, part, code):
        rules = [
            (PRINT_CALL, "the library never prints"),
            (EXIT_CALL, "the library never ends the process"),
            (UNEQUAL_CALL, "differs between processors; base has its own"),
        ]
        if part not in FILE_PARTS:
            rules.append(
                (FILE_CALL, f"only {' and '.join(sorted(FILE_PARTS))} and apps touch files")
            )
        for pattern, reason in rules:
            for match in pattern.finditer(code):
                self.breach(
                    path,
                    code.count("\n", 0, match.start()) + 1,
                    f"{match.group(0).strip()}: {reason}",
                )


# Each case: what it shows, a file, its text, and a word of the expected breach (None: it is clean).
SELF_TESTS = [
    ("lower part", "src/grid/a.cpp", '#include "loopstone/base/a.hpp"\n', None),
    ("own part", "src/grid/a.cpp", '#include "loopstone/grid/a.hpp"\n', None),
    (
        "back edge in src",
        "src/grid/a.cpp",
        '#include "loopstone/slam/a.hpp"\n',
        "back edge: grid includes slam",
    ),
    (
        "back edge in include",
        "include/loopstone/base/a.hpp",
        '#include "loopstone/grid/b.hpp"\n',
        "back edge",
    ),
    ("indented include", "src/base/a.cpp", '  #  include "loopstone/grid/b.hpp"\n', "back edge"),
    (
        "back edge to a private header",
        "src/base/a.cpp",
        '#include "grid/detail.hpp"\n',
        "back edge",
    ),
    ("private header of a lower part", "src/slam/a.cpp", '#include "grid/detail.hpp"\n', None),
    (
        "private header by stem",
        "src/grid/a.cpp",
        '#include "detail.hpp"\n',
        "write the path from src/",
    ),
    ("angle brackets", "src/grid/a.cpp", "#include <loopstone/base/a.hpp>\n", "include it as"),
    (
        "std and Eigen in public",
        "include/loopstone/grid/a.hpp",
        "#include <Eigen/Core>\n#include <vector>\n",
        None,
    ),
    (
        "foreign in public",
        "include/loopstone/grid/a.hpp",
        "#include <fmt/format.h>\n",
        "only std, Eigen",
    ),
    (
        "private in public",
        "include/loopstone/grid/a.hpp",
        '#include "grid/detail.hpp"\n',
        "private",
    ),
    ("unknown library", "src/grid/a.cpp", "#include <folly/any.h>\n", "not a known library"),
    ("library of other parts", "src/grid/a.cpp", "#include <png.h>\n", "only for formats, report"),
    ("fstream in the core", "src/slam/a.cpp", "#include <fstream>\n", "touch files"),
    (
        "filesystem call in the core",
        "src/slam/a.cpp",
        "void f() { std::filesystem::exists(p); }\n",
        "touch files",
    ),
    ("fopen in the core", "src/slam/a.cpp", "auto* f = std::fopen(p, m);\n", "touch files"),
    (
        "fstream in formats",
        "src/formats/a.cpp",
        "#include <fstream>\n#include <filesystem>\n",
        None,
    ),
    ("iostream in formats", "src/formats/a.cpp", "#include <iostream>\n", "never prints"),
    (
        "printf in the core",
        "src/slam/a.cpp",
        'void f() {\n  std::printf("x");\n}\n',
        "a.cpp:2: std::printf",
    ),
    ("snprintf is fine", "src/slam/a.cpp", "void f() { std::snprintf(b, n, s); }\n", None),
    ("cout in the core", "src/slam/a.cpp", "void f() { std::cout << 1; }\n", "never prints"),
    ("hypot", "src/slam/a.cpp", "double d = std::hypot(f(x), b.y);\n", "differs between"),
    ("hypot of three", "src/slam/a.cpp", "double d = std::hypot(f(x), b.y, c[1]);\n", None),
    ("erfc", "src/slam/a.cpp", "double d = std::erfc(x);\n", "differs between"),
    ("exit in the core", "src/slam/a.cpp", "void f() { std::exit(1); }\n", "never ends"),
    (
        "words in comments",
        "src/slam/a.cpp",
        '// std::exit(1) printf("x")\nauto s = "std::cout << exit(1)";\n',
        None,
    ),
    ("termios in the core", "src/slam/a.cpp", "#include <termios.h>\n", "touch the system"),
    ("socket in devices", "src/devices/a.cpp", "#include <sys/socket.h>\n", None),
    ("fstream in devices", "src/devices/a.cpp", "#include <fstream>\n", "touch files"),
    ("unknown part", "src/magic/a.cpp", "\n", "not a part"),
    ("no part", "src/a.cpp", "\n", "not a part"),
    (
        "apps print",
        "apps/loopstone/a.cpp",
        "#include <iostream>\nvoid f() { std::exit(1); }\n",
        None,
    ),
    (
        "apps use private",
        "apps/loopstone/a.cpp",
        '#include "grid/detail.hpp"\n',
        "public headers only",
    ),
    (
        "the package uses private",
        "python/bindings/a.cpp",
        '#include "grid/detail.hpp"\n',
        "public headers only",
    ),
    ("the package prints", "python/bindings/a.cpp", "#include <iostream>\n", "never prints"),
    (
        "the package binds",
        "python/bindings/a.cpp",
        '#include <nanobind/nanobind.h>\n\n#include "loopstone/slam/a.hpp"\n',
        None,
    ),
    ("nanobind in the core", "src/slam/a.cpp", "#include <nanobind/nanobind.h>\n", "only for"),
]


def run_case(name, text):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        files = {
            "cmake/Parts.cmake": (
                "set(LOOPSTONE_PARTS\n    base\n    devices\n    grid\n"
                "    slam\n    formats\n    report)\n"
            ),
            "src/grid/detail.hpp": "",
            name: text,
        }
        for path, content in files.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(content, encoding="utf-8")
        return Checker(root).check()


def self_test():
    failed = 0
    for title, name, text, expected in SELF_TESTS:
        breaches = run_case(name, text)
        good = not breaches if expected is None else len(breaches) >= 1 and expected in breaches[0]
        if not good:
            failed += 1
            print(f"FAILED {title}: expected {expected!r}, got {breaches}")
    print(f"{len(SELF_TESTS) - failed} of {len(SELF_TESTS)} cases as expected")
    return 1 if failed else 0


def main():
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    if sys.argv[1] == "--self-test":
        return self_test()
    breaches = Checker(pathlib.Path(sys.argv[1]).resolve()).check()
    for breach in breaches:
        print(breach)
    print(
        f"layering: {len(breaches)} breaches"
        if breaches
        else "layering: every include points up the list of parts"
    )
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
