"""From drives to what they say about localisation's probability: figures, Markdown, a picture.
Nothing is measured here."""
import math

from confidence_drives import DURATION_S, KINDS, place_title
from doc_blocks import table
from provenance import provenance

BINS = 10


def pairs_of(drives):
    """(probability, right) of all scans."""
    return [(row["probability"], row["right"] > 0.5) for drive in drives for row in drive.rows]


def share(part, whole):
    return part / whole if whole else None


def mean(values):
    return share(math.fsum(values), len(values))


def reliability(pairs):
    bins = [[] for _ in range(BINS)]
    for probability, right in pairs:
        bins[min(BINS - 1, int(probability * BINS))].append((probability, right))
    return [
        {
            "scans": len(found),
            "stated": mean([p for p, _ in found]),
            "right": mean([float(r) for _, r in found]),
        }
        for found in bins
    ]


def calibration_error(bins):
    """Mean distance between what is stated and what is right, over all scans (expected calibration
    error)."""
    scans = sum(found["scans"] for found in bins)
    return sum(
        found["scans"] / scans * abs(found["stated"] - found["right"])
        for found in bins
        if found["scans"]
    )


def auc(pairs):
    """Probability that a right pose is given a higher one than a wrong pose; None when all are of
    one kind. By ranks (Mann and Whitney); equal probabilities share their mean rank."""
    ordered = sorted(pairs)
    right = sum(1 for _, is_right in ordered if is_right)
    wrong = len(ordered) - right
    if not right or not wrong:
        return None
    ranks, i = 0.0, 0
    while i < len(ordered):
        j = i
        while j < len(ordered) and ordered[j][0] == ordered[i][0]:
            j += 1
        ranks += 0.5 * (i + 1 + j) * sum(1 for _, is_right in ordered[i:j] if is_right)
        i = j
    return (ranks - 0.5 * right * (right + 1)) / (right * wrong)


def longest_wrong_m(drives):
    """Longest path over which a drive was TRACKING and wrong."""
    longest = 0.0
    for drive in drives:
        since = None
        for row in drive.rows:
            if row["tracking"] and row["right"] < 0.5:
                since = row["travelled_m"] if since is None else since
                longest = max(longest, row["travelled_m"] - since)
            else:
                since = None
    return longest


def figures_of_some(drives):
    pairs = pairs_of(drives)
    rows = [row for drive in drives for row in drive.rows]
    bins = reliability(pairs)
    return {
        "drives": len(drives),
        "scans": len(pairs),
        "bins": bins,
        "right": mean([float(right) for _, right in pairs]),
        "tracking": mean([row["tracking"] for row in rows]),
        "lost": mean([row["lost"] for row in rows]),
        "wrong_tracking": mean([row["tracking"] * (1.0 - row["right"]) for row in rows]),
        "right_lost": mean([row["lost"] * row["right"] for row in rows]),
        "auc": auc(pairs),
        "brier": mean([(p - right) ** 2 for p, right in pairs]),
        "calibration": calibration_error(bins),
        "longest_wrong_m": longest_wrong_m(drives),
    }


def figures_of(drives):
    kinds = {kind: [drive for drive in drives if drive.kind == kind] for kind in KINDS}
    return {
        "all": figures_of_some(drives),
        "places": sorted({place_title(drive.place) for drive in drives}),
        "kinds": {kind: figures_of_some(found) for kind, found in kinds.items() if found},
    }


def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def percent(value, digits=2):
    return "-" if value is None else f"{100 * value:.{digits}f}"


def reliability_table(bins):
    rows = [
        [
            f"{i / BINS:.1f} to {(i + 1) / BINS:.1f}",
            number(found["stated"], 3),
            number(found["right"], 3),
            f"{found['scans']:,}",
        ]
        for i, found in enumerate(bins)
    ]
    return table(["stated probability", "its mean>", "share right>", "scans>"], rows)


def kinds_table(figures):
    rows = []
    for title, found in [
        *[(KINDS[kind].title, found) for kind, found in figures["kinds"].items()],
        ("all", figures["all"]),
    ]:
        rows.append(
            [
                title,
                str(found["drives"]),
                f"{found['scans']:,}",
                percent(found["right"], 1),
                percent(found["tracking"], 1),
                percent(found["lost"], 1),
                percent(found["wrong_tracking"]),
                number(found["longest_wrong_m"], 1),
                percent(found["right_lost"]),
                number(found["auc"], 4),
                number(found["brier"], 4),
                number(found["calibration"], 4),
            ]
        )
    return table(
        [
            "drives",
            "number>",
            "scans>",
            "right [%]>",
            "TRACKING [%]>",
            "LOST [%]>",
            "TRACKING while wrong [%]>",
            "longest [m]>",
            "LOST while right [%]>",
            "AUC>",
            "Brier score>",
            "calibration error>",
        ],
        rows,
    )


def text_of(section, figures):
    whole = figures["all"]
    idle = {
        **section,
        "machine": {**section["machine"], "load": 0.0},
    }  # no times here that a busy machine could spoil
    return "\n".join(
        [
            (
                f"Measured on {whole['drives']} simulated drives of {DURATION_S} s that the weights"
                f" have not seen: {', '.join(figures['places'])}. {provenance(idle)}"
            ),
            "",
            "![Share of right poses over stated probability](images/localization_reliability.svg)",
            "",
            reliability_table(whole["bins"]),
            "",
            (
                f"AUC {whole['auc']:.4f}: so often is a right pose given a higher probability than"
                f" a wrong one. Brier score {whole['brier']:.4f} (mean squared error of the"
                f" probability). Calibration error {whole['calibration']:.4f} (mean distance"
                " between stated probability and share right, over the ten bins)."
            ),
            "",
            kinds_table(figures),
        ]
    )


def picture_of(figures):
    """Reliability curve as SVG; areas of dots go with the number of scans."""
    size, left, top, low = 380, 56, 14, 44
    bins = figures["all"]["bins"]
    most = max(found["scans"] for found in bins)

    def x(p):
        return left + p * size

    def y(p):
        return top + (1 - p) * size

    out = [
        (
            '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0'
            f' {left + size + 20} {top + size + low}" width="{left + size + 20}"'
            f' height="{top + size + low}" font-family="DejaVu Sans, sans-serif" font-size="12"'
            ' role="img" aria-label="Share of right poses over stated probability">'
        ),
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for i in range(0, 11, 2):
        p = i / 10
        out += [
            (
                f'<path d="M{x(p):.1f} {y(0):.1f}V{y(1):.1f}M{x(0):.1f} {y(p):.1f}H{x(1):.1f}"'
                ' stroke="#d8dde5" fill="none"/>'
            ),
            (
                f'<text x="{x(p):.1f}" y="{y(0) + 17:.1f}" text-anchor="middle"'
                f' fill="#5b6675">{p:.1f}</text>'
            ),
            (
                f'<text x="{x(0) - 8:.1f}" y="{y(p) + 4:.1f}" text-anchor="end"'
                f' fill="#5b6675">{p:.1f}</text>'
            ),
        ]
    out += [
        (
            f'<path d="M{x(0):.1f} {y(0):.1f}L{x(1):.1f} {y(1):.1f}" stroke="#5b6675"'
            ' stroke-dasharray="5 4" fill="none"/>'
        ),
        (
            f'<text x="{x(0.5):.1f}" y="{y(0) + 36:.1f}" text-anchor="middle" fill="#1f2937">stated'
            " probability</text>"
        ),
        (
            f'<text transform="translate(14 {y(0.5):.1f}) rotate(-90)" text-anchor="middle"'
            ' fill="#1f2937">share of poses within 0.2 m and 5 deg</text>'
        ),
    ]
    points = [
        (x(found["stated"]), y(found["right"]), 3 + 9 * math.sqrt(found["scans"] / most))
        for found in bins
        if found["scans"]
    ]
    out.append(
        f'<polyline points="{" ".join(f"{a:.1f},{b:.1f}" for a, b, _ in points)}" fill="none"'
        ' stroke="#0072b2" stroke-width="1.6"/>'
    )
    out += [
        f'<circle cx="{a:.1f}" cy="{b:.1f}" r="{r:.1f}" fill="#0072b2" fill-opacity="0.75"/>'
        for a, b, r in points
    ]
    return "\n".join([*out, "</svg>", ""])
