"""From measured figures of pose graphs to Markdown. Nothing is measured here, and no figure is
typed here but the known optima and the targets."""
import dataclasses
import math

import pose_graph_picture as picture
import pose_graph_online
import tables
from doc_blocks import table
from registration_tables import provenance

# Sums of e^T Omega e, what SE-Sync (9b631b6) certifies of its own objective, and the time that
# certificate and solution may take.
OPTIMA = {
    "intel": {"chi2": 45.0046958, "isotropic": 52.3482273, "limit_s": 0.0235},
    "MIT": {"chi2": 41.1632688, "isotropic": 61.1541155, "limit_s": 0.0095},
    "manhattan": {"chi2": 3549.03680, "isotropic": 6431.39139, "limit_s": 0.0625},
    "city10000": {"chi2": 511.985164, "isotropic": 638.624619, "limit_s": 0.46},
}
REACHED = 1e-6
# GTSAM's own error is not g2o's: it ends 1e-4 beside the optimum and still counts as there.
REACHED_OTHER_ERROR = 5e-4
FASTER_THAN = {
    "g2o_gauss_newton": 2.5,
    "gtsam_gauss_newton": 10.0,
    "gtsam_levenberg_marquardt": 10.0,
    "ceres_levenberg_marquardt": 10.0,
}
# Smaller graphs tell about fixed costs.
LARGE = 10000

SYSTEMS = [
    ("loopstone", "Loopstone"),
    ("loopstone_certified", "Loopstone, certified, from the edges alone"),
    ("g2o_gauss_newton", "g2o GN"),
    ("gtsam_gauss_newton", "GTSAM GN"),
    ("gtsam_levenberg_marquardt", "GTSAM LM"),
    ("ceres_levenberg_marquardt", "Ceres LM"),
]


def reaches(system, figures, optimum):
    share = REACHED_OTHER_ERROR if system.startswith("gtsam") else REACHED
    return figures["cost"] <= optimum * (1 + share)


def cell(row, system, text_of):
    figures = row["systems"].get(system)
    if figures is None:
        return ""
    if not reaches(system, figures, OPTIMA[row["name"]]["chi2"]):
        return f"bad: {figures['cost']:.4g}"
    return text_of(figures)


def targets_of_speed(rows):
    found = []
    for row in rows:
        own = row["systems"]["loopstone"]
        optimum = OPTIMA[row["name"]]["chi2"]
        off = abs(own["cost"] / optimum - 1)
        found.append(
            (
                f"{row['name']}: cost reached from the spanning tree",
                f"{optimum:.9g} to {REACHED:g}",
                f"{own['cost']:.9g}",
                off <= REACHED,
            )
        )
        for system, factor in FASTER_THAN.items():
            figures = row["systems"].get(system)
            if figures is None or not reaches(system, figures, optimum):
                continue
            ratio = figures["seconds"] / own["seconds"]
            found.append(
                (
                    f"{row['name']}: times faster than {dict(SYSTEMS)[system]}",
                    f">= {factor:g}",
                    f"{ratio:.1f}",
                    ratio >= factor,
                )
            )
    return found


def speed_tables(section):
    rows = section["figures"]
    names = [title for _, title in SYSTEMS]
    header = ["graph", "poses>", "edges>", *[name + ">" for name in names]]

    def body(text_of):
        return [
            [
                row["name"],
                str(row["poses"]),
                str(row["edges"]),
                *[cell(row, system, text_of) for system, _ in SYSTEMS],
            ]
            for row in rows
        ]

    return "\n".join(
        [
            provenance(section),
            "",
            (
                "CPU time of the optimisation alone [ms], from the poses of the spanning tree, the"
                f" fastest of {section['repeats']} runs; steps in brackets. The second column has"
                " no start: it makes its own, minimises and certifies the isotropic objective, and"
                ' solves. "bad" is the cost that a system ended at.'
            ),
            "",
            table(header, body(lambda f: f"{1e3 * f['seconds']:.1f} ({f['steps']})")),
            "",
            (
                "Whole process, CPU time [ms]: reading, optimisation and, with the Python wheels,"
                " the start of Python and of the library."
            ),
            "",
            table(header, body(lambda f: f"{1e3 * f['cpu_s']:.0f}")),
            "",
            tables.targets_table(targets_of_speed(rows)),
        ]
    )


def certificate_tables(section):
    body, targets = [], []
    for row in section["figures"]:
        known = OPTIMA[row["name"]]
        found = row["certificate"]
        body.append(
            [
                row["name"],
                row["start"],
                "yes" if row["certified"] else "**no**",
                f"{found['cost']:.9g}",
                f"{row['gap']:.1e}",
                f"{row['min_eigenvalue']:.1e}",
                f"{found['eigenvalue_tolerance']:.1e}",
                str(found["escapes"]),
                f"{1e3 * row['cpu_s']:.1f}",
                f"{row['cost']:.9g}",
            ]
        )
        off = abs(found["cost"] / known["isotropic"] - 1)
        targets.append(
            (
                f"{row['name']} from {row['start']}: certified optimum",
                f"{known['isotropic']:.9g} to {REACHED:g}",
                f"{found['cost']:.9g}",
                row["certified"] and off <= REACHED,
            )
        )
        if row["start"] != "file":
            limit_s = known["limit_s"]
            targets.append(
                (
                    f"{row['name']}: start, certified minimum and solution",
                    f"<= {1e3 * limit_s:.1f} ms",
                    f"{1e3 * row['cpu_s']:.1f} ms",
                    row["cpu_s"] <= limit_s,
                )
            )
    header = [
        "graph",
        "start",
        "certified",
        "isotropic cost>",
        "gap at most>",
        "smallest eigenvalue>",
        "proven above minus>",
        "local minima left>",
        "CPU time [ms]>",
        "cost of the solution>",
    ]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            table(header, body),
            "",
            tables.targets_table(targets),
        ]
    )


@dataclasses.dataclass
class PowerLaw:
    """factor * nodes^exponent, fitted from the first to the last number of nodes."""

    factor: float
    exponent: float
    half_width: float  # of the exponent's 95 % confidence interval
    first: int
    last: int

    def at(self, nodes):
        return self.factor * nodes**self.exponent


# Student's t, two-sided 95 %, for 1 to 8 degrees of freedom.
STUDENT_95 = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306]


def power_law(points):
    """Through (nodes, value), by least squares of logarithms."""
    xs, ys = [math.log(nodes) for nodes, _ in points], [math.log(value) for _, value in points]
    mean_x, mean_y = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((x - mean_x) ** 2 for x in xs)
    slope = sum((x - mean_x) * (y - mean_y) for x, y in zip(xs, ys)) / spread
    left = sum((y - mean_y - slope * (x - mean_x)) ** 2 for x, y in zip(xs, ys))
    freedom = len(points) - 2
    half_width = (
        STUDENT_95[min(freedom, 8) - 1] * math.sqrt(left / freedom / spread)
        if freedom > 0
        else math.inf
    )
    return PowerLaw(
        math.exp(mean_y - slope * mean_x), slope, half_width, points[0][0], points[-1][0]
    )


def scaling_curves(section):
    """Points and power law of a step's time [ms] and of the peak memory [MB], from LARGE poses
    on."""
    rows = section["figures"]
    curves = []
    for value_of in (
        lambda row: 1e3 * row["seconds"] / max(1, row["steps"]),
        lambda row: row["peak_mb"],
    ):
        points = [(row["nodes"], value_of(row)) for row in rows]
        curves.append((points, power_law([point for point in points if point[0] >= LARGE])))
    return curves


def scaling_picture(section):
    (times, time_law), (memory, memory_law) = scaling_curves(section)
    return picture.scaling_picture(
        [
            ("a Gauss-Newton step [ms]", times, time_law, "#0072b2"),
            ("peak memory of the process [MB]", memory, memory_law, "#d55e00"),
        ]
    )


def scaling_tables(section):
    (times, time_law), (memory, memory_law) = scaling_curves(section)
    body = [
        [
            f"{row['nodes']:,}",
            f"{row['edges']:,}",
            str(row["steps"]),
            f"{row['seconds']:.3f}",
            f"{step_ms:.2f}",
            f"{megabytes:.0f}",
            row["status"],
        ]
        for row, (_, step_ms), (_, megabytes) in zip(section["figures"], times, memory)
    ]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            (
                "A square field driven lane by lane, the lane beside seen at every third pose"
                " (`bench/pose_graph_starts.py`), from the spanning tree. The time of a step is the"
                " solution's CPU time, with the one analysis that all steps share, over the number"
                " of steps."
            ),
            "",
            (
                "![Time of a step and peak memory over the number of"
                " poses](images/pose_graph_scaling.svg)"
            ),
            "",
            (
                f"From {time_law.first:,} to {time_law.last:,} poses a step grows as"
                f" poses^{time_law.exponent:.2f} (+- {time_law.half_width:.2f}), memory as"
                f" poses^{memory_law.exponent:.2f} (+- {memory_law.half_width:.2f}; least squares"
                " of logarithms, 95 % confidence). A planar grid's factor costs at least poses^1.5"
                " operations and poses log(poses) numbers (Hoffman, Martin and Rose 1973; George"
                " 1973)."
            ),
            "",
            table(
                [
                    "poses>",
                    "edges>",
                    "steps>",
                    "solution [s]>",
                    "a step [ms]>",
                    "peak memory of the process [MB]>",
                    "status",
                ],
                body,
            ),
        ]
    )


def blocks_of(sections):
    makers = {
        "speed": speed_tables,
        "certificate": certificate_tables,
        "scaling": scaling_tables,
        "online": pose_graph_online.online_tables,
    }
    return [
        (f"pose-graph-{name}", makers[name](section))
        for name, section in sections.items()
        if name in makers
    ]


def summary(sections):
    lines = []
    if "speed" in sections:
        lines += [
            f"{figure}: {measured} (target {target}) {'met' if met else 'NOT MET'}"
            for figure, target, measured, met in targets_of_speed(sections["speed"]["figures"])
        ]
    return "\n".join(lines)
