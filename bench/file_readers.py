#!/usr/bin/env python3
"""Compares our readers of pictures, clouds and arrays with libraries of the field, on speed,
memory, damaged files, variants of the formats and size, and writes the tables of
docs/file_readers.md.

The libraries are unpacked into build/bench/peers/file_readers by
bench/peers/install_file_readers.sh (40 MB to download, nothing is installed); those that can't be
had are left out. Recorded files are looked for in $LOOPSTONE_DATA, else in ../shared/data. What was
measured is kept in build/bench/file_readers.json, the damaged files in build/bench/file_readers.

  bench/file_readers.py            measures and writes (some minutes)
  bench/file_readers.py --quick    fewer runs and files; to look at, writes nothing into docs/
  bench/file_readers.py --again    no measurement: writes the tables from file_readers.json again
"""
import collections
import json
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from file_reader_files import make_damaged, make_files  # noqa: E402
from program import MEGABYTE, Loopstone, median, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from sections import plain_parser  # noqa: E402

PAGE = ROOT / "docs/file_readers.md"
OURS = "Loopstone"
MEMORY_MB, CPU_S = 512, 5
# Format, its ending, our sources of it.
FORMATS = {
    "tif": ("TIFF", ["tiff*"]),
    "mat": ("MAT", ["mat_file.*"]),
    "pcd": ("PCD", ["pcd*", "lzf.*", "cloud_columns.*"]),
    "ply": ("PLY", ["ply*", "cloud_columns.*"]),
    "npy": ("NPY", ["npy.*", "npy_head.*"]),
    "pnm": ("PNM", ["image_pnm.cpp"]),
}
# Its program, and the package that a program of ours would need while it runs.
LIBRARIES = {
    "tiff": ("libtiff", "libtiff6"),
    "mat": ("matio", "libmatio11"),
    "pcl": ("PCL", "libpcl-io1.13"),
    "miniply": ("miniply", None),
    "xtensor": ("xtensor", None),
    "netpbm": ("libnetpbm", "libnetpbm11"),
}
# Every C++ program has these.
OF_THE_SYSTEM = {"libc6", "libgcc-s1", "gcc-12-base", "libstdc++6", "libcrypt1"}
TIMED = [
    "numbers_plain.tif",
    "numbers_plain_tiles.tif",
    "numbers_plain_big_endian.tif",
    "numbers_lzw.tif",
    "numbers_lzw_differences.tif",
    "numbers_deflate_differences.tif",
    "numbers_deflate_tiles.tif",
    "numbers_packbits.tif",
    "metres_plain.tif",
    "metres_lzw.tif",
    "metres_deflate.tif",
    "metres_deflate_float_predictor.tif",
    "doubles.mat",
    "doubles_compressed.mat",
    "singles_compressed.mat",
    "text.pcd",
    "binary.pcd",
    "compressed.pcd",
    "text.ply",
    "binary.ply",
    "doubles.npy",
    "floats.npy",
    "P2.pnm",
    "P5.pnm",
    "P5_16.pnm",
    "P6.pnm",
]
RECORDED = ["text/rplidar/scans_a.mat", "clouds/source.ply"]
FEW_RUNS, MANY_RUNS, SMALL_FILE = 5, 31, 3 * MEGABYTE


def ending_of(path):
    return path.suffix[1:]


def readers_of(programs):
    """{ending: {name: program}}, ours first."""
    readers = collections.defaultdict(dict)
    for name, program in programs.items():
        for ending in run([program])[0].split():
            readers[ending[1:]][name] = program
    return readers


def find_programs(ours):
    subprocess.run([ROOT / "bench/peers/install_file_readers.sh"], check=True)
    peers = ROOT / "build/bench/peers/file_readers"
    programs = {OURS: ours}
    for name in LIBRARIES:
        if (peers / f"{name}_files").exists():
            programs[name] = peers / f"{name}_files"
    return programs, {
        name: (peers / f"{name}_files.version").read_text().strip()
        for name in programs
        if name != OURS
    }


def time_file(path, readers, rounds):
    """The readers in turn; {name: CPU time [ms], the process's peak [MB]}."""
    runs = MANY_RUNS if path.stat().st_size < SMALL_FILE else FEW_RUNS
    times = collections.defaultdict(list)
    for _ in range(rounds):
        for name, program in readers.items():
            output = run([program, "time", runs, path])[0]
            times[name].append(median(map(float, output.split())))
    return {
        name: {
            "cpu_ms": median(times[name]),
            "peak_mb": run([program, "time", 1, path])[1]["peak_mb"],
        }
        for name, program in readers.items()
    }


def measure_speed(files, readers, quick):
    rows = []
    for path in files:
        say(f"  {path.name}")
        figures = time_file(path, readers[ending_of(path)], 1 if quick else 5)
        rows.append({"file": path.name, "bytes": path.stat().st_size, "readers": figures})
    return rows


def try_files(program, paths):
    """[(verdict, what it said)], each file read by a process of its own."""
    done = subprocess.run(
        [program, "try", str(MEMORY_MB), str(CPU_S)],
        input="\n".join(map(str, paths)) + "\n",
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    lines = [line.split("\t", 3) for line in done.stdout.split("\n")[:-1]]
    assert len(lines) == len(paths), (program, len(lines), len(paths))
    return [(verdict, said, float(peak_mb)) for verdict, _, peak_mb, said in lines]


def verdict_on(verdict, said, sound):
    if verdict != "read":
        return verdict
    return "sound" if said == sound else "changed"


def measure_damage(ending, seeds, readers, count, work):
    """What readers make of damaged files whose sound originals all of them read alike."""
    tried = {name: try_files(program, seeds) for name, program in readers.items()}
    told = list(zip(*([said for verdict, said, _ in tries] for tries in tried.values())))
    good = [
        seed
        for i, seed in enumerate(seeds)
        if len(set(told[i])) == 1 and all(tries[i][0] == "read" for tries in tried.values())
    ]
    sound = {seed: said for seed, (_, said, _) in zip(good, try_files(readers[OURS], good))}
    made = make_damaged(work / ending, good, ending, count)
    verdicts, peaks = {}, {}
    for name, program in readers.items():
        tries = try_files(program, [path for path, _ in made])
        verdicts[name] = [
            verdict_on(verdict, said, sound[seed])
            for (verdict, said, _), (_, seed) in zip(tries, made)
        ]
        peaks[name] = max(peak_mb for _, _, peak_mb in tries)
        for (path, _), (verdict, said, _) in zip(made, tries):
            if verdict in ("died", "late") or name == OURS and verdict == "memory":
                say(f"  {name} {verdict}: {path} ({said})")
    rows = {}
    for name, mine in verdicts.items():
        others = [verdicts[other] for other in verdicts if (other == OURS) != (name == OURS)]
        rows[name] = {
            "peak_mb": peaks[name],
            **{kind: mine.count(kind) for kind in KINDS},
            "changed_alone": sum(
                mine[i] == "changed" and all(other[i] == "refused" for other in others)
                for i in range(count)
            ),
            "refused_sound": sum(
                mine[i] not in ("sound", "changed") and any(other[i] == "sound" for other in others)
                for i in range(count)
            ),
        }
    return {"files": count, "seeds": len(good), "readers": rows}


KINDS = ["died", "late", "memory", "refused", "sound", "changed"]


def measure_coverage(files, readers):
    """{ending: {variant: {reader: read, other or refused}}}"""
    coverage = collections.defaultdict(dict)
    for ending, programs in readers.items():
        mine = [path for path in files if ending_of(path) == ending]
        tried = {name: try_files(program, mine) for name, program in programs.items()}
        for i, path in enumerate(mine):
            answers = {name: tries[i][:2] for name, tries in tried.items()}
            read = [said for verdict, said in answers.values() if verdict == "read"]
            usual = collections.Counter(read).most_common(1)[0][0] if read else None
            coverage[ending][path.stem] = {
                name: verdict if verdict != "read" or text == usual else "other"
                for name, (verdict, text) in answers.items()
            }
    return coverage


def packages(names):
    """{package: (installed size [bytes], names of the packages that it needs)}"""
    text = subprocess.run(
        ["apt-cache", "show", "--no-all-versions", *sorted(names)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=False,
    ).stdout.decode()
    found = {}
    for entry in text.split("\n\n"):
        name = re.search(r"^Package: (\S+)", entry, re.M)
        size = re.search(r"^Installed-Size: (\d+)", entry, re.M)
        needs = re.search(r"^Depends: (.*)", entry, re.M)
        if name and size:
            needed = needs.group(1).split(",") if needs else []
            found[name.group(1)] = (
                1024 * int(size.group(1)),
                {re.split(r"[ (:|]", need.strip())[0] for need in needed},
            )
    return found


def closure(name):
    """{package: bytes} of all that is installed with it on a bare system."""
    sizes, left = {}, {name}
    while left:
        found = packages(left)
        sizes.update({each: size for each, (size, _) in found.items()})
        needed = set().union(*(needs for _, needs in found.values()))
        left = needed - set(sizes) - left - OF_THE_SYSTEM
    return sizes


def lines_of(patterns):
    files = {path for pattern in patterns for path in (ROOT / "src/formats").glob(pattern)}
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)


def measure_size(programs, versions):
    needs = {}
    for name in programs:
        if name == OURS:
            continue
        packages = closure(LIBRARIES[name][1]) if LIBRARIES[name][1] else {}
        needs[name] = {
            "version": versions[name],
            "packages": len(packages),
            "bytes": sum(packages.values()),
        }
    return {
        "lines": {ending: lines_of(patterns) for ending, (_, patterns) in FORMATS.items()},
        "libraries": needs,
    }


def title(name):
    return LIBRARIES[name][0] if name in LIBRARIES else name


def speed_table(rows):
    lines = []
    for row in rows:
        ours = row["readers"][OURS]
        for name, theirs in row["readers"].items():
            if name == OURS:
                continue
            lines.append(
                [
                    f"{row['file']}, {title(name)}",
                    f"{row['bytes'] / MEGABYTE:.2f}",
                    f"{ours['cpu_ms']:.2f}",
                    f"{1e-3 * row['bytes'] / ours['cpu_ms']:.0f}",
                    f"{theirs['cpu_ms']:.2f}",
                    f"{theirs['cpu_ms'] / ours['cpu_ms']:.2f}",
                    f"{ours['peak_mb']:.0f}",
                    f"{theirs['peak_mb']:.0f}",
                ]
            )
    header = ["file, library", "size [MB]>", "ours [ms]>", "ours [MB/s]>", "library [ms]>"]
    header += ["library / ours>", "our peak [MB]>", "its peak [MB]>"]
    return table(header, lines)


def damage_table(damage):
    lines = []
    for ending, figures in damage.items():
        for name, row in figures["readers"].items():
            lines.append(
                [
                    f"{FORMATS[ending][0]}, {title(name)}",
                    *[str(row[kind]) for kind in KINDS],
                    str(row["changed_alone"]),
                    str(row["refused_sound"]),
                    f"{row['peak_mb']:.0f}",
                ]
            )
    header = ["format, reader", "died>", f"over {CPU_S} s>", f"over {MEMORY_MB} MB>", "refused>"]
    header += ["undamaged values>", "other values>", "other values, refused by the other side>"]
    header += ["refused, undamaged values by the other side>", "peak [MB]>"]
    return table(header, lines)


WORDS = {"read": "yes", "other": "other values", "refused": "no"}


def coverage_table(coverage):
    lines = []
    for ending in FORMATS:
        for variant, answers in coverage.get(ending, {}).items():
            lines.append(
                [
                    f"{FORMATS[ending][0]}: {variant.replace('_', ' ')}",
                    WORDS.get(answers[OURS], answers[OURS]),
                    ", ".join(
                        f"{title(name)}: {WORDS.get(answer, answer)}"
                        for name, answer in answers.items()
                        if name != OURS
                    ),
                ]
            )
    return table(["variant", "ours", "libraries"], lines)


def size_table(size, readers):
    lines = []
    for ending, (name, _) in FORMATS.items():
        for reader in readers.get(ending, []):
            needs = size["libraries"][reader]
            lines.append(
                [
                    f"{name}, {needs['version']}",
                    str(size["lines"][ending]),
                    str(needs["packages"]) if needs["packages"] else "none: sources",
                    f"{needs['bytes'] / MEGABYTE:.1f}" if needs["packages"] else "",
                ]
            )
    return table(["format, library", "our lines>", "packages>", "installed [MB]>"], lines)


def texts_of(section):
    figures = section["figures"]
    stamp = provenance(section)
    files = next(iter(figures["damage"].values()))["files"] if figures["damage"] else 0
    readers = {
        ending: [name for name in row["readers"] if name != OURS]
        for ending, row in figures["damage"].items()
    }
    return {
        "file-readers-speed": f"{stamp}\n\n{speed_table(figures['speed'])}",
        "file-readers-damage": (
            f"{stamp}\n\n{files} damaged files of each format.\n\n{damage_table(figures['damage'])}"
        ),
        "file-readers-coverage": f"{stamp}\n\n{coverage_table(figures['coverage'])}",
        "file-readers-size": f"{stamp}\n\n{size_table(figures['size'], readers)}",
    }


def measure(arguments):
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    section = circumstances(loopstone.version())
    programs, versions = find_programs(arguments.programs / "measure_file_readers")
    readers = {ending: each for ending, each in readers_of(programs).items() if len(each) > 1}
    work = arguments.work / "file_readers"
    shutil.rmtree(work, ignore_errors=True)
    large = make_files(work / "large", programs, True)
    small = make_files(work / "small", programs, False)
    recorded = [arguments.data / name for name in RECORDED]
    timed = [path for path in large if path.name in TIMED and ending_of(path) in readers]
    timed.sort(key=lambda path: TIMED.index(path.name))
    timed += [path for path in recorded if path.exists() and ending_of(path) in readers]
    say("speed:")
    speed = measure_speed(timed, readers, arguments.quick)
    damage = {}
    for ending in FORMATS:
        if ending in readers:
            say(f"damaged {FORMATS[ending][0]}:")
            seeds = [path for path in small if ending_of(path) == ending]
            count = 100 if arguments.quick else 2000
            damage[ending] = measure_damage(ending, seeds, readers[ending], count, work)
    return {
        **section,
        "figures": {
            "speed": speed,
            "damage": damage,
            "coverage": measure_coverage(small, readers),
            "size": measure_size(programs, versions),
        },
    }


def main():
    parser = plain_parser(__doc__, ROOT)
    parser.add_argument("--again", action="store_true")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    kept = arguments.work / f"file_readers{'-quick' if arguments.quick else ''}.json"
    section = json.loads(kept.read_text()) if arguments.again else measure(arguments)
    kept.write_text(json.dumps(section, indent=1))
    for name, text in texts_of(section).items():
        if arguments.quick:
            print(f"\n{name}\n{text}")
        else:
            write_block(PAGE, name, text)


if __name__ == "__main__":
    main()
