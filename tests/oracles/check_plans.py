#!/usr/bin/env python3
"""Holds the plans of `loopstone export` against the libraries that others read them with: ezdxf,
GDAL (through pyogrio) and shapely of Python.

  scripts/install_oracles.sh && tests/oracles/check_plans.py [--program PROGRAM]

A short drive in a simulated office is mapped and exported. Its DXF must pass ezdxf's audit without
a fault, its GeoJSON must be read by GDAL as what the program says it is, its rooms must be valid
polygons of the areas that they are said to have, and all files must tell the same plan.
"""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PYTHON = ROOT / "build/oracles/venv/bin/python"
if PYTHON.exists() and pathlib.Path(sys.prefix) != PYTHON.parent.parent:
    os.execv(PYTHON, [str(PYTHON), *sys.argv])

try:
    import ezdxf
    import pyogrio
    import shapely
    from ezdxf import recover
except ImportError as error:
    sys.exit(f"{error}: run scripts/install_oracles.sh first")

LATITUDE, LONGITUDE, BEARING = 48.26555, 11.6711, 93.5


def require(condition, text):
    if not condition:
        raise AssertionError(text)


def run(program, *words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
    require(done.returncode == 0, f"{words[0]} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def in_map(x, y):
    """From longitude and latitude to metres of the map, by the radii of WGS 84 at the anchor."""
    phi = math.radians(LATITUDE)
    e2 = 0.00669437999014
    w = math.sqrt(1.0 - e2 * math.sin(phi) ** 2)
    east = math.radians(x - LONGITUDE) * 6378137.0 / w * math.cos(phi)
    north = math.radians(y - LATITUDE) * 6378137.0 * (1.0 - e2) / w**3
    turn = math.radians(BEARING)
    return (
        math.sin(turn) * east + math.cos(turn) * north,
        -math.cos(turn) * east + math.sin(turn) * north,
    )


def check_dxf(folder, told):
    path = folder / "plan.dxf"
    document, auditor = recover.readfile(path)
    require(not auditor.errors and not auditor.fixes, f"ezdxf: {auditor.errors} {auditor.fixes}")
    document = ezdxf.readfile(path)
    require(document.dxfversion == "AC1009", document.dxfversion)
    space = document.modelspace()
    layers = [line.dxf.layer for line in space.query("LINE")]
    walls = layers.count("STRUCTURE") + layers.count("HIDDEN") + layers.count("MOVABLE")
    require(walls == told["segments"], f"{walls} lines of {told['segments']}")
    require(layers.count("DOORS") == len(told["doors"]), "doors")
    rings = [p for p in space.query("POLYLINE") if p.dxf.layer == "ROOMS"]
    require(all(ring.is_closed for ring in rings), "a room that is not closed")
    require(len(rings) >= len(told["rooms"]) > 0, "rooms")
    return sum(
        math.dist(line.dxf.start, line.dxf.end)
        for line in space.query("LINE")
        if line.dxf.layer == "STRUCTURE"
    )


def check_geojson(folder, told):
    path = folder / "plan.geojson"
    about, _, shapes, fields = pyogrio.raw.read(path)
    require(about["crs"] == "EPSG:4326", about["crs"])
    names = list(about["fields"])
    column = {name: fields[names.index(name)] for name in names}
    parts = shapely.from_wkb(shapes)
    flat = [shapely.transform(part, lambda points: [in_map(*p) for p in points]) for part in parts]
    layers = list(column["layer"])
    require(
        sum(layer in ("structure", "hidden", "movable") for layer in layers) == told["segments"],
        "segments",
    )
    rooms = [(i, part) for i, part in enumerate(flat) if layers[i] == "room"]
    require(len(rooms) == len(told["rooms"]), "rooms")
    for i, room in rooms:
        require(room.is_valid, f"room {i}: {shapely.is_valid_reason(room)}")
        require(room.exterior.is_ccw, f"room {i}: RFC 7946 has outer rings counter-clockwise")
        require(
            abs(room.area - column["area_m2"][i]) < 0.002 + 1e-4 * room.area,
            f"room {i}: {room.area} and {column['area_m2'][i]}",
        )
    for k, (i, room) in enumerate(rooms):
        for j, other in rooms[k + 1 :]:
            shared = room.intersection(other).area
            require(shared < 0.05, f"rooms {i} and {j} share {shared} m2")
    for i, part in enumerate(flat):
        if layers[i] in ("structure", "hidden", "movable"):
            require(abs(part.length - column["length_m"][i]) < 0.001, "length")
    return sum(part.length for part, layer in zip(flat, layers) if layer == "structure")


def check_drawing(folder, told):
    tree = xml.etree.ElementTree.parse(folder / "plan.svg")
    space = "{http://www.w3.org/2000/svg}"
    lines = {
        group.get("id"): len(group.findall(space + "path")) for group in tree.iter(space + "g")
    }
    drawn = sum(lines[layer] for layer in ("structure", "hidden", "movable"))
    require(drawn == told["segments"], f"{drawn} lines of {told['segments']}")
    pdf = (folder / "plan.pdf").read_bytes()
    require(pdf.startswith(b"%PDF-1.4") and pdf.rstrip().endswith(b"%%EOF"), "PDF")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    program = parser.parse_args().program
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(
            program,
            *("simulate", "office", "-o", folder / "sim", "--seed", "5", "--duration", "60"),
            *("--beams", "361", "--quiet"),
        )
        run(program, "map", folder / "sim", "-o", folder / "out", "--keep-state", "--quiet")
        for source in ("out", "out/map.yaml"):
            told = json.loads(
                run(
                    program,
                    *("export", folder / source, "--svg", folder / "plan.svg"),
                    *("--pdf", folder / "plan.pdf", "--dxf", folder / "plan.dxf"),
                    *("--geojson", folder / "plan.geojson"),
                    *("--anchor", f"{LATITUDE},{LONGITUDE},{BEARING}"),
                    *("--json", "--quiet", "--force"),
                )
            )
            lengths = check_dxf(folder, told), check_geojson(folder, told), told["structure_m"]
            require(max(lengths) - min(lengths) < 0.01 + 1e-4 * max(lengths), f"walls: {lengths}")
            check_drawing(folder, told)
            print(f"{source}: {told['segments']} segments, {len(told['rooms'])} rooms as told")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as error:
        sys.exit(f"check_plans: {error}")
