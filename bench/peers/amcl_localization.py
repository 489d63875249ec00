"""nav2's AMCL (PyPI: amcl, GPL-3) in a process of its own: amcl_localizer.cpp, which
install_localization.sh builds."""
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "build/bench/peers/amcl_localizer"


def is_here():
    return PROGRAM.exists()


def write_cells(cells, path):
    head = [cells.width, cells.height, cells.resolution_m, cells.x_m, cells.y_m]
    path.write_bytes(" ".join(map(str, head)).encode() + b"\n" + cells.states)


def write_feed(feed, path):
    with open(path, "w", encoding="utf-8") as file:
        print("laser", *feed.robot_T_laser, file=file)
        for scan in feed.scans:
            head = [*scan.odom_T_robot, scan.range_max_m, scan.angle_rad, scan.step_rad]
            ranges = " ".join(f"{range_m:g}" for range_m in scan.ranges_m)
            numbers = " ".join(f"{number:.9g}" for number in head)
            print(scan.stamp, numbers, len(scan.ranges_m), ranges, file=file)


class Amcl:
    """Writes the files once (not counted); then follows the robot as often as asked."""

    def __init__(self, feed):
        self.cells, self.feed = feed.work / "amcl.cells", feed.work / "amcl.feed"
        write_cells(feed.cells, self.cells)
        write_feed(feed, self.feed)

    def localize(self, run, settings, start, seed):
        """Start: (x, y, yaw, sigma_m, sigma_rad), or None. Returns (stamp, x, y, yaw, spread) for
        each scan, and what the process took."""
        words = [f"{key}={value}" for key, value in {**settings, "seed": seed}.items()]
        if start:
            words.append("start=" + ",".join(f"{value:.6f}" for value in start))
        output, cost = run([PROGRAM, self.cells, self.feed, *words])
        rows = []
        for line in output.splitlines():
            stamp, *numbers = line.split()
            x, y, yaw, xx, yy, yawyaw = map(float, numbers)
            rows.append((stamp, x, y, yaw, max(xx + yy + yawyaw, 0.0) ** 0.5))
        return rows, cost
