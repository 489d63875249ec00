"""Pose graphs with false loop closures, and how far two solutions are apart."""
import cmath
import math
import random

import pose_graph_starts as starts


def closures_of(edges):
    """Edges that are not from a pose to the next one, as the program tells them apart."""
    return [words for words in edges if abs(int(words[2]) - int(words[1])) != 1]


def extent_m(poses):
    """The larger side of the box around the positions."""
    xs, ys = [pose[0] for pose in poses.values()], [pose[1] for pose in poses.values()]
    return max(max(xs) - min(xs), max(ys) - min(ys))


def planted(poses, edges, count, seed):
    """False closures: between two poses drawn uniformly that are not neighbours, with a relative
    position uniform in a square as large as the map, any heading, and the information of a genuine
    closure drawn with them.

    A seed gives one sequence, of which the first `count` are taken: more is always the same and
    some more."""
    rng = random.Random(seed)
    ids, genuine, half_m = sorted(poses), closures_of(edges), extent_m(poses) / 2
    found = []
    while len(found) < count:
        i, j = sorted(rng.sample(ids, 2))
        x, y, yaw = (
            rng.uniform(-half_m, half_m),
            rng.uniform(-half_m, half_m),
            rng.uniform(-math.pi, math.pi),
        )
        information = rng.choice(genuine)[6:12]
        if j - i > 1:
            found.append(["EDGE_SE2", str(i), str(j), repr(x), repr(y), repr(yaw), *information])
    return found


def write_spoilt(path, clean, false_closures):
    """The file as it is, with false closures behind everything else."""
    with open(clean, encoding="ascii") as file:
        text = file.read()
    with open(path, "w", encoding="ascii") as file:
        file.write(text if text.endswith("\n") else text + "\n")
        file.writelines(" ".join(words) + "\n" for words in false_closures)


def odometry(edges):
    """Poses along the edges from each pose to the next."""
    steps = [words for words in edges if int(words[2]) - int(words[1]) == 1]
    return starts.spanning_tree(steps)


def distance_m(poses, reference):
    """Root mean square distance of positions after the best motion in the plane (Umeyama 1991; Horn
    1987)."""
    ids = sorted(poses.keys() & reference.keys())
    a = [complex(*poses[i][:2]) for i in ids]
    b = [complex(*reference[i][:2]) for i in ids]
    mean_a, mean_b = sum(a) / len(a), sum(b) / len(b)
    turn = sum((q - mean_b) * (p - mean_a).conjugate() for p, q in zip(a, b))
    rotation = cmath.rect(1.0, cmath.phase(turn))
    return math.sqrt(
        sum(abs(rotation * (p - mean_a) - (q - mean_b)) ** 2 for p, q in zip(a, b)) / len(a)
    )


def read_truth(path):
    """id -> (x, y, yaw) of lines `id x y yaw`; None when there is no such file."""
    if not path.exists():
        return None
    lines = (line.split() for line in path.read_text(encoding="ascii").splitlines())
    return {int(words[0]): tuple(map(float, words[1:4])) for words in lines if words}
