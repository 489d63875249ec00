"""Ways to spoil a file. Each takes the bytes, a random generator and a donor (another good file of
the same format) and gives new bytes; spoil() applies one to four of them. Nothing here knows a
format: see wraps.py for those with checksums."""

import re
import struct

NUMBERS = [
    b"nan",
    b"-nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e309",
    b"3.4e38",
    b"3.5e38",
    b"1e100",
    b"1e18",
    b"1e12",
    b"4e9",
    b"-0",
    b"0",
    b"-1",
    b"1",
    b"1e-308",
    b"4.9e-324",
    b"1e-9",
    b"0x10",
    b"1e",
    b"1,5",
    b"--1",
    b"+1",
    b"1.2.3",
    b"",
    b"127",
    b"128",
    b"255",
    b"256",
    b"32767",
    b"32768",
    b"65535",
    b"65536",
    b"2147483647",
    b"2147483648",
    b"-2147483648",
    b"-2147483649",
    b"4294967295",
    b"4294967296",
    b"9223372036854775807",
    b"9223372036854775808",
    b"-9223372036854775808",
    b"18446744073709551616",
    b"1" + b"0" * 308,
    b"9" * 309,
    b"0." + b"0" * 309 + b"1",
    b"1e" + b"9" * 20,
]
INTEGERS = [
    0,
    1,
    2,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0x8000,
    0xFFFF,
    0x10000,
    0x7FFFFFFF,
    0x80000000,
    0xFFFFFFFF,
    1 << 32,
    1 << 40,
    1 << 60,
    (1 << 63) - 1,
    1 << 63,
    (1 << 64) - 1,
]
REALS = [
    float("nan"),
    float("inf"),
    float("-inf"),
    1e308,
    -1e308,
    3.4e38,
    3.5e38,
    1e100,
    1e18,
    1e12,
    4e9,
    2147483648.0,
    -0.0,
    4.9e-324,
    1e-300,
    -1.0,
]
ODD_BYTES = [
    b"\0",
    b"\x1b[2J\x1b[31m",
    b"\xff",
    b"\xc3\x28",
    b"\xed\xa0\x80",
    b"\x7f",
    b"\r",
    b"\b\b",
    b"\x9b",
    b"\xef\xbb\xbf",
    b"\n",
    b"\t",
    b" ",
    b'"',
    b"#",
    b"<script>",
    b"%s%n",
    b"../",
]
NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")


def place(data, rng):
    return rng.randrange(len(data)) if data else 0


def stretch(data, rng):
    """A range of bytes, short as a rule."""
    begin = place(data, rng)
    return begin, min(len(data), begin + 1 + int(rng.expovariate(1 / 16)))


def put(data, begin, end, piece):
    return data[:begin] + piece + data[end:]


# Bytes.


def flip_bits(data, rng, _donor):
    if not data:
        return data
    out = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        out[place(out, rng)] ^= 1 << rng.randrange(8)
    return bytes(out)


def set_bytes(data, rng, _donor):
    begin, end = stretch(data, rng)
    return put(
        data, begin, end, bytes([rng.choice([0, 1, 0x20, 0x7F, 0x80, 0xFE, 0xFF])]) * (end - begin)
    )


def set_integer(data, rng, _donor):
    size = rng.choice([1, 2, 4, 8])
    value = (rng.choice(INTEGERS) + rng.choice([0, 0, 0, 1, -1])) % (1 << 8 * size)
    at = place(data, rng) // rng.choice([1, size]) * rng.choice([1, size]) if data else 0
    at = min(at, len(data))
    return put(data, at, at + size, value.to_bytes(size, rng.choice(["little", "big"])))


def set_real(data, rng, _donor):
    code = rng.choice("fd")
    value = rng.choice(REALS)
    if code == "f" and abs(value) > 3.4e38:
        value = float("inf")
    piece = struct.pack(rng.choice("<>") + code, value)
    at = place(data, rng) // 4 * 4
    return put(data, at, at + len(piece), piece)


def cut_off(data, rng, _donor):
    return data[: place(data, rng)]


def cut_front(data, rng, _donor):
    return data[place(data, rng) :]


def remove(data, rng, _donor):
    begin, end = stretch(data, rng)
    return data[:begin] + data[end:]


def repeat(data, rng, _donor):
    begin, end = stretch(data, rng)
    return put(data, begin, begin, data[begin:end] * rng.choice([1, 2, 10, 200]))


def move(data, rng, _donor):
    begin, end = stretch(data, rng)
    rest = data[:begin] + data[end:]
    at = place(rest, rng)
    return put(rest, at, at, data[begin:end])


def append(data, rng, donor):
    return data + rng.choice([b"\0" * 100, b"\xff" * 7, data, donor, b"\n" * 1000])


def splice(data, rng, donor):
    return data[: place(data, rng)] + donor[place(donor, rng) :]


def insert_odd(data, rng, _donor):
    at = place(data, rng)
    return put(data, at, at, rng.choice(ODD_BYTES) * rng.choice([1, 1, 1, 50]))


def nothing_left(_data, rng, _donor):
    return rng.choice([b"", b"\0", b"\n", b" ", b"\xef\xbb\xbf"])


BYTES = [
    flip_bits,
    set_bytes,
    set_integer,
    set_integer,
    set_real,
    cut_off,
    cut_front,
    remove,
    repeat,
    move,
    append,
    splice,
    insert_odd,
]


# Text.


def one_of(pattern, data, rng):
    found = list(pattern.finditer(data, 0, 1 << 16))
    return rng.choice(found).span() if found else stretch(data, rng)


def set_number(data, rng, _donor):
    begin, end = one_of(NUMBER, data, rng)
    return put(data, begin, end, rng.choice(NUMBERS))


def scale_number(data, rng, _donor):
    begin, end = one_of(NUMBER, data, rng)
    try:
        value = float(data[begin:end])
    except ValueError:
        return data
    return put(
        data, begin, end, repr(value * rng.choice([-1, 10, 1e3, 1e6, 1e12, 1e-3, 1e-12])).encode()
    )


def set_word(data, rng, donor):
    begin, end = one_of(WORD, data, rng)
    word_begin, word_end = one_of(WORD, donor, rng)
    return put(data, begin, end, donor[word_begin:word_end])


def long_word(data, rng, _donor):
    begin, end = one_of(WORD, data, rng)
    return put(
        data,
        begin,
        end,
        rng.choice([b"a", b"9", b"a.", b"\xc3\xa9"]) * rng.choice([300, 5000, 70000]),
    )


def nest(data, rng, _donor):
    opening, closing = rng.choice(
        [
            (b"[", b"]"),
            (b"{", b"}"),
            (b"[[", b"]]"),
            (b"{a=", b"}"),
            (b"(", b")"),
            (b"- ", b""),
            (b"a.", b""),
        ]
    )
    depth = rng.choice([3, 100, 10000, 50000])
    begin, end = one_of(NUMBER, data, rng)
    return put(
        data,
        begin,
        end,
        opening * depth + data[begin:end] + (closing * depth if rng.random() < 0.5 else b""),
    )


def with_lines(change):
    def mutator(data, rng, donor):
        lines = data.split(b"\n")
        change(lines, rng, donor)
        return b"\n".join(lines)

    mutator.__name__ = change.__name__
    return mutator


@with_lines
def drop_line(lines, rng, _donor):
    del lines[rng.randrange(len(lines))]


@with_lines
def repeat_line(lines, rng, _donor):
    at = rng.randrange(len(lines))
    lines[at:at] = [lines[at]] * rng.choice([1, 2, 30])


@with_lines
def swap_lines(lines, rng, _donor):
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[i], lines[j] = lines[j], lines[i]


@with_lines
def reverse_lines(lines, rng, _donor):
    begin = rng.choice([0, rng.randrange(len(lines))])
    lines[begin:] = lines[begin:][::-1]


@with_lines
def shuffle_lines(lines, rng, _donor):
    rng.shuffle(lines)


@with_lines
def foreign_line(lines, rng, donor):
    lines.insert(rng.randrange(len(lines) + 1), rng.choice(donor.split(b"\n")))


@with_lines
def join_lines(lines, rng, _donor):
    at = rng.randrange(len(lines))
    lines[at : at + 2] = [b" ".join(lines[at : at + 2])]


def change_tokens(change):
    """For one line, or the same in all lines that are as long."""

    def mutator(data, rng, _donor):
        lines = data.split(b"\n")
        pick = rng.choice(lines).split(b" ")
        at = rng.randrange(len(pick))
        everywhere = rng.random() < 0.5
        action = change(rng)
        for i, line in enumerate(lines):
            tokens = line.split(b" ")
            if tokens == pick or (everywhere and len(tokens) == len(pick) and tokens[0] == pick[0]):
                tokens[at : at + 1] = action(tokens[at])
                lines[i] = b" ".join(tokens)
        return b"\n".join(lines)

    mutator.__name__ = change.__name__
    return mutator


@change_tokens
def set_column(rng):
    value = rng.choice(NUMBERS)
    return lambda _token: [value]


@change_tokens
def scale_column(rng):
    """Stamps in milliseconds, ranges in millimetres, turned back in time..."""
    factor = rng.choice([1e3, 1e6, 1e9, 1e-3, -1, 0])

    def scaled(token):
        try:
            return [repr(float(token) * factor).encode()]
        except ValueError:
            return [token]

    return scaled


@change_tokens
def drop_column(_rng):
    return lambda _token: []


@change_tokens
def repeat_column(rng):
    times = rng.choice([2, 3, 500])
    return lambda token: [token] * times


def line_ends(data, rng, _donor):
    return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b"", b"\0", b"\n\r"]))


def blanks(data, rng, _donor):
    return data.replace(b" ", rng.choice([b"\t", b"  ", b"\xc2\xa0", b",", b";", b"\v"]))


TEXT = [
    set_number,
    set_number,
    set_number,
    scale_number,
    set_word,
    long_word,
    nest,
    drop_line,
    repeat_line,
    swap_lines,
    reverse_lines,
    shuffle_lines,
    foreign_line,
    join_lines,
    set_column,
    set_column,
    scale_column,
    drop_column,
    repeat_column,
    line_ends,
    blanks,
    insert_odd,
    cut_off,
    splice,
    flip_bits,
    append,
]

LONGEST = 1 << 20


def spoil(data, rng, donor, mutators):
    for _ in range(rng.choice([1, 1, 1, 2, 2, 3, 4])):
        changed = rng.choice(mutators)(data, rng, donor)
        if len(changed) <= LONGEST:
            data = changed
    return data if rng.random() > 0.002 else nothing_left(data, rng, donor)
