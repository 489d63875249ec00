"""The files that bench/file_readers.py reads: variants of formats, and damaged ones. Most are
written by the libraries that ours is compared with; the rest is made here, byte by byte."""
import array
import pathlib
import random
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/attack"))

import mutate  # noqa: E402

# What a library's program is told to make: large files are timed, small ones are damaged.
LARGE = {"tiff": ["640", "480"], "mat": ["500"], "pcl": ["1000000"]}
SMALL = {"tiff": ["48", "40"], "mat": ["2"], "pcl": ["40"]}
LIBRARY_OF = {"tif": "tiff", "mat": "mat", "pcd": "pcl", "ply": "pcl"}
HEAD_BYTES = 400
# libtiff writes what other formats have in front at the end.
HEAD_IS_LAST = {"tif"}


def numbers(count, top=1000):
    state = 1
    for _ in range(count):
        state = (state * 1664525 + 1013904223) % (1 << 32)
        yield (state >> 16) % top


def npy(descr, code, rows, columns, fortran=False, version=1):
    """An array of NumPy; code is that of struct, byte order first."""
    values = list(numbers(rows * columns, 100))
    if code[0] == "<" and code[1] != "e":
        data = array.array(code[1], values).tobytes()
    else:
        data = struct.pack(f"{code[0]}{len(values)}{code[1]}", *values)
    head = f"{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': ({rows}, {columns}), }}"
    fixed = 10 if version == 1 else 12
    head += " " * (63 - (fixed + len(head)) % 64) + "\n"
    size = struct.pack("<H" if version == 1 else "<I", len(head))
    return b"\x93NUMPY" + bytes([version, 0]) + size + head.encode() + data


NPY = {
    "doubles": ("<f8", "<d", False, 1),
    "doubles_fortran": ("<f8", "<d", True, 1),
    "doubles_version_2": ("<f8", "<d", False, 2),
    "doubles_big_endian": (">f8", ">d", False, 1),
    "floats": ("<f4", "<f", False, 1),
    "halves": ("<f2", "<e", False, 1),
    "int64": ("<i8", "<q", False, 1),
    "int16": ("<i2", "<h", False, 1),
    "uint8": ("|u1", "<B", False, 1),
}


def pnm(kind, width, height):
    """P1 to P7; plain ones as text."""
    top = {"P1": 1, "P4": 1, "P5_16": 65535}.get(kind, 255)
    channels = 3 if kind in ("P3", "P6") else 1
    values = list(numbers(width * height * channels, top + 1))
    maxval = "" if top == 1 else f"{top}\n"
    head = f"{kind[:2]}\n{width} {height}\n{maxval}".encode()
    if kind == "P7":
        head = (
            f"P7\nWIDTH {width}\nHEIGHT {height}\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\n"
            "ENDHDR\n"
        ).encode()
    if kind in ("P1", "P2", "P3"):
        rows = [
            " ".join(map(str, values[i : i + channels * width]))
            for i in range(0, len(values), channels * width)
        ]
        return head + "\n".join(rows).encode() + b"\n"
    if kind == "P4":
        return head + bytes(height * ((width + 7) // 8))
    if top > 255:
        return head + struct.pack(f">{len(values)}H", *values)
    return head + bytes(values)


PNM = ["P1", "P2", "P3", "P4", "P5", "P5_16", "P6", "P7"]


def mat_big_endian(scans):
    """Version 5, one matrix of doubles, as a machine with the other byte order writes it."""
    values = list(numbers(scans * 360))
    name = struct.pack(">HH4s", 1, 1, b"r\0\0\0")
    matrix = struct.pack(">IIIIIIII", 6, 8, 6, 0, 5, 8, scans, 360) + name
    matrix += struct.pack(f">II{len(values)}d", 9, 8 * len(values), *values)
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\1\0MI"
    return head + struct.pack(">II", 14, len(matrix)) + matrix


def ply(order, count, with_lists):
    """Doubles with colours or, before the vertices, faces."""
    head = "ply\nformat binary_" + ("little" if order == "<" else "big") + "_endian 1.0\n"
    data = b""
    if with_lists:
        head += "element face 3\nproperty list uchar int vertex_indices\n"
        data += b"".join(struct.pack(order + "Biii", 3, i, i + 1, i + 2) for i in range(3))
    head += f"element vertex {count}\nproperty double x\nproperty double y\nproperty double z\n"
    head += "property uchar red\nend_header\n"
    points = iter(numbers(4 * count, 200))
    for _ in range(count):
        data += struct.pack(order + "dddB", *(0.5 * next(points) for _ in range(3)), next(points))
    return head.encode() + data


def pcd_doubles(count):
    values = (0.5 * value for value in numbers(3 * count))
    head = (
        "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\n"
        f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA binary\n"
    )
    return head.encode() + struct.pack(f"<{3 * count}d", *values)


def make_here(folder, large):
    """What no library writes for us."""
    count, scans = (20000, 50) if large else (40, 2)
    side, rows = (2000, 1000000) if large else (12, 30)
    files = {
        "doubles_big_endian.mat": mat_big_endian(scans),
        "binary_doubles.pcd": pcd_doubles(count),
        "binary_doubles_colours.ply": ply("<", count, False),
        "big_endian_doubles.ply": ply(">", count, False),
        "faces_first.ply": ply("<", count, True),
        "faces_first_big_endian.ply": ply(">", count, True),
    }
    for name, (descr, code, fortran, version) in NPY.items():
        files[f"{name}.npy"] = npy(descr, code, rows, 3, fortran, version)
    for kind in PNM:
        files[f"{kind}.pnm"] = pnm(kind, side, side // 2)
    for name, data in files.items():
        (folder / name).write_bytes(data)


def make_files(folder, programs, large):
    """All variants, in one folder; those of libraries that are not there are left out."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, sizes in (LARGE if large else SMALL).items():
        if name in programs:
            subprocess.run(
                [programs[name], "make", folder, *sizes], check=True, stderr=subprocess.DEVNULL
            )
    make_here(folder, large)
    return sorted(folder.iterdir())


def is_text(data):
    return all(byte in b"\t\n\r" or 32 <= byte < 127 for byte in data)


def spoiled(data, donor, ending, rng):
    """Half of the damage is done where sizes and types stand."""
    mutators = mutate.BYTES
    if is_text(data) or (is_text(data[:40]) and rng.random() < 0.5):
        mutators = mutate.TEXT
    if rng.random() < 0.5:
        return mutate.spoil(data, rng, donor, mutators)
    if ending in HEAD_IS_LAST:
        cut = max(len(data) - HEAD_BYTES, 0)
        return data[:cut] + mutate.spoil(data[cut:], rng, donor[-HEAD_BYTES:], mutators)
    return mutate.spoil(data[:HEAD_BYTES], rng, donor[:HEAD_BYTES], mutators) + data[HEAD_BYTES:]


def make_damaged(folder, seeds, ending, count):
    """[(path, path of the seed)]: the same for the same count, seeds and version of Python."""
    folder.mkdir(parents=True, exist_ok=True)
    contents = [seed.read_bytes() for seed in seeds]
    made = []
    for i in range(count):
        rng = random.Random(f"{ending} {i}")
        donor = rng.choice(contents)
        path = folder / f"{i}.{ending}"
        path.write_bytes(spoiled(contents[i % len(seeds)], donor, ending, rng))
        made.append((path, seeds[i % len(seeds)]))
    return made
