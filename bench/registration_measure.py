"""What is measured of registration: each function returns plain figures for one section of the
tables.

Matchers are programs that read a file of pairs and answer a pose for each (bench/answers.hpp);
everything is scored here, ours and others' alike.
"""
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import time

from program import Failed, run, say

HERE = pathlib.Path(__file__).resolve().parent
BINS = ["0.1 m, 5 deg", "0.2 m, 10 deg", "0.3 m, 20 deg", "0.5 m, 30 deg", "0.8 m, 45 deg"]
SENSORS = [(1081, "1081 beams over 270 deg"), (180, "180 beams over 179 deg")]
CONVERGED_M, CONVERGED_DEG = 0.03, 0.5
AGREE_M, AGREE_DEG = 0.1, 1.0
SEED = 1
NEES_95 = 7.815  # chi squared, 3 degrees of freedom


class Matcher:
    """A program and the name it knows a matcher by."""

    def __init__(self, title, command, name, pairs, ours=False):
        self.title, self.command, self.name, self.pairs, self.ours = (
            title,
            command,
            name,
            pairs,
            ours,
        )

    def answers(self, pairs_file, count, limit_s=240):
        """A list of (pair, x, y, yaw, converged, ms, covariance...)."""
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        result = subprocess.run(
            [*self.command, str(pairs_file), self.name, str(count)],
            capture_output=True,
            text=True,
            env=environment,
            timeout=limit_s,
            check=False,
        )
        if result.returncode != 0:
            raise Failed(f"{self.title}: ended with {result.returncode}\n{result.stderr[-500:]}")
        return [[float(word) for word in line.split()] for line in result.stdout.splitlines()]


def names_in(command):
    """The matchers that a program knows."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


OURS = [
    ("match_scans", "**Loopstone match_scans**", 1000),
    ("match_correlative", "Loopstone match_correlative", 200),
    ("icp_line", "Loopstone ICP, line", 200),
    ("icp_plane", "Loopstone ICP, plane", 1000),
    ("icp_gicp", "Loopstone ICP, gicp", 200),
    ("icp_point", "Loopstone ICP, point", 200),
]


def our_matchers(programs):
    program = [str(programs / "measure_matchers")]
    known = names_in(program)
    return [
        Matcher(title, program, name, pairs, ours=True)
        for name, title, pairs in OURS
        if name in known
    ]


def peer_matchers(folder):
    """The peers that are installed, and the names of those that are not."""
    python = folder / "python"
    programs = [
        (
            "small_gicp",
            [str(folder / "small_gicp_matchers")],
            [
                ("gicp_k5", "small_gicp GICP, k 5", 200),
                ("gicp_k10", "small_gicp GICP, k 10", 200),
                ("plane_icp", "small_gicp point to plane, k 5", 200),
                ("icp", "small_gicp ICP", 200),
            ],
        ),
        (
            "PCL",
            [str(folder / "pcl_matchers")],
            [("gicp", "PCL GICP, k 10", 100), ("icp_2d", "PCL ICP 2D", 100)],
        ),
        (
            "Open3D",
            [str(python), str(HERE / "peers/open3d_matchers.py")],
            [
                ("generalized", "Open3D generalized ICP", 100),
                ("point_to_plane", "Open3D point to plane", 100),
                ("point_to_point", "Open3D point to point", 100),
            ],
        ),
    ]
    found, versions, missing = [], [], []
    for peer, command, matchers in programs:
        version = version_of(peer, folder, python)
        if version is None:
            missing.append(peer)
            continue
        versions.append(version)
        found += [Matcher(title, command, name, pairs) for name, title, pairs in matchers]
    return found, versions, missing


def version_of(peer, folder, python):
    if peer == "Open3D":
        command = [str(python), "-c", "import open3d; print('Open3D', open3d.__version__)"]
        if not python.exists():
            return None
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        return (
            result.stdout.split("\n")[-2]
            if result.returncode == 0 and "Open3D" in result.stdout
            else None
        )
    stem = {"small_gicp": "small_gicp_matchers", "PCL": "pcl_matchers"}[peer]
    note = folder / f"{stem}.version"
    return note.read_text().strip() if note.exists() and os.access(folder / stem, os.X_OK) else None


def read_poses(path):
    """(truth, guess) of every pair of a file; see bench/pairs_file.hpp."""
    import array

    numbers = array.array("d")
    numbers.frombytes(pathlib.Path(path).read_bytes())
    poses, at = [], 1
    for _ in range(int(numbers[0])):
        poses.append((tuple(numbers[at : at + 3]), tuple(numbers[at + 3 : at + 6])))
        at += 6
        for _ in range(2):
            at += 4 + int(numbers[at])
    return poses


def wrapped(angle):
    return math.remainder(angle, 2.0 * math.pi)


def quantile(values, share):
    values = sorted(values)
    return values[int(share * (len(values) - 1))] if values else None


def errors_of(answer, truth):
    """Error (dx, dy, dyaw), its length [m] and turn [deg]."""
    dx, dy, turn = answer[1] - truth[0], answer[2] - truth[1], wrapped(answer[3] - truth[2])
    return (dx, dy, turn), math.hypot(dx, dy), math.degrees(abs(turn))


def score(answers, poses, limit_m, limit_deg):
    """Figures of a matcher on one file of pairs."""
    good_m, good_deg, called_good, wrong_called_good = [], [], 0, 0
    for answer in answers:
        _, metres, degrees = errors_of(answer, poses[int(answer[0])][0])
        good = metres <= limit_m and degrees <= limit_deg  # a NaN is no good
        if good:
            good_m.append(metres)
            good_deg.append(degrees)
        called_good += answer[4] > 0
        wrong_called_good += answer[4] > 0 and not good
    return {
        "pairs": len(answers),
        "good": len(good_m),
        "share": len(good_m) / max(1, len(answers)),
        "median_mm": milli(quantile(good_m, 0.5)),
        "p95_mm": milli(quantile(good_m, 0.95)),
        "median_deg": quantile(good_deg, 0.5),
        "p95_deg": quantile(good_deg, 0.95),
        "median_ms": quantile([answer[5] for answer in answers], 0.5),
        "p95_ms": quantile([answer[5] for answer in answers], 0.95),
        "called_good": called_good,
        "wrong_called_good": wrong_called_good,
    }


def milli(value):
    return None if value is None else 1e3 * value


def solve3(c, e):
    """e^T C^-1 e for a symmetric 3 x 3 matrix given by its upper triangle; nothing when it isn't
    positive."""
    xx, xy, xt, yy, yt, tt = c
    a, b, d = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy
    determinant = xx * a + xy * b + xt * d
    if not determinant > 0.0:
        return None
    f, g, h = xx * tt - xt * xt, xy * xt - xx * yt, xx * yy - xy * xy
    x, y, t = e
    return (
        a * x * x + f * y * y + h * t * t + 2.0 * (b * x * y + d * x * t + g * y * t)
    ) / determinant


def nees(answers, poses):
    """How honest covariances are: over answers that are right, and the share inside of all called
    converged."""
    values, inside, called = [], 0, 0
    for answer in answers:
        if answer[4] <= 0 or len(answer) < 12:
            continue
        error, metres, degrees = errors_of(answer, poses[int(answer[0])][0])
        value = solve3(answer[6:12], error)
        called += 1
        inside += value is not None and value <= NEES_95
        if value is not None and metres <= CONVERGED_M and degrees <= CONVERGED_DEG:
            values.append(value)
    if not values:
        return None
    return {
        "pairs": len(values),
        "mean": statistics.fmean(values),
        "median": quantile(values, 0.5),
        "called": called,
        "inside_95": inside / called,
    }


def pairs_file(programs, work, beams, number, count):
    path = work / f"pairs-{beams}-{number}-{count}.pairs"
    if (
        not path.exists()
        or path.stat().st_mtime < (programs / "measure_make_pairs").stat().st_mtime
    ):
        run([programs / "measure_make_pairs", path, beams, number, count, SEED])
    return path


def answers_or_none(matcher, path, count, seconds=240):
    try:
        return matcher.answers(path, count, seconds)
    except (Failed, subprocess.TimeoutExpired, OSError) as failure:
        say(f"    {matcher.title}: FAILED: {failure}")
        return None


def synthetic(programs, work, peers, quick):
    """Pairs of scans in random rooms; identity guess."""
    scale = 0.1 if quick else 1.0
    sensors = []
    for beams, title in SENSORS:
        rows = []
        files = [
            pairs_file(programs, work, beams, number, int(1000 * scale))
            for number in range(len(BINS))
        ]
        truths = [read_poses(path) for path in files]
        for matcher in [*our_matchers(programs), *peers]:
            row = {"title": matcher.title, "name": matcher.name, "ours": matcher.ours, "bins": []}
            for path, poses in zip(files, truths):
                answers = answers_or_none(matcher, path, max(20, int(matcher.pairs * scale)))
                if answers is None:
                    break
                row["bins"].append(score(answers, poses, CONVERGED_M, CONVERGED_DEG))
            if len(row["bins"]) == len(files):
                rows.append(row)
                say(
                    f"  {beams}: {matcher.title}: "
                    + " ".join(f"{100 * figures['share']:.1f}" for figures in row["bins"])
                    + f" %, {row['bins'][0]['median_ms']:.3f} to"
                    f" {row['bins'][-1]['median_ms']:.3f} ms"
                )
        sensors.append({"beams": beams, "title": title, "rows": rows})
    return sensors


NEES_MATCHERS = [
    ("match_scans", "match_scans", [0, 4]),
    ("icp_plane", "match_icp, plane", [0]),
    ("icp_gicp", "match_icp, gicp", [0]),
    ("match_to_grid", "match_to_grid (one scan as the grid)", [0]),
    ("match_correlative", "match_correlative", [0]),
]


def consistency(programs, work, peers, quick):
    """Normalised estimation error squared of our covariances."""
    del peers
    rows = []
    program = [str(programs / "measure_matchers")]
    known = names_in(program)
    count = 100 if quick else 1000
    for beams, sensor in SENSORS:
        for name, title, numbers in NEES_MATCHERS:
            for number in numbers if name in known else []:
                path = pairs_file(programs, work, beams, number, count)
                answers = answers_or_none(Matcher(title, program, name, count), path, count)
                figures = nees(answers, read_poses(path)) if answers else None
                if figures:
                    say(
                        f"  {sensor}, {BINS[number]}: {title}: mean NEES {figures['mean']:.2f}, "
                        f"{100 * figures['inside_95']:.1f} % inside"
                    )
                    rows.append({"sensor": sensor, "bin": BINS[number], "title": title, **figures})
    return rows


LOGS = [
    ("intel", "Intel Research Lab", True),
    ("aces", "ACES building", True),
    ("mit-csail", "MIT CSAIL", False),
]
WHOLE_MAP = (  # no guess to match from: how well the map keeps the relations, for comparison
    "the whole log's map"
)
REAL = ["match_scans", "icp_plane"]
REAL_PEERS = ["small_gicp GICP, k 5", "PCL GICP, k 10", "Open3D generalized ICP"]


def real_cases(name, log, loopstone, has_odometry, data):
    """(title, kind of reference, reference, seconds) of the pairs that a log gives, and its
    guesses."""
    folder, _, _ = loopstone.map(log, "registration-" + name)
    trajectory = folder / "trajectory.tum"
    cases = []
    relations = data / "carmen" / f"{name}.relations"
    if relations.exists():
        cases.append(("joined by a relation, at most 1.5 s apart", "relations", relations, 1.5))
    cases += [
        ("consecutive", "trajectory", trajectory, 0.0),
        ("one second apart", "trajectory", trajectory, 1.0),
    ]
    guesses = [("identity", "identity")]
    if relations.exists():
        guesses.append((WHOLE_MAP, trajectory))
    if has_odometry:
        path = loopstone.work / f"registration-{name}-odometry.tum"
        run([loopstone.program, "odometry", log, "-o", path, "--force", "--quiet"])
        guesses.append(("odometry", path))
    return cases, guesses


def recorded(programs, work, peers, quick, loopstone, data):
    """Scans of recorded logs, against relations and against the trajectory of the whole map."""
    count = 100 if quick else 1000
    matchers = [matcher for matcher in our_matchers(programs) if matcher.name in REAL]
    matchers += [peer for peer in peers if peer.title in REAL_PEERS]
    logs = []
    for name, title, has_odometry in LOGS:
        log = data / "carmen" / f"{name}.clf"
        if not log.exists():
            say(f"  {log}: not there, skipped")
            continue
        cases, guesses = real_cases(name, log, loopstone, has_odometry, data)
        rows = []
        for case, kind, reference, seconds in cases:
            for guess_title, guess in guesses:
                only_guess = guess_title == WHOLE_MAP
                if only_guess and kind != "relations":
                    continue
                path = work / "log.pairs"
                output, _ = run(
                    [
                        programs / "measure_log_pairs",
                        path,
                        log,
                        kind,
                        reference,
                        seconds,
                        guess,
                        count,
                    ]
                )
                pairs, metres, degrees = output.split()
                poses = read_poses(path)
                untouched = [[i, *pair[1], 1, 0.0] for i, pair in enumerate(poses)]
                row = {
                    "case": case,
                    "reference": kind,
                    "guess": guess_title,
                    "pairs": int(pairs),
                    "motion_m": float(metres),
                    "motion_deg": float(degrees),
                    "matchers": [
                        {"title": "the guess itself", **score(untouched, poses, AGREE_M, AGREE_DEG)}
                    ],
                }
                for matcher in [] if only_guess else matchers:
                    answers = answers_or_none(matcher, path, count)
                    if answers:
                        row["matchers"].append(
                            {"title": matcher.title, **score(answers, poses, AGREE_M, AGREE_DEG)}
                        )
                say(
                    f"  {title}, {case}, from {guess_title}: "
                    + ", ".join(
                        f"{figures['title']} {100 * figures['share']:.1f} %"
                        for figures in row["matchers"]
                    )
                )
                rows.append(row)
                path.unlink()
        logs.append({"title": title, "rows": rows})
    return logs


def tracking(programs, quick):
    output, _ = run([programs / "measure_tracking", 200 if quick else 1000])
    figures = json.loads(output)
    say(
        f"  {figures['match_ms']['median']:.3f} ms, surfaces"
        f" {figures['surfaces_ms']['median']:.3f} ms"
    )
    return figures


def program_rows(programs, work, name, arguments):
    """The figures that another program writes as JSON; nothing when there is no such program."""
    program = programs / name
    if not os.access(program, os.X_OK):
        say(f"  {program}: not there, skipped")
        return None
    output = work / f"{name}.json"
    run([program, "--json", output, *arguments])
    return json.loads(output.read_text())["rows"]


def map_match(programs, work, quick):
    rows = program_rows(programs, work, "bench_map_match", ["--trials", 20 if quick else 500])
    for row in rows or []:
        say(f"  {row['name']}: {100 * row['best_correct_share']:.2f} %, {row['median_ms']:.0f} ms")
    return rows


def correlative(programs, work, quick):
    """Google Benchmark's medians of the searches."""
    program = programs / "bench_correlative"
    if not os.access(program, os.X_OK):
        say(f"  {program}: not there, skipped")
        return None
    output = work / "bench_correlative.json"
    repetitions = 1 if quick else 3
    run(
        [
            program,
            f"--benchmark_out={output}",
            "--benchmark_out_format=json",
            f"--benchmark_repetitions={repetitions}",
        ]
    )
    times = {}
    unit_ms = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}
    for row in json.loads(output.read_text())["benchmarks"]:
        if row.get("run_type", "iteration") == "iteration":
            times.setdefault(row.get("run_name", row["name"]), []).append(
                row["cpu_time"] * unit_ms[row["time_unit"]]
            )
    return [{"name": name, "ms": statistics.median(values)} for name, values in times.items()]


def clouds(programs, work, peers_folder, data, quick):
    folder = data / "ucsd/icp_warm_up"
    rows = program_rows(
        programs, work, "bench_cloud_match", ["--data", folder, "--seeds", 3 if quick else 20]
    )
    if not rows:
        return None
    peers = []
    python = peers_folder / "python"
    if python.exists() and folder.exists():
        started = time.monotonic()
        command = [
            str(python),
            str(HERE / "peers/cloud_peers.py"),
            str(folder),
            *(["--quick"] if quick else []),
        ]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode == 0:
            peers = json.loads(result.stdout)
            say(f"  peers took {time.monotonic() - started:.0f} s")
        else:
            say(f"  peers: FAILED\n{result.stderr[-500:]}")
    return {"rows": rows, "peers": peers}


if __name__ == "__main__":
    sys.exit("run bench/registration.py")
