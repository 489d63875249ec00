#!/usr/bin/env python3
"""Writes the glyphs of the pictures' font as C++, from the outlines of DejaVu Sans (Debian package
fonts-dejavu-core): what a picture says does not depend on the fonts of the machine that draws it.
Needs fontTools (Debian package python3-fonttools).

  scripts/write_font.py [--fonts DIR] > src/report/font_outlines.hpp
"""
import argparse
import pathlib
import sys

from fontTools.pens.basePen import decomposeQuadraticSegment
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib import TTFont

# ASCII, Latin-1, and what stands beside numbers.
BESIDE_NUMBERS = "–—‘’“”…•−×±≈≠≤≥∞√→←↑↓′″σχμΔΣΩπ"
CHARACTERS = sorted({*range(0x20, 0x7F), *range(0xA0, 0x100), *map(ord, BESIDE_NUMBERS)})
MISSING = 0  # stands for the box of a character that the font does not have
FACES = {"Regular": "DejaVuSans.ttf", "Bold": "DejaVuSans-Bold.ttf"}


def outline_of(glyphs, name):
    """The glyph's closed curves, each a list of (control x, y, end x, y), after its start: a
    straight line has its control point at its end."""
    pen = DecomposingRecordingPen(glyphs)
    glyphs[name].draw(pen)
    contours = []
    for verb, points in pen.value:
        if verb == "moveTo":
            contours.append([points[0]])
        elif verb == "lineTo":
            contours[-1].append((*points[0], *points[0]))
        elif verb == "qCurveTo":
            if points[-1] is None:  # a curve without a point on it begins between two controls
                start = tuple((a + b) // 2 for a, b in zip(points[-2], points[0]))
                contours.append([start])
                points = (*points[:-1], start)
            for control, end in decomposeQuadraticSegment(points):
                contours[-1].append((*map(round, control), *map(round, end)))
        elif verb != "closePath":
            raise SystemExit(f"{name}: {verb} is not known here")
    return contours


def numbers_of(contours):
    """Each contour: how many curves, where it starts, then the curves."""
    for contour in contours:
        yield len(contour) - 1
        yield from contour[0]
        for curve in contour[1:]:
            yield from curve


def in_lines(words, width=98):
    line = " "
    for word in words:
        if len(line) + len(word) > width:
            yield line
            line = " "
        line += " " + word
    yield line


def face(name, path):
    font = TTFont(path)
    if font["head"].unitsPerEm != 2048:
        raise SystemExit(f"{path}: not 2048 units an em")
    glyphs, names = font.getGlyphSet(), font.getBestCmap()
    outlines, table = [], []
    for code in [MISSING, *CHARACTERS]:
        glyph = ".notdef" if code == MISSING else names[code]
        numbers = list(numbers_of(outline_of(glyphs, glyph)))
        table.append(f"{{{code}, {glyphs[glyph].width}, {len(outlines)}, {len(numbers)}}},")
        outlines += numbers
    yield f"inline constexpr std::int16_t k{name}Outlines[] = {{"
    yield from in_lines(f"{number}," for number in outlines)
    yield "};"
    yield f"inline constexpr FontGlyph k{name}Glyphs[] = {{"
    yield from in_lines(table)
    yield "};"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n", maxsplit=1)[0])
    parser.add_argument("--fonts", default="/usr/share/fonts/truetype/dejavu", metavar="DIR")
    fonts = pathlib.Path(parser.parse_args().fonts)
    print("#pragma once\n\n#include <cstdint>\n")
    print("// Written by scripts/write_font.py from DejaVu Sans, whose licence is in")
    print("// cmake/debian_copyright. Do not edit.\n")
    print("namespace loopstone {\n")
    print("/// A character: its advance in units of 1/2048 of the size, and where its curves stand")
    print("/// among the face's numbers. Character 0 is drawn for all that are missing.")
    print("struct FontGlyph {")
    print("  char32_t code;\n  std::int16_t advance;\n  std::int32_t first;\n  std::int32_t count;")
    print("};\n")
    print(
        "// For each closed curve the number of its pieces and its first point, then each piece's"
    )
    print("// control point and end; y is up from the base line.")
    print("// clang-format off")
    for name, file in FACES.items():
        print("\n".join(face(name, fonts / file)))
    print("// clang-format on\n\n}  // namespace loopstone")
    return 0


if __name__ == "__main__":
    sys.exit(main())
