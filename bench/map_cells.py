"""Maps as map_server reads them, cell by cell."""
import dataclasses
import pathlib
import re

FREE, UNKNOWN, OCCUPIED = 0, 1, 2


@dataclasses.dataclass
class Cells:
    width: int
    height: int
    resolution_m: float
    x_m: float  # of the lower left corner, as y_m
    y_m: float
    states: bytes  # row by row, the lowest first

    @property
    def size_m(self):
        return self.width * self.resolution_m, self.height * self.resolution_m


def cells_of(folder):
    """The map.yaml of a folder, as map_server reads its mode trinary."""
    text = (pathlib.Path(folder) / "map.yaml").read_text()
    number = lambda key: float(re.search(rf"^{key}:\s*(\S+)", text, re.M).group(1))  # noqa: E731
    origin = re.search(r"^origin:\s*\[([^\]]*)\]", text, re.M).group(1).split(",")
    data = (pathlib.Path(folder) / "map.pgm").read_bytes()
    head = re.match(rb"P5\s+(?:#[^\n]*\n)?(\d+)\s+(\d+)\s+(\d+)\s", data)
    width, height, white = (int(word) for word in head.groups())

    def state(pixel):
        occupied = (white - pixel) / white
        if occupied > number("occupied_thresh"):
            return OCCUPIED
        return FREE if occupied < number("free_thresh") else UNKNOWN

    states = data[head.end() :].translate(bytes(state(min(i, white)) for i in range(256)))
    rows = [states[width * row : width * (row + 1)] for row in reversed(range(height))]
    return Cells(
        width, height, number("resolution"), float(origin[0]), float(origin[1]), b"".join(rows)
    )
