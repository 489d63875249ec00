"""Poses that another system gave some scans of a CARMEN log, found again by what those scans
measured."""
import math


def lasers(path):
    """(ranges, pose, stamp) of each FLASER line; stamps as text."""
    with open(path, encoding="ascii", errors="replace") as file:
        for line in file:
            words = line.split()
            if words and words[0] == "FLASER":
                count = int(words[1])
                ranges = tuple(round(float(word), 2) for word in words[2 : 2 + count])
                yield ranges, tuple(map(float, words[2 + count : 5 + count])), words[-3]


def write_reference(path, raw, corrected):
    """A TUM trajectory of the corrected poses at the raw log's stamps (the corrected log's own are
    rounded or shifted). Returns how many scans were found again, and how many there are."""
    stamps = {ranges: stamp for ranges, _, stamp in lasers(raw)}
    found, count = [], 0
    for ranges, (x, y, yaw), _ in lasers(corrected):
        count += 1
        if ranges in stamps:
            found.append((stamps[ranges], x, y, yaw))
    found.sort(key=lambda row: float(row[0]))
    with open(path, "w", encoding="ascii") as file:
        last = None
        for stamp, x, y, yaw in found:
            if stamp != last:  # a robot that stands measures the same twice
                file.write(f"{stamp} {x} {y} 0 0 0 {math.sin(0.5 * yaw)} {math.cos(0.5 * yaw)}\n")
            last = stamp
    return len(found), count
