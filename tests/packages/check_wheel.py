#!/usr/bin/env python3
"""Holds a wheel of the Python package to what docs/python.md says of it: it brings no library as a
file of its own, asks the machine for the C and C++ library alone, shows no symbol of the libraries
in it, has their licences, and is tagged for other Linux systems than the one that it was built on.

  tests/packages/check_wheel.py WHEEL
  tests/packages/check_wheel.py --self-test    planted faults are found
"""
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

# Every Linux that a manylinux tag promises has them (PEP 600).
OF_THE_MACHINE = re.compile(
    r"(libc|libm|libgcc_s|libstdc\+\+|libpthread|libdl|librt|ld-linux-[\w-]+)\.so\.\d+"
)
# By the package of Debian; those of the compiler are not.
LICENCES = {
    "libbz2", "libdeflate", "libfmt", "libhwy", "libjpeg62-turbo", "liblz4", "libpng", "libspdlog",
    "libsqlite3", "libtbb", "libtomlplusplus", "libyaml-cpp", "libzip", "libzstd", "zlib1g",
}  # fmt: skip


def readelf(option, path):
    done = subprocess.run(
        ["readelf", "--wide", option, path], capture_output=True, text=True, check=True
    )
    return done.stdout


def faults_of_binary(name, path):
    for library in re.findall(r"\(NEEDED\).*\[(.+)\]", readelf("--dynamic", path)):
        if not OF_THE_MACHINE.fullmatch(library):
            yield f"{name} asks for {library}"
    if not name.endswith(".so"):
        return
    # Num: Value Size Type Bind Vis Ndx Name; what is undefined has UND for Ndx.
    rows = [line.split() for line in readelf("--dyn-syms", path).splitlines()]
    shown = [row[7] for row in rows if len(row) >= 8 and row[4] == "GLOBAL" and row[6].isdigit()]
    if shown != ["PyInit__core"]:
        yield f"{name} shows {len(shown)} symbols: {', '.join(sorted(shown)[:3])} ..."


def faults(wheel):
    """What is wrong with the wheel, a line each."""
    if not re.search(r"-manylinux_2_\d+_\w+\.whl$", wheel.name):
        yield f"{wheel.name}: the tag names no manylinux"
    with zipfile.ZipFile(wheel) as files, tempfile.TemporaryDirectory() as folder:
        names = files.namelist()
        binaries = [name for name in names if files.open(name).read(4) == b"\x7fELF"]
        expected = {"loopstone/bin/loopstone"}
        expected |= {n for n in names if re.fullmatch(r"loopstone/_core\.[\w-]*\.?so", n)}
        if len(expected) != 2:
            yield "there is not one extension module loopstone/_core"
        for name in sorted(set(binaries) ^ expected):
            yield f"{name}: " + ("a library of its own" if name in binaries else "is missing")
        for name in sorted(set(binaries) & expected):
            yield from faults_of_binary(name, files.extract(name, folder))
        licences = {name.rsplit("/", 1)[1] for name in names if "loopstone/licenses/" in name}
        for name in sorted(LICENCES - licences):
            yield f"loopstone/licenses/{name}: is missing"


def compiled(folder, name, text, *options):
    path = folder / name
    subprocess.run(
        ["cc", "-o", path, "-x", "c", "-", "-x", "none", *options],
        input=text, text=True, check=True,
    )  # fmt: skip
    return path


def self_test():
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        other = compiled(folder, "libother.so", "int other(void) { return 1; }", "-shared", "-fPIC")
        hidden = ["-shared", "-fPIC", "-fvisibility=hidden"]
        shown = '__attribute__((visibility("default"))) int PyInit__core(void) {{ return {}; }}'
        good = compiled(folder, "good.so", shown.format(1), *hidden)
        asks = compiled(
            folder, "asks.so", "int other(void);" + shown.format("other()"), *hidden, other
        )
        shows = compiled(folder, "shows.so", shown.format(1) + "int zip_open;", "-shared", "-fPIC")
        program = compiled(folder, "program", "int main(void) { return 0; }")

        def told(module=good, tag="manylinux_2_36_x86_64", more=(), licences=LICENCES):
            wheel = folder / f"loopstone-1.0-cp311-cp311-{tag}.whl"
            with zipfile.ZipFile(wheel, "w") as files:
                files.write(module, "loopstone/_core.cpython-311-x86_64-linux-gnu.so")
                files.write(program, "loopstone/bin/loopstone")
                for name in more:
                    files.write(other, name)
                for name in licences:
                    files.writestr(f"loopstone/licenses/{name}", "text")
            return list(faults(wheel))

        module = "loopstone/_core.cpython-311-x86_64-linux-gnu.so"
        assert told() == [], told()
        assert told(asks) == [f"{module} asks for {other}"], told(asks)
        assert told(shows) == [f"{module} shows 2 symbols: PyInit__core, zip_open ..."], told(shows)
        bundled = told(more=["loopstone.libs/libother.so"])
        assert bundled == ["loopstone.libs/libother.so: a library of its own"], bundled
        assert len(told(tag="linux_x86_64")) == 1
        assert told(licences=LICENCES - {"libzip"}) == ["loopstone/licenses/libzip: is missing"]


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    wheel = pathlib.Path(sys.argv[1])
    found = list(faults(wheel))
    for line in found:
        print(f"{wheel}: {line}", file=sys.stderr)
    if not found:
        print(f"{wheel.name}: {wheel.stat().st_size} bytes, asks for the C and C++ library alone")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
