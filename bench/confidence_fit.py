"""The model of localisation's probability, p = mass * precision * logistic(weights . features), and
its most likely weights.

The features are those of src/localization/confidence.cpp; check() compares the two."""
import math
import pathlib
import re

HEADER = pathlib.Path("src/localization/confidence_weights.hpp")
# Name and sign that the weight may have: more evidence for a pose never lowers its probability. 0:
# any.
FEATURES = [
    ("1", 0),
    ("explained of the rest", 1),
    ("violations", -1),
    ("unexpected", -1),
    ("lately explained of the rest", 1),
    ("lately violations", -1),
    ("lately unexpected", -1),
    ("lately known", 1),
    ("along explained of the rest", 1),
    ("along violations", -1),
    ("along unexpected", -1),
    ("along known", 1),
    ("along silent", -1),
    ("spread_m", -1),
    ("spread_rad", -1),
    ("innovation", -1),
    ("followed and explained", 1),
    ("unproven", -1),
]
# Standard deviation of a weight before any drive was seen: between no evidence and all of it lie
# some e^10 in odds.
PRIOR_SIGMA = 10.0
ITERATIONS_MOST = 200


def of_rest(row, prefix=""):
    """What is explained of what should be: people and new things stand before the rest."""
    seen = max(0.3, 1.0 - row[prefix + "unexpected"])
    return min(1.0, row[prefix + "explained"] / seen)


def features(row):
    along = of_rest(row, "along_")
    return [
        1.0,
        of_rest(row),
        math.sqrt(row["violations"]),
        row["unexpected"],
        of_rest(row, "lately_"),
        math.sqrt(row["lately_violations"]),
        row["lately_unexpected"],
        row["lately_known"],
        along,
        math.sqrt(row["along_violations"]),
        row["along_unexpected"],
        row["along_known"],
        math.sqrt(row["along_silent"]),
        min(row["spread_m"], 1.0),
        min(row["spread_rad"], 0.5) / 0.5,
        min(math.log1p(row["innovation"]), 3.0) / 3.0,
        along * min(row["followed_m"], 10.0) / 10.0,
        row["unproven"],
    ]


def logistic(x):
    return 1.0 / (1.0 + math.exp(-x)) if x >= 0.0 else math.exp(x) / (1.0 + math.exp(x))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def probability(weights, row):
    return row["mass"] * row["precision"] * logistic(dot(weights, features(row)))


def samples_of(drives, most, weight_of):
    """(features, mass * precision, right, weight): a drive weighs the same however long it is: its
    scans are not independent."""
    samples = []
    for drive in drives:
        rows = drive.rows[:: max(1, len(drive.rows) // most)]
        for row in rows:
            samples.append(
                (
                    features(row),
                    row["mass"] * row["precision"],
                    row["right"] > 0.5,
                    weight_of(drive) / len(rows),
                )
            )
    return samples


def log_likelihood(weights, samples):
    total = -0.5 * dot(weights, weights) / PRIOR_SIGMA**2
    for x, most, right, weight in samples:
        p = most * logistic(dot(weights, x))
        total += weight * math.log(max(p if right else 1.0 - p, 1e-12))
    return total


def slope_and_information(weights, samples):
    """Gradient of log_likelihood, and Fisher's information (expected curvature), which is positive
    definite."""
    n = len(weights)
    slope = [-w / PRIOR_SIGMA**2 for w in weights]
    information = [[1.0 / PRIOR_SIGMA**2 if i == j else 0.0 for j in range(n)] for i in range(n)]
    for x, most, right, weight in samples:
        s = logistic(dot(weights, x))
        p = min(max(most * s, 1e-12), 1.0 - 1e-12)
        dp = p * (1.0 - s)
        g = weight * (dp / p if right else -dp / (1.0 - p))
        h = weight * dp * dp / (p * (1.0 - p))
        for i in range(n):
            slope[i] += g * x[i]
            hx = h * x[i]
            for j in range(i, n):
                information[i][j] += hx * x[j]
    for i in range(n):
        for j in range(i):
            information[i][j] = information[j][i]
    return slope, information


def solved(matrix, right):
    """Gauss's elimination; the matrix is positive definite and small."""
    n = len(right)
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - dot(rows[i][i + 1 : n], x[i + 1 :])) / rows[i][i]
    return x


def allowed(weights):
    return [w if sign == 0 or w * sign > 0.0 else 0.0 for w, (_, sign) in zip(weights, FEATURES)]


def fit(samples, start, only=()):
    """Fisher's scoring with steps cut short where they don't help; weights that would get the wrong
    sign stay at 0, and all but those named in `only`, if any are, as they were."""
    weights = allowed(start)
    value = log_likelihood(weights, samples)
    for _ in range(ITERATIONS_MOST):
        slope, information = slope_and_information(weights, samples)
        free = [
            i
            for i, (w, (_, sign)) in enumerate(zip(weights, FEATURES))
            if (w != 0.0 or sign == 0 or slope[i] * sign > 0.0)
            and (not only or FEATURES[i][0] in only)
        ]
        step = [0.0] * len(weights)
        for i, part in zip(
            free,
            solved([[information[i][j] for j in free] for i in free], [slope[i] for i in free]),
        ):
            step[i] = part
        scale, gained = 1.0, 0.0
        while scale > 1e-4:
            tried = allowed([w + scale * s for w, s in zip(weights, step)])
            gained = log_likelihood(tried, samples) - value
            if gained > 0.0:
                weights, value = tried, value + gained
                break
            scale *= 0.5
        if gained < 1e-6:
            break
    return weights, value


def read_weights(root):
    text = (root / HEADER).read_text(encoding="utf-8")
    numbers = re.search(r"kConfidenceWeights\{([^}]*)\}", text).group(1)
    return [float(number) for number in re.sub("//.*", "", numbers).split(",") if number.strip()]


def write_weights(root, weights, drives, scans, only=()):
    numbers = [f"{weight:.4f}," for weight in weights]
    width = max(map(len, numbers))  # as clang-format aligns comments
    kept = f"; of {', '.join(only)} alone, the others as they were" if only else ""
    lines = "\n".join(
        f"    {number:{width}}  // {name}" for number, (name, _) in zip(numbers, FEATURES)
    )
    (root / HEADER).write_text(
        f"""#pragma once

#include <array>

#include "localization/confidence.hpp"

namespace loopstone {{

// Written by `bench/confidence.py fit`: the most likely weights of {drives} drives, {scans}
// scans{kept}.
inline constexpr std::array<double, kConfidenceFeatures> kConfidenceWeights{{
{lines}
}};

}}  // namespace loopstone
""",
        encoding="utf-8",
    )


def check(drives, weights):
    """That the program computes the same: it may be older than the weights, or the features may
    have come apart."""
    for drive in drives:
        for row in drive.rows:
            if abs(probability(weights, row) - row["probability"]) > 2e-6:
                raise SystemExit(
                    f"{drive.name}: the program says {row['probability']}, the weights of"
                    f" {HEADER} say {probability(weights, row):.6f}; `make bench` builds it anew"
                )
