"""Pose graph files to measure with: public graphs from their spanning tree, and grids of any
size."""
import collections
import math
import random


def read_graph(path):
    """(vertices, edges): id -> (x, y, yaw), and the words of each EDGE_SE2 line."""
    vertices, edges = {}, []
    with open(path, encoding="ascii") as file:
        for line in file:
            words = line.split()
            if words and words[0] == "VERTEX_SE2":
                vertices[int(words[1])] = tuple(map(float, words[2:5]))
            elif words and words[0] == "EDGE_SE2":
                edges.append(words)
    return vertices, edges


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (
        a[0] + c * b[0] - s * b[1],
        a[1] + s * b[0] + c * b[1],
        math.remainder(a[2] + b[2], 2 * math.pi),
    )


def inverse(a):
    c, s = math.cos(a[2]), math.sin(a[2])
    return (-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2])


def spanning_tree(edges):
    """Poses by the fewest edges from the lowest id, which is at the origin."""
    neighbours = collections.defaultdict(list)
    for words in edges:
        i, j, z = int(words[1]), int(words[2]), tuple(map(float, words[3:6]))
        neighbours[i].append((j, z))
        neighbours[j].append((i, inverse(z)))
    first = min(neighbours)
    poses, queue = {first: (0.0, 0.0, 0.0)}, collections.deque([first])
    while queue:
        node = queue.popleft()
        for other, z in neighbours[node]:
            if other not in poses:
                poses[other] = compose(poses[node], z)
                queue.append(other)
    return poses


def write_graph(path, poses, edges):
    with open(path, "w", encoding="ascii") as file:
        for node in sorted(poses):
            file.write("VERTEX_SE2 {} {!r} {!r} {!r}\n".format(node, *poses[node]))
        for words in edges:
            file.write(" ".join(words) + "\n")


def write_grid(path, nodes, seed=1):
    """A robot that drives a square field lane by lane, one pose a metre, and sees the lane beside
    it at every third pose."""
    rng = random.Random(seed)
    side = max(2, round(math.sqrt(nodes)))
    truth = []
    for i in range(nodes):
        lane, along = divmod(i, side)
        forward = lane % 2 == 0
        truth.append(
            (
                float(along if forward else side - 1 - along),
                float(lane),
                0.0 if forward else math.pi,
            )
        )
    pairs = [(i, i + 1) for i in range(nodes - 1)]
    for i in range(nodes):
        lane, along = divmod(i, side)
        beside = (lane - 1) * side + side - 1 - along
        if lane > 0 and along % 3 == 0 and i - beside > 1:
            pairs.append((beside, i))
    edges = []
    for i, j in pairs:
        x, y, yaw = compose(inverse(truth[i]), truth[j])
        z = (
            x + rng.gauss(0.0, 0.03),
            y + rng.gauss(0.0, 0.03),
            math.remainder(yaw + rng.gauss(0.0, 0.01), 2 * math.pi),
        )
        edges.append(
            [
                "EDGE_SE2",
                str(i),
                str(j),
                *[repr(value) for value in z],
                "1111",
                "0",
                "0",
                "1111",
                "0",
                "10000",
            ]
        )
    write_graph(path, spanning_tree(edges), edges)
