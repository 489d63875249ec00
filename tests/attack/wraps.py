"""Opens what a format packs, checks or counts, so that damage gets past its door: parts are taken
out, spoiled and packed again with the right checksums and lengths. unpack() of each class gives the
parts, pack() the file."""

import bz2
import gzip
import io
import re
import struct
import zipfile
import zlib

from mutate import BYTES, INTEGERS, TEXT, spoil

MOST_UNPACKED = 1 << 22


def inflate(data):
    return zlib.decompressobj().decompress(data, MOST_UNPACKED)


class Gzip:
    def unpack(self, data):
        return [zlib.decompressobj(31).decompress(data, MOST_UNPACKED)]

    def pack(self, parts):
        return gzip.compress(b"".join(parts), 1, mtime=0)


class Bzip2:
    def unpack(self, data):
        return [bz2.decompress(data)]

    def pack(self, parts):
        return bz2.compress(b"".join(parts), 1)


class Png:
    """A part is a chunk: its type, then its content; the picture's own is inflated."""

    def unpack(self, data):
        parts, picture, at = [], b"", 8
        while at + 8 <= len(data):
            size, kind = struct.unpack(">I4s", data[at : at + 8])
            body = data[at + 8 : at + 8 + size]
            at += size + 12
            if kind != b"IDAT":
                parts.append(kind + body)
                continue
            if not picture:
                parts.append(kind)
            picture += body
        return [part + inflate(picture) if part == b"IDAT" else part for part in parts]

    def pack(self, parts):
        out = b"\x89PNG\r\n\x1a\n"
        for part in parts:
            if part[:4] == b"IDAT":
                part = b"IDAT" + zlib.compress(part[4:], 1)
            out += (
                struct.pack(">I", max(0, len(part) - 4))
                + part
                + struct.pack(">I", zlib.crc32(part))
            )
        return out


class Npy:
    """Two parts: the words of the head, and the numbers."""

    def unpack(self, data):
        size = (
            struct.unpack("<H", data[8:10])[0]
            if data[6:7] == b"\x01"
            else struct.unpack("<I", data[8:12])[0]
        )
        begin = 10 if data[6:7] == b"\x01" else 12
        return [data[begin : begin + size], data[begin + size :]]

    def pack(self, parts):
        head = (parts + [b""])[0]
        lead = (
            b"\x93NUMPY\x01\0" + struct.pack("<H", len(head))
            if len(head) < 1 << 16
            else b"\x93NUMPY\x02\0" + struct.pack("<I", len(head))
        )
        return lead + b"".join([head, *parts[1:]])


class Npz:
    """Parts are head and numbers of each member by turns; a part of its own, the first, names the
    members."""

    def unpack(self, data):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
            parts = ["\n".join(names).encode()]
            for name in names:
                parts += Npy().unpack(archive.read(name))
        return parts

    def pack(self, parts):
        names = parts[0].decode("latin-1").split("\n")
        memory = io.BytesIO()
        with zipfile.ZipFile(memory, "w") as archive:
            for i, name in enumerate(names):
                member = parts[1 + 2 * i : 3 + 2 * i]
                if member:
                    entry = zipfile.ZipInfo(name[:60000] or "x")
                    entry.compress_type = (
                        zipfile.ZIP_DEFLATED if len(member[0]) % 2 else zipfile.ZIP_STORED
                    )
                    archive.writestr(entry, Npy().pack(member))
        return memory.getvalue()


class Mat:
    """The head, then one part an element, inflated when it was compressed."""

    def unpack(self, data):
        parts, at = [data[:128]], 128
        while at + 8 <= len(data):
            kind, size = struct.unpack("<II", data[at : at + 8])
            body = data[at + 8 : at + 8 + size]
            at += 8 + size
            parts.append(inflate(body) if kind == 15 else data[at - 8 - size : at])
        return parts

    def pack(self, parts):
        out = parts[0] if parts else b""
        for i, part in enumerate(parts[1:]):
            if (len(part) + i) % 2:
                part = zlib.compress(part, 1)
                part = struct.pack("<II", 15, len(part)) + part
            out += part
        return out


class Session:
    """The head without its checksum, and the content; its length and checksum are made anew."""

    def unpack(self, data):
        return [data[:12], data[24:-4]]

    def pack(self, parts):
        head = parts[0] if parts else b""
        content = b"".join(parts[1:])
        length = struct.pack("<Q", len(content))
        checksums = [struct.pack("<I", zlib.crc32(piece)) for piece in (head, length + content)]
        return head + checksums[0] + length + content + checksums[1]


class HeadAndBody:
    """Words up to a mark, then numbers: PLY, PCD, PNM, PFM."""

    def __init__(self, mark):
        self.mark = re.compile(mark)

    def unpack(self, data):
        found = self.mark.search(data)
        at = found.end() if found else len(data)
        return [data[:at], data[at:]]

    def pack(self, parts):
        return b"".join(parts)


class Tiff:
    """Nothing is packed here; a field of its directory is set to what no picture has."""

    def unpack(self, data):
        return [data]

    def pack(self, parts):
        return b"".join(parts)

    def spoil_field(self, data, rng):
        order = "<" if data[:2] == b"II" else ">"
        if len(data) < 8:
            return data
        directory = struct.unpack(order + "I", data[4:8])[0]
        if directory + 2 > len(data):
            return data
        count = struct.unpack(order + "H", data[directory : directory + 2])[0]
        at = directory + 2 + 12 * rng.randrange(max(1, min(count, 40)))
        value = rng.choice([*INTEGERS, len(data), len(data) - 1, 8, 16, 1000, 40000]) & 0xFFFFFFFF
        field, size = rng.choice([(0, 2), (2, 2), (4, 4), (8, 4), (8, 4), (8, 2)])
        piece = struct.pack(
            order + ("I" if size == 4 else "H"), value & (0xFFFFFFFF if size == 4 else 0xFFFF)
        )
        return data[: at + field] + piece + data[at + field + size :]


def looks_like_text(part):
    sample = part[:400]
    return bool(sample) and sum(b in b"\t\n\r" or 32 <= b < 127 for b in sample) > 0.9 * len(sample)


def spoil_part(part, rng, donor):
    return spoil(part, rng, donor, TEXT if looks_like_text(part) else BYTES)


def spoil_packed(data, rng, donor, wrap):
    """Mostly inside, sometimes as it lies on disk."""
    if rng.random() < 0.25:
        return spoil(data, rng, donor, BYTES)
    if isinstance(wrap, Tiff) and rng.random() < 0.7:
        for _ in range(rng.choice([1, 1, 2, 3])):
            data = wrap.spoil_field(data, rng)
        return data
    parts, others = wrap.unpack(data), wrap.unpack(donor)
    choice = rng.random()
    at = rng.randrange(len(parts))
    if choice < 0.8:
        parts[at] = spoil_part(parts[at], rng, rng.choice(others))
    elif choice < 0.85:
        del parts[at]
    elif choice < 0.9:
        parts.insert(rng.randrange(len(parts) + 1), rng.choice(parts + others))
    elif choice < 0.95:
        rng.shuffle(parts)
    else:
        parts[at] = rng.choice(others)
    return wrap.pack(parts)
