"""Files of bytes that are small and ask for much: each function gives those of one format. They are
tried in every attack, first. Text is in bombs_of_text.py."""

import gzip
import io
import struct
import zipfile
import zlib

HUGE = [0, -1, 1 << 31, 1 << 32, 4_000_000_000, (1 << 63) - 1, 1 << 63, 1 << 64, 10**30]
MEGABYTE = 1 << 20


def zeros(megabytes, step, end):
    """So many of them through a compressor, without holding them."""
    block = bytes(MEGABYTE)
    return b"".join(step(block) for _ in range(megabytes)) + end()


def deflated_zeros(megabytes, lead=b"", wbits=15):
    packer = zlib.compressobj(1, zlib.DEFLATED, wbits)
    return packer.compress(lead) + zeros(megabytes, packer.compress, packer.flush)


def npy_of(shape, kind="<f8", body=b"", fortran=False):
    head = ("{'descr': '%s', 'fortran_order': %s, 'shape': %s, }" % (kind, fortran, shape)).encode()
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(head)) + head + body


def npy():
    shapes = (
        ["(%d, 3)" % n for n in HUGE]
        + ["(3, %d)" % n for n in HUGE]
        + [
            "(4294967296, 4294967296)",
            "(6148914691236517206, 3)",
            "(" + "1, " * 3000 + ")",
            "()",
            "(0, 3)",
            "(3,)",
            "(1000000000, 0)",
        ]
    )
    for shape in shapes:
        yield npy_of(shape, body=bytes(24))
    for kind in (
        "<f16",
        "|O",
        "<U1000000000",
        "|V99999999999",
        ">f2",
        "|b1",
        "<c16",
        "<M8[ns]",
        "<f%s" % ("9" * 400),
    ):
        yield npy_of("(3, 3)", kind, bytes(200))
    yield b"\x93NUMPY\x02\0" + struct.pack("<I", 0xFFFFFFFF) + b"{"
    yield b"\x93NUMPY\x03\0" + struct.pack("<I", 60000) + b"(" * 60000
    for value in (3.4e38, 1e100, 1e308, 5e-324, 1e18, 1e9):
        yield npy_of("(4, 3)", body=struct.pack("<12d", value, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1))
        yield npy_of("(4, 2)", body=struct.pack("<8d", value, 0, 0, 1, -value, 1, 1, 2))
        yield npy_of("(4, 3)", body=struct.pack("<12d", *[value * (1 + i) for i in range(12)]))


def npz():
    def archive(members, kind=zipfile.ZIP_DEFLATED):
        memory = io.BytesIO()
        with zipfile.ZipFile(memory, "w", kind) as made:
            for name, data in members:
                made.writestr(zipfile.ZipInfo(name), data, kind, 1)
        return memory.getvalue()

    for names in (
        ("counts", "time_stamps"),
        ("ranges", "time_stamps"),
        ("angular_velocity", "time_stamps"),
    ):
        for shape in (
            "(1081, 1000000000)",
            "(4, 9223372036854775807)",
            "(1081, 100000)",
            "(-1, 4)",
            "(0, 0)",
        ):
            yield archive([(name + ".npy", npy_of(shape, body=bytes(64))) for name in names])
    yield archive(
        [
            ("ranges.npy", npy_of("(1081, 30000)", body=bytes(1081 * 30000 * 8))),
            ("time_stamps.npy", npy_of("(30000,)")),
        ]
    )
    yield archive([("x" * 60000 + str(i), b"") for i in range(20)])
    yield archive([("%d.npy" % i, npy_of("(3,)")) for i in range(3000)])
    yield b"PK\x05\x06" + b"\xff" * 18


def png_of(width, height, depth, kind, body):
    def chunk(name, data):
        return (
            struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        )

    head = struct.pack(">IIBBBBB", width & 0xFFFFFFFF, height & 0xFFFFFFFF, depth, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def png():
    for width, height in (
        (1 << 31, 1),
        (1, 1 << 31),
        (0, 0),
        (60000, 60000),
        (0x7FFFFFFF, 0x7FFFFFFF),
        (1, 2_000_000),
        (2_000_000, 1),
    ):
        for depth, kind in ((8, 0), (16, 6), (1, 0), (8, 3)):
            yield png_of(width, height, depth, kind, zlib.compress(bytes(1000)))
    yield png_of(40000, 40000, 1, 0, deflated_zeros(191))
    yield png_of(
        5000, 5000, 8, 0, deflated_zeros(24)
    )  # four times the side is a map that somebody has, and takes its time
    yield png_of(4000, 4000, 16, 6, deflated_zeros(123))
    yield png_of(4, 4, 8, 0, deflated_zeros(200))


def pnm():
    for kind in (b"P2", b"P3", b"P5", b"P6", b"P1", b"P4", b"P7"):
        for size in (
            b"60000 60000",
            b"2147483648 1",
            b"1 4294967296",
            b"0 0",
            b"-1 5",
            b"99999999999999999999 1",
            b"46341 46341",
        ):
            yield kind + b" " + size + b" 255\n" + bytes(100)
        yield kind + b" 2 2 99999999999\n1 2 3 4\n"
        yield kind + b"\n" + b"# comment\n" * 100_000 + b"2 2 255 1 2 3 4"


def tiff_of(entries, more=b"", order="<"):
    """\\param entries of (tag, type, count, value)"""
    out = (b"II" if order == "<" else b"MM") + struct.pack(order + "HIH", 42, 8, len(entries))
    for tag, kind, count, value in entries:
        out += struct.pack(order + "HHII", tag, kind, count & 0xFFFFFFFF, value & 0xFFFFFFFF)
    return out + struct.pack(order + "I", 0) + more


def tiff():
    def picture(
        width=16, height=16, strips=1, rows=16, compression=1, bits=32, where=400, size=1024
    ):
        return tiff_of(
            [
                (256, 4, 1, width),
                (257, 4, 1, height),
                (258, 3, 1, bits),
                (259, 3, 1, compression),
                (262, 3, 1, 1),
                (273, 4, strips, where),
                (277, 3, 1, 1),
                (278, 4, 1, rows),
                (279, 4, strips, size),
                (339, 3, 1, 3),
            ],
            bytes(2000),
        )

    for size in (0, 1, 1 << 16, 60000, 0x7FFFFFFF, 0xFFFFFFFF):
        yield picture(width=size)
        yield picture(height=size, rows=size)
        yield picture(width=size, height=size)
        yield picture(strips=size)
        yield picture(rows=size)
        yield picture(where=size)
        yield picture(size=size)
        for compression in (5, 8, 32773, 32946):
            yield picture(width=60000, height=size, compression=compression)
    # Tiles that all lie on the same bytes.
    for tiles, side in ((4096, 16), (100_000, 16), (64, 2048)):
        yield tiff_of(
            [
                (256, 4, 1, side * 64),
                (257, 4, 1, side * (tiles // 64)),
                (258, 3, 1, 32),
                (259, 3, 1, 1),
                (262, 3, 1, 1),
                (277, 3, 1, 1),
                (322, 4, 1, side),
                (323, 4, 1, side),
                (324, 4, tiles, 200),
                (325, 4, tiles, 200 + 4 * tiles),
                (339, 3, 1, 3),
            ],
            struct.pack("<I", 200) * tiles + struct.pack("<I", side * side * 4) * tiles,
        )


def pfm():
    for size in (b"60000 60000", b"2147483648 1", b"0 0", b"-1 5", b"4294967297 1", b"46341 46341"):
        for kind in (b"Pf", b"PF"):
            yield kind + b"\n" + size + b"\n-1.0\n" + bytes(100)
    for scale in (b"0", b"nan", b"1e308", b"-1e-308", b"inf"):
        yield b"Pf\n2 2\n" + scale + b"\n" + bytes(16)


def mat_element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def mat_matrix(rows, columns, size, data=b"", kind=9, array_class=6):
    """\\param size of the numbers, as the file has it"""
    body = (
        mat_element(6, struct.pack("<II", array_class, 0))
        + mat_element(5, struct.pack("<ii", rows, columns))
        + mat_element(1, b"X")
    )
    body += struct.pack("<II", kind, size & 0xFFFFFFFF)
    return struct.pack("<II", 14, (len(body) + size) & 0xFFFFFFFF) + body + data


MAT_HEAD = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"


def mat():
    head, matrix = MAT_HEAD, mat_matrix
    for rows, columns in (
        (1 << 30, 3),
        (-1, 3),
        (0x7FFFFFFF, 0x7FFFFFFF),
        (0, 3),
        (3, 0),
        (715827883, 3),
    ):
        yield head + matrix(rows, columns, 24, bytes(24))
        yield head + matrix(rows, columns, 0xFFFFFFFF, bytes(24))
    rows = 12_000_000
    packed = deflated_zeros(rows * 24 // MEGABYTE + 1, matrix(rows, 3, rows * 24))
    yield head + struct.pack("<II", 15, len(packed)) + packed
    packed = deflated_zeros(100, b"")
    yield head + struct.pack("<II", 15, len(packed)) + packed
    yield head + b"".join(
        struct.pack("<II", 15, len(packed)) + packed for packed in [deflated_zeros(30)] * 20
    )
    nested = b""
    for _ in range(2000):
        nested = struct.pack("<II", 14, len(nested)) + nested
    yield head + nested
    for value in (3.4e38, 1e100, 1e308, 1e9):
        yield head + matrix(4, 3, 96, struct.pack("<12d", value, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1))


def pcd():
    def cloud(
        fields="x y z",
        size="4 4 4",
        kind="F F F",
        count="1 1 1",
        width="2",
        height="1",
        points="2",
        data="ascii",
        body=b"0 0 0\n1 1 1\n",
    ):
        return (
            "VERSION 0.7\nFIELDS %s\nSIZE %s\nTYPE %s\nCOUNT %s\nWIDTH %s\nHEIGHT %s\nPOINTS"
            " %s\nDATA %s\n" % (fields, size, kind, count, width, height, points, data)
        ).encode() + body

    for n in HUGE:
        for data in ("ascii", "binary", "binary_compressed"):
            yield cloud(width=n, points=n, data=data)
            yield cloud(count="1 1 %d" % n, data=data)
        yield cloud(width=n, height=n, points=2)
        yield cloud(size="4 4 %d" % n)
    for packed, unpacked in ((10, 0xFFFFFFFF), (0xFFFFFFFF, 24), (0, 0), (10, 1 << 30)):
        for width in (2, 89_478_485, 1 << 30):
            yield cloud(
                width=width,
                points=width,
                data="binary_compressed",
                body=struct.pack("<II", packed, unpacked) + bytes(100),
            )
    yield cloud(fields="x " * 20000, size="4 " * 20000, kind="F " * 20000, count="1 " * 20000)
    for value in ("3.4e38", "1e100", "1e308", "1e18", "-3.4e38"):
        yield cloud(points="4", width="4", body=("%s 0 0\n1 1 0\n0 1 1\n1 0 1\n" % value).encode())
        yield cloud(
            fields="x y",
            size="8 8",
            kind="F F",
            count="1 1",
            points="4",
            width="4",
            body=("%s 0\n1 1\n0 1\n1 0\n" % value).encode(),
        )


def ply():
    def cloud(elements, kind="ascii", body=b""):
        return ("ply\nformat %s 1.0\n%send_header\n" % (kind, elements)).encode() + body

    xyz = "property double x\nproperty double y\nproperty double z\n"
    for n in HUGE:
        for kind in ("ascii", "binary_little_endian", "binary_big_endian"):
            yield cloud("element vertex %d\n%s" % (n, xyz), kind, bytes(48))
            yield cloud(
                "element face %d\nproperty list uchar int i\nelement vertex 1\n%s" % (n, xyz),
                kind,
                bytes(48),
            )
            yield cloud("element face %d\nelement vertex 1\n%s" % (n, xyz), kind, bytes(48))
    for size in (
        b"\xff\xff\xff\xff",
        b"\x00\x00\x00\x80",
        b"\xfc\xff\xff\xff",
        b"\x00\x00\x00\x20",
        b"\xff\xff\xff\x1f",
    ):
        for kind in ("uint", "int"):
            elements = "element face 2\nproperty list %s double i\nelement vertex 1\n%s" % (
                kind,
                xyz,
            )
            yield cloud(elements, "binary_little_endian", size + bytes(96))
            yield cloud(elements, "binary_little_endian", bytes(4) + size + bytes(96))
    yield cloud(
        "element vertex 1\n" + "property double x\n" * 30000 + xyz,
        "binary_little_endian",
        bytes(400),
    )
    yield cloud("element a 1\nproperty list uchar uchar b\n" * 20000)
    for value in ("3.4e38", "1e100", "1e308", "1e18", "-3.4e38"):
        yield cloud(
            "element vertex 4\n" + xyz, "ascii", ("%s 0 0\n1 1 0\n0 1 1\n1 0 1\n" % value).encode()
        )
        yield cloud(
            "element vertex 4\n" + xyz,
            "ascii",
            ("%s 0 0\n-%s 1 0\n0 1 0\n1 0 0\n" % (value, value)).encode(),
        )


def rawlog_object(name, version, fields):
    return bytes([0x80 + len(name)]) + name + bytes([version]) + fields + b"\x88"


def rawlog_scan(count, seconds=1000):
    place = rawlog_object(b"CPose3D", 2, struct.pack("<7d", 0, 0, 0, 1, 0, 0, 0))
    ticks = 116_444_736_000_000_000 + seconds * 10_000_000
    return rawlog_object(
        b"CObservation2DRangeScan",
        6,
        struct.pack("<fBf", 3.14, 1, 25.0)
        + place
        + struct.pack("<I4f4B", count, 1, 2, 3, 4, 1, 1, 1, 1)
        + struct.pack("<fQfI5sd", 0.01, ticks & (2**64 - 1), 0.0, 5, b"laser", 0.0),
    )


def rawlog():
    for n in HUGE:
        count = n & 0xFFFFFFFF
        scan = rawlog_scan(4)
        yield gzip.compress(scan + rawlog_scan(count) + scan, mtime=0)
        yield gzip.compress(scan + rawlog_scan(4, n), mtime=0)
        for name in (b"CSensoryFrame", b"CActionCollection"):
            head = rawlog_object(name, 2 if name[1] == 83 else 0, struct.pack("<I", count))
            yield gzip.compress(head[:-1] * 3000 + scan, 1, mtime=0)
        label = rawlog_scan(4).replace(struct.pack("<I5s", 5, b"laser"), struct.pack("<I", count))
        yield gzip.compress(scan + label, mtime=0)
    yield deflated_zeros(300, rawlog_scan(4), 31)
    beginnings = (b"\xa2mrpt::obs::CObservation2DRangeScan\7" + bytes(9)) * 100_000
    yield gzip.compress(rawlog_scan(4) + beginnings, 1, mtime=0)
    yield gzip.compress(rawlog_scan(4) + (b"\xe3" + b"C" * 99) * 50_000, 1, mtime=0)


def session():
    def checked(piece):
        return piece + struct.pack("<I", zlib.crc32(piece))

    for version in (0, 1, 3, (1 << 32) - 1):
        yield checked(b"LOOPSESS" + struct.pack("<I", version))
    head = checked(b"LOOPSESS" + struct.pack("<I", 2))
    for size in (0, 8, 1 << 32, 1 << 63, (1 << 64) - 1):
        yield head + struct.pack("<Q", size) + b"\xff" * 64
    # Texts and lists that say that they are longer than all that follows.
    for count in (64, 1 << 32, 1 << 63, (1 << 64) - 1):
        for before in (0, 8, 24, 25, 64):
            content = bytes(before) + struct.pack("<Q", count) + b"\xff" * 64
            yield head + checked(struct.pack("<Q", len(content)) + content)
    yield head


def wheels():
    """A serialisation and language, topic, type, definition, messages: fuzz_wheels.cpp."""
    for last in (b"", b"int32 left_encoder\nint32 right_encoder\n"):
        nested = b"T0 a\n"
        for i in range(6):
            use = b"".join(b"T%d f%d\n" % (i + 1, k) for k in range(100))
            nested += b"MSG: p/T%d\n" % i + (use if i < 5 else last)
        yield b"\x04/encoders\0p/Encoders\0" + nested + b"\0" + (b"\x40\0" + bytes(64)) * 1000
    many = b"".join(b"int32 left_encoder%d\n" % k for k in range(100_000))
    yield b"\x04/encoders\0p/Encoders\0" + many + b"\0" + (b"\xff\xff" + bytes(65535)) * 10
    names = (100_000).to_bytes(4, "little") + b"\2\0\0\0l\0\0\0" * 8000
    joints = b"\0\1\0\0" + bytes(12) + names
    told = len(joints).to_bytes(2, "little") + joints
    yield b"\0/joint_states\0sensor_msgs/JointState\0\0" + told * 20


def jpeg():
    """Heads that claim many pixels, and scans that never end."""
    head = b"\xff\xd8\xff\xdb\0\x43\0" + bytes([1]) * 64
    tables = b"".join(
        b"\xff\xc4\0\x14" + kind + b"\1" + bytes(15) + b"\0" for kind in (b"\0", b"\x10")
    )
    for frame in (b"\xc0", b"\xc2"):
        for height, width in ((65500, 65500), (1, 65500), (65500, 1), (0, 0), (16000, 16000)):
            size = height.to_bytes(2, "big") + width.to_bytes(2, "big")
            picture = head + b"\xff" + frame + b"\0\x0b\x08" + size + b"\1\1\x11\0" + tables
            scan = b"\xff\xda\0\x08\1\1\0\0\0\0"
            yield picture + scan + bytes(100) + b"\xff\xd9"
            yield picture + (scan + b"\0") * 20_000


def picture_message():
    """An encoding, sizes and pixels, or a packed picture: fuzz_picture_message.cpp."""
    for encoding in range(12):
        yield bytes([encoding, 255, 255, 255, 255, 1]) + bytes(100)
        yield bytes([encoding, 255, 255, 8, 0, 0]) + bytes(600_000)
    depth = bytes(12)
    for picture in png():
        yield depth + picture
        yield picture
    yield from jpeg()


def message():
    """A type's number, a serialisation and language, a definition, a message: fuzz_message.cpp."""
    any_ros1 = b"\xc8\x03"
    for count in (0xFFFFFFFF, 0x7FFFFFFF, 1_000_000):
        length = count.to_bytes(4, "little")
        yield from (bytes([number, 1]) + length * 8 for number in range(37))
        yield from (bytes([number, 0, 0, 1, 0, 0]) + length * 8 for number in range(37))
        for element in (b"uint8", b"float64", b"string", b"Empty", b"Small"):
            types = b"MSG: p/Empty\nMSG: p/Small\nuint8 x\n"
            for size in (b"", b"%d" % count):
                definition = element + b"[" + size + b"] a\n" + types + b"\0"
                yield any_ros1 + definition + length * 3
                yield b"\x0d\x03float32[] ranges\n" + definition + length * 3
                yield b"\xc8\x04" + definition + b"\0\1\0\0" + length * 3
    # Types that use the next one a hundred times each.
    for last in (b"", b"uint8 x\n"):
        nested = b"T0[] a\n"
        for i in range(30):
            use = b"".join(b"T%d f%d\n" % (i + 1, k) for k in range(100))
            nested += b"MSG: p/T%d\n" % i + (use if i < 29 else last)
        yield any_ros1 + nested + b"\0" + (1000).to_bytes(4, "little") + bytes(1_000_000)
    yield any_ros1 + b"uint8 a\n" * 100_000 + b"\0" + bytes(100_000)
    yield any_ros1 + b"MSG: p/T\n" * 100_000 + b"\0"
    yield b"\xc8\x06" + b"module a { " * 80_000
    yield b"\xc8\x06" + b"@a(" * 300_000
    yield b"\xc8\x06" + b"/*" * 500_000
    yield b"\xc8\x06module a { " + b"typedef a::b c; " * 50_000
