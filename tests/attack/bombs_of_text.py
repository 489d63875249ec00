"""Text that is small and asks for much: each function gives that of one format. It is tried in
every attack, first."""

import bz2
import gzip

from bombs import HUGE, deflated_zeros, zeros

FLASER = b"FLASER 4 1.0 1.1 1.2 1.3 0 0 0 0 0 0 1000.0 robot 0.1\n"


def drive(mount_x, mount_y=0.0, ranges=b"3 3 4 4 5 5 4 4 3 3", step=0.1):
    """A robot that drives ahead, its laser mounted somewhere."""
    line = b"FLASER 10 " + ranges + b" %.10g %.10g 0 %.10g 0 0 %.10g robot %.10g\n"
    return b"".join(
        line % (i * step + mount_x, mount_y, i * step, 1000 + 0.2 * i, 0.2 * i) for i in range(20)
    )


def carmen():
    scan = FLASER * 3
    for mount in (100.0, 3000.0, 40_000.0, 1e6, 2e8, 4e9, 1e15):
        yield drive(mount)
        yield drive(mount, mount)
        yield drive(0.0, step=mount)
    for far in (b"81.9", b"1000", b"1e6", b"4e9", b"1e30"):
        yield drive(0.0, ranges=b" ".join([far] * 10))
        yield drive(0.0, ranges=b"3 3 3 " + far + b" 3 3 3 3 3 3")
    for count in HUGE:
        yield scan + b"FLASER %d 1 1 1 0 0 0 0 0 0 1001 robot 0.2\n" % count
    for mount in (b"4e9", b"1e18", b"1e308", b"nan"):
        yield b"PARAM robot_frontlaser_offset " + mount + b"\n" + scan
        yield b"PARAM laser_front_laser_resolution " + mount + b"\n" + scan
        yield b"".join(
            b"FLASER 4 1.0 1.1 1.2 1.3 %s 0 0 %d 0 0 %d r %d\n" % (mount, i, 1000 + i, i)
            for i in range(5)
        )
        yield b"".join(
            b"ROBOTLASER1 0 -1 2 1 30 0.1 0 4 1 1 1 1 0 %s 0 0 0 0 0 0 0 0 0 0 %d r %d\n"
            % (mount, 1000 + i, i)
            for i in range(5)
        )
    yield b"FLASER 300000 " + b"1 " * 300000 + b"0 0 0 0 0 0 1000 robot 0.1\n"
    yield b"FLASER 4 " + b"1" * 3_000_000 + b" 1 1 1 0 0 0 0 0 0 1000 r 0.1\n"
    yield b"\n" * 2_000_000
    yield b"x" * 3_000_000
    yield b"".join(b"FLASER 4 1.0 1.1 1.2 1.3 0 0 0 0 0 0 0 r 0\n" for _ in range(200))
    yield b"".join(
        b"FLASER 4 1.0 1.1 1.2 1.3 0 0 0 0 0 0 %d r %d\n" % (2000 - i, 2000 - i) for i in range(200)
    )
    yield b"".join(
        b"FLASER 4 1.0 1.1 1.2 1.3 0 0 0 0 0 0 %d r %d\n" % (1000000 * i, 1000 * i)
        for i in range(1, 50)
    )
    yield b"".join(
        b"FLASER 4 1.0 1.1 1.2 1.3 %d 0 0 %d 0 0 %d r %d\n" % (10**i, 10**i, 1000 + i, i)
        for i in range(1, 30)
    )
    frozen = b"FLASER 60 " + b"".join(b"%d.5 " % (70 + i % 7) for i in range(60))
    for step in (3000, 10**7):
        yield b"".join(
            frozen
            + b"%d %d 0 %d %d 0 %d r %d\n" % (step * i, step * i, step * i, step * i, 1000 + i, i)
            for i in range(10)
        )
    yield b"".join(
        b"FLASER 4 1 1 1 1 0 0 0 0 0 0 %d r %d\n" % (10**i, 10**i) for i in range(1, 22)
    )


def carmen_gz():
    yield deflated_zeros(300, FLASER, 31)
    yield gzip.compress(
        b"FLASER 30000000 " + b"1 " * 30_000_000 + b"0 0 0 0 0 0 1000 robot 0.1\n", 1, mtime=0
    )
    yield gzip.compress(b"\n" * 50_000_000, 1, mtime=0)
    yield gzip.compress(FLASER, mtime=0) * 500


def carmen_bz2():
    packer = bz2.BZ2Compressor(9)
    yield packer.compress(FLASER) + zeros(100, packer.compress, packer.flush)
    yield bz2.compress(FLASER) * 500


def graph():
    edge = b"EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    for n in HUGE:
        yield edge + b"EDGE_SE2 0 %d 1 0 0 1 0 0 1 0 1\n" % n
        yield b"VERTEX_SE2 %d 0 0 0\n" % n + edge
        yield b"EDGE2 0 %d 1 0 0 1 0 1 1 0 0\n" % n
    for value in (b"1e308", b"1e154", b"3.4e38", b"1e-300", b"1e18", b"-1e308"):
        yield edge + b"EDGE_SE2 1 2 %s 0 0 1 0 0 1 0 1\nEDGE_SE2 2 0 1 0 0 1 0 0 1 0 1\n" % value
        yield edge + b"EDGE_SE2 1 2 1 0 %s 1 0 0 1 0 1\nEDGE_SE2 2 0 1 0 0 1 0 0 1 0 1\n" % value
        yield edge + b"EDGE_SE2 1 2 1 0 0 %s 0 0 1 0 1\nEDGE_SE2 2 0 1 0 0 1 0 0 1 0 1\n" % value
        yield b"VERTEX_SE2 0 %s 0 0\nVERTEX_SE2 1 0 %s 0\n" % (value, value) + edge
    yield from text()


def text():
    yield b"x" * 3_000_000
    yield b"1 " * 1_000_000
    yield b"\n" * 3_000_000
    yield b"1" * 1_000_000 + b" 0 0 0 0 0 0 1\n"
    yield b"#" * 1_000_000


def landmarks():
    yield from text()
    yield b"id,x_m,y_m" + b",z" * 1_000_000 + b"\n"
    yield b"id,x_m,y_m\n" + b"".join(b"%d,0,0\n" % i for i in range(100_000))
    yield b"id,x_m,y_m\n" + b"".join(b"%d,%d,%d\n" % (i, i % 300, i // 300) for i in range(9000))


def mrclam():
    yield from text()
    barcodes = b"".join(b"%d %d\n" % (i, i) for i in range(100_000))
    yield barcodes + b"\n=\n1 0 0\n\n=\n" + b"1 7 1 0\n" * 200_000 + b"\n=\n" + barcodes
    yield b"7 7\n\n=\n" + b"1e9 1e9 1e9\n" * 200_000 + b"\n=\n1 7 1 0\n"


def map_yaml():
    def yaml(image="map.pgm", resolution="0.05", origin="[0, 0, 0]", more=""):
        return (
            "image: %s\nresolution: %s\norigin: %s\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh:"
            " 0.196\n%s" % (image, resolution, origin, more)
        ).encode()

    for image in (
        "/dev/zero",
        "/dev/stdin",
        ".",
        "..",
        "/",
        "input.yaml",
        "/proc/self/mem",
        '""',
        "no such picture",
        "/dev/null",
        "a" * 5000,
    ):
        yield yaml(image=image)
    for number in (
        "1e12",
        "1e100",
        "1e308",
        "1e-308",
        "1e-12",
        "nan",
        "inf",
        "0",
        "-1",
        "1e9",
        "1e18",
        "1" + "0" * 309,
    ):
        yield yaml(resolution=number)
        for origin in ("[%s, 0, 0]", "[0, %s, 0.5]", "[0, 0, %s]", "[%s, %s, 0.7]"):
            yield yaml(origin=origin.replace("%s", number))
        yield yaml(resolution="1e-9", origin="[%s, 0, 0.3]" % number)
    yield b"[" * 100_000
    yield b"{" * 100_000
    yield b"- " * 100_000
    yield b"? " * 50_000
    yield b"a: &a [x]\n" + b"".join(
        b"%c: &%c [%s]\n" % (98 + i, 98 + i, b",".join([b"*%c" % (97 + i)] * 10)) for i in range(20)
    )
    yield b"a: &a {<<: *a}\n"
    yield yaml(more="more: &x [*x]\n")
    yield yaml(more="---\nimage: b\n")
    yield yaml() * 2
    yield b"!!binary " + b"A" * 100_000


def cloud_text():
    for value in ("3.4e38", "1e100", "1e308", "1e18", "-3.4e38", "nan", "inf", "1" + "0" * 309):
        yield ("x,y,z\n%s,0,0\n1,1,0\n0,1,1\n1,0,1\n" % value).encode()
        yield ("%s 0\n1 1\n0 1\n1 0\n2 3\n" % value).encode()
    yield b"1," * 500_000
    yield b"x,y" + b",c" * 100_000 + b"\n1,2\n"
    for n in HUGE:
        yield b"%d\n0 0 0\n1 1 1\n" % n
    yield b"0 0 0\n" * 100_000
    yield from text()


def toml():
    for depth in (100, 10_000, 100_000):
        yield b".".join([b"a"] * depth) + b" = 1\n"
        yield b"[" + b".".join([b"a"] * depth) + b"]\n"
        yield b"a = " + b"[" * depth + b"]" * depth + b"\n"
        yield b"a = " + b"[" * depth
        yield b"a = " + b"{b=" * depth + b"1" + b"}" * depth + b"\n"
        yield b"[[a]]\n" * depth
        yield b"[" * depth
    yield b'a = "' + b"\\" * 99_999 + b'"\n'
    yield b'"' * 100_000
    yield b"".join(b"k%d = 1\n" % i for i in range(20_000))
    yield b"front_end.points_max = " + b"9" * 400 + b"\n"
    for value in (
        b"nan",
        b"inf",
        b"-inf",
        b"1e308",
        b"1e309",
        b"0x" + b"f" * 40,
        b"1979-05-27T07:32:00Z",
        b"[]",
        b"{}",
        b"''",
        b"true",
    ):
        yield b"[map]\nresolution_m = " + value + b"\n[front_end]\npoints_max = " + value + b"\n"
        yield b"[[lidar]]\nx_m = " + value + b"\nyaw_rad = " + value + b"\n"
        yield b"[wheels]\nradius_m = " + value + b"\n"
