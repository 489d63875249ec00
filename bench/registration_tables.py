"""From measured figures of registration to Markdown. Nothing is measured here, and no figure is typed here but the targets."""
import tables
from doc_blocks import table
from registration_measure import BINS

SHARE = 0.999
ERROR_MM, ERROR_DEG = 1.4, 0.016
TIME_MS = {1081: 0.5, 180: 0.1}
TRACK_MS = 0.1
MAP_SHARE, MAP_MS = 0.998, 1000.0


def provenance(section):
    text = tables.provenance(section)
    if section["peers"]:
        text += f" Peers in the same run: {', '.join(section['peers'])}."
    if section["missing"]:
        text += f" Not installed, so not compared: {', '.join(section['missing'])}."
    return text


def series(bins, key, digits, factor=1.0):
    values = [figures[key] for figures in bins]
    return " / ".join("-" if value is None else f"{factor * value:.{digits}f}" for value in values)


def times(bins):
    low, high = bins[0]["median_ms"], bins[-1]["median_ms"]
    digits = 2 if high < 1.0 else 1
    return f"{low:.{digits}f} / {high:.{digits}f}"


def pairs_tables(section):
    parts = [provenance(section), "", "Bins: " + "; ".join(BINS) + "."]
    for sensor in section["figures"]:
        rows, errors = [], []
        for row in sensor["rows"]:
            bins = row["bins"]
            rows.append([row["title"], str(bins[0]["pairs"])] + [f"{100 * figures['share']:.1f}" for figures in bins]
                        + [times(bins)])
            errors.append([row["title"], series(bins, "median_mm", 1), series(bins, "p95_mm", 1),
                           series(bins, "median_deg", 3), series(bins, "p95_deg", 3), series(bins, "median_ms", 2)])
        parts += ["", f"**{sensor['title']}**: share converged [%], and the median CPU time of a call in the first and in the last bin.",
                  "", table(["matcher", "pairs a bin>", *[name + ">" for name in BINS], "time, first / last bin [ms]>"], rows),
                  "", "Of those that converged, bin by bin; and the median time.", "",
                  table(["matcher", "median [mm]", "95 % [mm]", "median [deg]", "95 % [deg]", "median time [ms]"], errors)]
    parts += ["", tables.targets_table(targets_of_pairs(section["figures"]))]
    return "\n".join(parts)


def targets_of_pairs(sensors):
    rows = []
    for sensor in sensors:
        ours = [row for row in sensor["rows"] if row["name"] == "match_scans"]
        if not ours:
            continue
        bins, beams = ours[0]["bins"], sensor["beams"]
        worst = min(figures["share"] for figures in bins)
        mm = max(figures["median_mm"] or float("inf") for figures in bins)
        degrees = max(figures["median_deg"] or float("inf") for figures in bins)
        ms = max(figures["median_ms"] for figures in bins)
        rows += [(f"{beams} beams: share converged in the worst bin", f">= {100 * SHARE:.1f} %", f"{100 * worst:.2f} %", worst >= SHARE),
                 (f"{beams} beams: median error in the worst bin", f"<= {ERROR_MM} mm", f"{mm:.2f} mm", mm <= ERROR_MM),
                 (f"{beams} beams: median error in the worst bin, turn", f"<= {ERROR_DEG} deg", f"{degrees:.3f} deg",
                  degrees <= ERROR_DEG),
                 (f"{beams} beams: median time in the worst bin", f"<= {TIME_MS[beams]} ms", f"{ms:.3f} ms",
                  ms <= TIME_MS[beams])]
    return rows


def nees_table(section):
    rows = [[row["title"], row["sensor"], row["bin"], str(row["pairs"]), f"{row['mean'] / 3.0:.2f}", f"{row['median'] / 2.366:.2f}",
             f"{100 * row['inside_95']:.1f} % of {row['called']}"] for row in section["figures"]]
    return "\n".join([
        provenance(section), "",
        "Mean NEES is e^T C^-1 e / 3 over the matches within 3 cm and 0.5 deg (3 degrees of freedom: 1 is ideal, more is overconfident);"
        " the median likewise, over the median of chi squared. Inside: of all matches called converged, wrong ones too, those in"
        " the 95 % ellipsoid.", "",
        table(["matcher", "scanner", "poses differ by up to", "pairs>", "mean NEES / 3>", "median>", "inside 95 %>"], rows)])


def real_tables(section):
    parts = [provenance(section)]
    for log in section["figures"]:
        rows = []
        for row in log["rows"]:
            for figures in row["matchers"]:
                ms = f"{figures['median_ms']:.2f}" if figures["median_ms"] else ""
                rows.append([row["case"], row["reference"], row["guess"], str(figures["pairs"]), figures["title"],
                             f"{100 * figures['share']:.1f}", none_or(figures["median_mm"], 1), none_or(figures["median_deg"], 2), ms])
        parts += ["", f"**{log['title']}**", "",
                  table(["scans", "reference", "guess", "pairs>", "matcher", "agree [%]>", "median [mm]>", "median [deg]>", "time [ms]>"],
                        rows)]
    return "\n".join(parts)


def none_or(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def tracking_table(section):
    figures = section["figures"]
    rows = [[name, f"{figures[key]['median']:.{digits}f}", f"{figures[key]['p95']:.{digits}f}"]
            for name, key, digits in [("match_to_grid [ms]", "match_ms", 3), ("surfaces of the scan [ms]", "surfaces_ms", 3),
                                      ("error [mm]", "error_mm", 2), ("error [deg]", "error_deg", 3)]]
    return "\n".join([provenance({**section, "peers": [], "missing": []}), "",
                      f"{figures['scans']} scans of {figures['beams']} beams.", "", table(["", "median>", "95 %>"], rows), "",
                      tables.targets_table(targets_of_tracking(figures))])


def targets_of_tracking(figures):
    ms = figures["match_ms"]["median"]
    return [("tracking on a submap's grid: median CPU time", f"<= {TRACK_MS} ms", f"{ms:.3f} ms", ms <= TRACK_MS)]


def map_match_table(section):
    rows = [[row["name"], str(row["trials"]), percent(row["best_correct_share"]), percent(row["sure_share"]),
             percent(row["wrong_called_sure"]), f"{row['median_ms']:.1f}", f"{row['max_ms']:.1f}",
             f"{row['area_m2']:.0f}", f"{row['build_ms']:.0f}", f"{row['memory_mb']:.1f}"] for row in section["figures"]]
    return "\n".join([provenance({**section, "peers": [], "missing": []}), "",
                      table(["", "trials>", "best is right [%]>", "called sure [%]>", "wrong and called sure [%]>", "median [ms]>",
                             "longest [ms]>", "floor [m2]>", "preparing the map [ms]>", "memory [MB]>"], rows), "",
                      tables.targets_table(targets_of_map_match(section["figures"]))])


def percent(share):
    return f"{100 * share:.1f}"


def targets_of_map_match(rows):
    found = []
    for row in rows:
        if not row["name"].startswith("campus"):  # the map of 10,000 m2
            continue
        found += [(f"{row['name']}: best is right", f">= {100 * MAP_SHARE:.1f} %", f"{100 * row['best_correct_share']:.2f} %",
                   row["best_correct_share"] >= MAP_SHARE),
                  (f"{row['name']}: longest time on one core", f"<= {MAP_MS:.0f} ms", f"{row['max_ms']:.0f} ms",
                   row["max_ms"] <= MAP_MS)]
    return found


def correlative_table(section):
    rows = [[f"`{row['name']}`", f"{row['ms']:.3f}"] for row in section["figures"]]
    return "\n".join([provenance({**section, "peers": [], "missing": []}), "", table(["search", "CPU time [ms]>"], rows), "",
                      tables.targets_table(targets_of_correlative(section["figures"]))])


# A benchmark whose name has all the words must take no longer than this.
CORRELATIVE = [(("0.5", "20"), 2.0, "window of 0.5 m and 20 deg"), (("4", "90"), 20.0, "window of 4 m and 90 deg")]


def targets_of_correlative(rows):
    found = []
    for words, limit_ms, title in CORRELATIVE:
        of_window = [row["ms"] for row in rows if all(word in row["name"] for word in words)]
        if of_window:
            found.append((f"correlative search, {title}: slowest of {len(of_window)}", f"<= {limit_ms:.0f} ms",
                          f"{max(of_window):.2f} ms", max(of_window) <= limit_ms))
    return found


def clouds_table(section):
    ours, peers = section["figures"]["rows"], section["figures"]["peers"]
    names = list(dict.fromkeys(row["peer"] for row in peers))
    rows = []
    for row in ours:
        cells = [row["name"], f"{row['reference_mm']:.3f}", f"{row['rmse_mm']:.3f}", f"{row['worst_rmse_mm']:.3f} of {row['seeds']}",
                 f"{row['agreeing']} of {row['finalists']}", f"{row['ms']:.0f}"]
        for name in names:
            found = [peer for peer in peers if peer["name"] == row["name"] and peer["peer"] == name]
            cells.append(f"{found[0]['rmse_mm']:.3f} ({found[0]['near_best']} of {found[0]['starts']}; {found[0]['ms']:.0f} ms)"
                         if found else "")
        rows.append(cells)
    return "\n".join([
        provenance(section), "",
        table(["cloud", "reference [mm]>", "Loopstone [mm]>", "worst of the seeds [mm]>", "starts that agree>", "time [ms]>", *[name + " [mm]>" for name in names]], rows), "",
        tables.targets_table(targets_of_clouds(section["figures"]))])


def targets_of_clouds(figures):
    # To the micrometre, as the reference was written down.
    found = [(f"{row['name']}: rmse, worst of {row['seeds']} seeds", f"<= {row['reference_mm']:.3f} mm",
              f"{row['worst_rmse_mm']:.3f} mm", round(row["worst_rmse_mm"], 3) <= row["reference_mm"]) for row in figures["rows"]]
    peers_ms = sum(row["ms"] for row in figures["peers"] if row["peer"] == "small_gicp GICP")
    if peers_ms > 0:
        ours_ms = sum(row["ms"] for row in figures["rows"])
        found.append(("all clouds: small_gicp's 36 starts take longer by a factor of", ">= 5", f"{peers_ms / ours_ms:.1f}",
                      peers_ms >= 5.0 * ours_ms))
    return found


BLOCKS = {"pairs": [("docs/benchmarks.md", "registration-pairs", pairs_tables)],
          "nees": [("docs/accuracy.md", "registration-nees", nees_table)],
          "real": [("docs/accuracy.md", "registration-real", real_tables)],
          "tracking": [("docs/benchmarks.md", "registration-tracking", tracking_table)],
          "map_match": [("docs/benchmarks.md", "registration-map", map_match_table)],
          "correlative": [("docs/benchmarks.md", "registration-correlative", correlative_table)],
          "clouds": [("docs/benchmarks.md", "registration-clouds", clouds_table)]}
TARGETS = {"pairs": targets_of_pairs, "tracking": targets_of_tracking, "map_match": targets_of_map_match,
           "correlative": targets_of_correlative, "clouds": targets_of_clouds}


def blocks_of(sections):
    """(page, block, text) of everything that the measured sections say."""
    return [(page, block, write(sections[name])) for name, blocks in BLOCKS.items() if name in sections
            for page, block, write in blocks]


def summary(sections):
    rows = [row for name, of_section in TARGETS.items() if name in sections
            for row in of_section(sections[name]["figures"])]
    return "\n".join(f"{'met    ' if met else 'NOT MET'}  {measured:>10}  {target:<24} {name}"
                     for name, target, measured, met in rows)
