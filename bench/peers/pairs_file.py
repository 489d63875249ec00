"""Reads the files of bench/pairs_file.hpp: nothing but doubles."""
import numpy as np


def _scan(numbers, at):
    count = int(numbers[at])
    start, step = numbers[at + 1 : at + 3]
    ranges = numbers[at + 4 : at + 4 + count]
    angles = start + step * np.arange(count)
    good = np.isfinite(ranges)
    points = ranges[good, None] * np.column_stack([np.cos(angles[good]), np.sin(angles[good])])
    return points, at + 4 + count


def read_pairs(path, with_points=True):
    """For each pair (truth, guess, target points, source points); poses are (x, y, yaw),
    target_T_source."""
    numbers = np.fromfile(path)
    pairs, at = [], 1
    for _ in range(int(numbers[0])):
        truth, guess = numbers[at : at + 3], numbers[at + 3 : at + 6]
        at += 6
        if with_points:
            target, at = _scan(numbers, at)
            source, at = _scan(numbers, at)
            pairs.append((truth, guess, target, source))
        else:
            for _ in range(2):
                at += 4 + int(numbers[at])
            pairs.append((truth, guess, None, None))
    return pairs
