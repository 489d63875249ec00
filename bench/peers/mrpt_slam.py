"""MRPT's icp-slam (Debian: mrpt-apps, mrpt-common) on a CARMEN log, with the configuration that its
package brings for it; only its window and its scene files are switched off, so that it spends its
time on mapping."""
import pathlib
import re
import shutil

from program import run

STOCK = pathlib.Path("/usr/share/mrpt/config_files/icp-slam/icp-slam_demo_classic.ini")
OFF = {"SHOW_PROGRESS_3D_REAL_TIME": "false", "SAVE_3D_SCENE": "0"}


def is_here():
    return STOCK.exists() and all(shutil.which(name) for name in ("carmen2rawlog", "icp-slam"))


class IcpSlam:
    """Converts the log once (not counted), then maps it as often as asked."""

    def __init__(self, log, work):
        self.work = work / "mrpt"
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)
        self.run("carmen2rawlog", "-i", log.resolve(), "-o", "log.rawlog", "-w")
        text = STOCK.read_text()
        for key, value in {**OFF, "rawlog_file": "log.rawlog", "logOutput_dir": "out"}.items():
            text = re.sub(rf"(?m)^\s*{key}\s*=.*$", f"{key}={value}", text)
        (self.work / "icp-slam.ini").write_text(text)

    def run(self, *words):
        """They talk without end, which nobody reads."""
        return run(["sh", "-c", 'exec "$@" >/dev/null 2>&1', "sh", *words], folder=self.work)[1]

    def map(self):
        """Wall, CPU and memory of one run; an error when it wrote no map."""
        cost = self.run("icp-slam", "icp-slam.ini", "log.rawlog")
        if not (self.work / "out/_finalmap_.simplemap").exists():
            raise RuntimeError("icp-slam wrote no map")
        return cost
