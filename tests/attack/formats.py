"""Every format that the program reads: which fuzz target takes it, its seeds, how it is spoiled,
and the commands that it is given to. {in} is the spoiled file, {out} a name that is free; {log},
{map}, {truth}, {cloud} (in the plane) and {space} (a cloud in space) are good files."""

import pathlib
from dataclasses import dataclass, field

import bombs
import bombs_of_text
from mutate import TEXT, spoil
from wraps import Bzip2, Gzip, HeadAndBody, Mat, Npy, Npz, Png, Session, Tiff, spoil_packed

LOG = [
    "info {in} --json",
    "map {in} -o {out} --threads 1",
    "odometry {in} -o {out}.tum",
    "convert {in} {out}.clf.gz",
    "localize {in} --map {map} -o {out}.tum --global --threads 1",
    "match {in}#0 {in}#2 --json",
    "convert {in} {out}#20",
    "match {in}@+1 {map} --global",
    "map {in} -o {out} --odometry ignore --strict",
    "map {in} -o {out} --pipeline scan_to_scan",
]
GRAPH = [
    "optimize {in} --json",
    "optimize {in} -o {out}.g2o --certify",
    "optimize {in} --robust gnc --edges {out}.csv",
    "optimize {in} --picture {out}.png --tum {out}.tum",
    "optimize {in} --initial spanning_tree --method dogleg --report {out}.html",
]
CLOUD = [
    "match {in} {cloud} --json",
    "match {cloud} {in} --global --json",
    "match {in} {in} --method gicp --aligned {out}.ply",
    "match {in} {space} --json",
    "match {space} {in} --global",
    "match {in} {cloud} --png {out}.png",
    "match {in} {cloud} --source-scale 1e9 --sweep-yaw 3",
    "match {in} {cloud} --method icp_point --initial centroids",
]
MAP = [
    "match {log}#0 {in} --global --json",
    "localize {log} --map {in} -o {out}.tum --global --threads 1",
    "evaluate --map {in} --true-map {map} --json",
    "simulate {in} -o {out} --duration 1 --beams 20",
    "match {log}#1 {in} --initial 3,3,0 --png {out}.png",
]
DEPTH = ["info {in} --json", "texture {in} --trajectory {truth} -o {out}"]


@dataclass
class Format:
    name: str
    target: str  # fuzz/fuzz_<target>.cpp
    seeds: list  # globs below fuzz/corpus and below the folder of what the program made
    suffix: str
    wrap: object = None
    commands: list = field(default_factory=list)
    bombs: object = staticmethod(lambda: [])
    #: The name of the log format that it is, or is a file of.
    log: str = ""
    #: Puts the file where the program looks for it; gives the argument {in}.
    place: object = staticmethod(
        lambda folder, data, suffix, seed, good: put(folder / ("input" + suffix), data)
    )

    def spoiled(self, data, rng, donor):
        if self.wrap is None:
            return spoil(data, rng, donor, TEXT)
        try:
            return spoil_packed(data, rng, donor, self.wrap)
        except Exception:  # the seed itself is damaged: nothing can be taken out of it
            return spoil(data, rng, donor, TEXT)


def put(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def beside_a_map(folder, data, suffix, _seed, good):
    put(folder / ("input" + suffix), data)
    text = (good / "sim" / "map.yaml").read_text().replace("map.pgm", "input" + suffix)
    return put(folder / "input.yaml", text.encode())


def beside_a_picture(folder, data, _suffix, _seed, good):
    put(folder / "map.pgm", (good / "sim" / "map.pgm").read_bytes())
    return put(folder / "input.yaml", data)


def in_a_folder(folder, data, _suffix, seed, good):
    for path in (good / "sim").glob("*20.npz"):
        put(folder / "input" / path.name, path.read_bytes())
    put(folder / "input" / ((seed if seed.endswith("20") else "Hokuyo20") + ".npz"), data)
    return folder / "input"


def as_a_picture(folder, data, suffix, _seed, good):
    """The first depth picture of a recording."""
    source = good / "rgbd"
    pictures = sorted(path.relative_to(source) for path in source.glob("dataRGBD/*/*"))
    depth = next(path for path in pictures if "isparity" in str(path))
    for path in [*(path.relative_to(source) for path in source.glob("*20.npz")), *pictures]:
        if path == depth:
            put(folder / "input" / path, data)
        elif path.suffix == ".npz" or path.parts[1] != depth.parts[1] or path == pictures[1]:
            (folder / "input" / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / "input" / path).symlink_to(source / path)
    return folder / "input"


def beside_a_drive(folder, data, _suffix, _seed, _good):
    """Landmarks in the folder of a drive among them, as MRCLAM has it."""
    put(folder / "input" / "landmarks.csv", data)
    put(folder / "input" / "Barcodes.dat", b"6 72\n7 27\n")
    put(folder / "input" / "Robot1_Odometry.dat", b"10 0.1 0.1\n11 0.1 0.1\n12 0 0\n")
    seen = b"10.1 72 3 0.1\n10.1 27 4 1\n11 72 3 0.2\n11.5 27 4 1.1\n"
    put(folder / "input" / "Robot1_Measurement.dat", seen)
    return folder / "input"


def in_an_output(folder, data, _suffix, _seed, _good):
    put(folder / "input" / "session.loopstone", data)
    return folder / "input"


FORMATS = [
    Format(
        "carmen",
        "carmen",
        ["carmen/*.clf", "simulated/*.clf"],
        ".clf",
        None,
        LOG,
        bombs_of_text.carmen,
        log="carmen",
    ),
    Format(
        "carmen_gz",
        "carmen",
        ["carmen/*.gz", "simulated/*.clf.gz"],
        ".clf.gz",
        Gzip(),
        LOG,
        bombs_of_text.carmen_gz,
        log="carmen",
    ),
    Format(
        "carmen_bz2",
        "carmen",
        ["carmen/*.bz2", "simulated/*.clf.bz2"],
        ".clf.bz2",
        Bzip2(),
        LOG,
        bombs_of_text.carmen_bz2,
        log="carmen",
    ),
    Format(
        "rawlog", "rawlog", ["rawlog/*.rawlog"], ".rawlog", Gzip(), LOG, bombs.rawlog, log="rawlog"
    ),
    Format(
        "npz",
        "npz",
        ["npz/*", "simulated/*.npz"],
        ".npz",
        Npz(),
        [
            "info {in} --json",
            "map {in} -o {out} --threads 1",
            "odometry {in} -o {out}.tum",
            "convert {in} {out}.clf",
            "match {in}#0 {in}#1",
        ],
        bombs.npz,
        log="ucsd",
        place=in_a_folder,
    ),
    Format("g2o", "g2o", ["g2o/*", "simulated/*.g2o"], ".g2o", None, GRAPH, bombs_of_text.graph),
    Format("toro", "toro", ["toro/*"], ".graph", None, GRAPH, bombs_of_text.graph),
    Format(
        "tum",
        "tum",
        ["tum/*", "simulated/*.tum"],
        ".tum",
        None,
        [
            "evaluate --estimate {in} --reference {truth} --json",
            "evaluate --reference {in} --estimate {truth} --rpe 1f",
            "evaluate --estimate {in} --reference {in} --rpe 0.5s --align none",
        ],
        bombs_of_text.text,
    ),
    Format(
        "relations",
        "relations",
        ["relations/*", "simulated/*.relations"],
        ".relations",
        None,
        [
            "evaluate --estimate {truth} --relations {in} --json",
            "evaluate --estimate {truth} --relations {in} --order expected-first",
        ],
        bombs_of_text.text,
    ),
    Format(
        "map_yaml",
        "map_yaml",
        ["map_yaml/*", "simulated/*.map.yaml"],
        ".yaml",
        None,
        MAP,
        bombs_of_text.map_yaml,
        place=beside_a_picture,
    ),
    Format(
        "png",
        "image",
        ["image/*.png", "simulated/room.png"],
        ".png",
        Png(),
        MAP,
        bombs.png,
        place=beside_a_map,
    ),
    Format(
        "pnm",
        "image",
        ["image/*.pgm", "simulated/*.pgm"],
        ".pgm",
        HeadAndBody(rb"\s(255|65535|15)\s"),
        MAP,
        bombs.pnm,
        place=beside_a_map,
    ),
    Format(
        "jpeg",
        "image",
        ["image/*.jpg"],
        ".jpg",
        HeadAndBody(rb"\xff\xda"),
        MAP,
        bombs.jpeg,
        place=beside_a_map,
    ),
    Format(
        "depth_tiff",
        "depth_picture",
        ["depth_picture/*.tiff"],
        ".tif",
        Tiff(),
        DEPTH,
        bombs.tiff,
        place=as_a_picture,
    ),
    Format(
        "depth_pfm",
        "depth_picture",
        ["depth_picture/*.pfm"],
        ".pfm",
        HeadAndBody(rb"-?1(\.0)?\n"),
        DEPTH,
        bombs.pfm,
        place=as_a_picture,
    ),
    Format(
        "depth_png",
        "depth_picture",
        ["depth_picture/*.png", "simulated/*.disparity.png"],
        ".png",
        Png(),
        DEPTH,
        bombs.png,
        place=as_a_picture,
    ),
    Format(
        "bag", "bag", ["bag/*", "simulated/*.bag"], ".bag", HeadAndBody(rb"V2.0\n"), LOG, log="bag"
    ),
    Format(
        "mcap",
        "mcap",
        ["mcap/*", "simulated/*.mcap"],
        ".mcap",
        HeadAndBody(rb"MCAP0\r\n"),
        LOG,
        log="mcap",
    ),
    Format("npy", "npy", ["npy/*"], ".npy", Npy(), [], bombs.npy),
    Format("rosbag2_metadata", "rosbag2_metadata", ["rosbag2_metadata/*"], ".yaml"),
    Format(
        "sqlite_log",
        "sqlite_log",
        ["sqlite_log/*", "simulated/*.db3"],
        ".db3",
        None,
        LOG,
        log="rosbag2",
    ),
    Format(
        "npy_cloud",
        "npy_cloud",
        ["npy_cloud/*", "simulated/*.npy"],
        ".npy",
        Npy(),
        CLOUD,
        bombs.npy,
    ),
    Format("mat", "mat_cloud", ["mat_cloud/*", "simulated/*.mat"], ".mat", Mat(), CLOUD, bombs.mat),
    Format(
        "pcd",
        "pcd",
        ["pcd/*", "simulated/*.pcd"],
        ".pcd",
        HeadAndBody(rb"DATA \w+\n"),
        CLOUD,
        bombs.pcd,
    ),
    Format(
        "ply",
        "ply",
        ["ply/*", "simulated/*.ply"],
        ".ply",
        HeadAndBody(rb"end_header\n"),
        CLOUD,
        bombs.ply,
    ),
    Format(
        "cloud_text",
        "cloud_text",
        ["cloud_text/*", "simulated/cloud.csv"],
        ".csv",
        None,
        CLOUD,
        bombs_of_text.cloud_text,
    ),
    Format(
        "options_toml",
        "options_toml",
        ["options_toml/*options", "simulated/options.toml"],
        ".toml",
        None,
        [
            "config -c {in}",
            "map {log} -o {out} -c {in} --threads 1",
            "odometry {log} -o {out}.tum -c {in}",
            "config -c {in} localize",
        ],
        bombs_of_text.toml,
    ),
    Format(
        "robot_toml",
        "options_toml",
        ["options_toml/robot*", "simulated/robot.toml"],
        ".toml",
        None,
        [
            "odometry {log} -o {out}.tum --robot {in}",
            "map {log} -o {out} --robot {in} --threads 1",
            "simulate {map} -o {out} --robot {in} --duration 1 --beams 20",
            "localize {log} --map {map} -o {out}.tum --robot {in}",
        ],
        bombs_of_text.toml,
    ),
    Format(
        "session",
        "session",
        ["session/*", "simulated/*.loopstone"],
        ".loopstone",
        Session(),
        ["map {log} -o {in} --resume --threads 1"],
        bombs.session,
        place=in_an_output,
    ),
    Format(
        "site",
        "site",
        ["site/*"],
        ".site",
        None,
        ["site check {in}", "site show {in} --ties", "site history {in}"],
    ),
    Format(
        "texture_yaml",
        "texture_yaml",
        ["texture_yaml/*"],
        ".yaml",
        None,
        [],
        bombs_of_text.map_yaml,
    ),
    Format(
        "localization_csv",
        "localization_csv",
        ["localization_csv/*", "simulated/*.localization.csv"],
        ".csv",
        None,
        [],
        bombs_of_text.text,
    ),
    Format(
        "landmarks",
        "landmarks",
        ["landmarks/*.csv"],
        ".csv",
        None,
        ["localize {in} --landmarks {in} -o {out}.tum --global --nameless --report {out}"],
        bombs_of_text.landmarks,
        place=beside_a_drive,
    ),
    Format("mrclam", "mrclam", ["mrclam/*.dat"], ".dat", None, [], bombs_of_text.mrclam),
    Format("message", "message", ["message/*"], ".message", None, [], bombs.message),
    Format(
        "picture_message",
        "picture_message",
        ["picture_message/*"],
        ".picture",
        None,
        [],
        bombs.picture_message,
    ),
    Format("wheels", "wheels", ["wheels/*"], ".wheels", None, [], bombs.wheels),
    Format("edits_toml", "edits_toml", ["edits_toml/*"], ".toml", None, [], bombs_of_text.toml),
    Format("closure_csv", "closure_csv", ["closure_csv/*"], ".csv", None, [], bombs_of_text.text),
    Format(
        "view_client", "view_client", ["view_client/*"], ".message", None, [], bombs_of_text.text
    ),
    Format("scip_reply", "scip_reply", ["scip_reply/*"], ".scip", None, [], bombs_of_text.text),
    Format("rplidar_nodes", "rplidar_nodes", ["rplidar_nodes/*"], ".rplidar"),
]


def seeds_of(fmt, corpus, made):
    """Of a format, by name: what lies in the repository and what the program itself made. Those
    that are long come last."""
    found = []
    for pattern in fmt.seeds:
        if pattern.startswith("simulated/"):
            found += sorted(made.glob(pattern))
        else:
            found += sorted(pathlib.Path(corpus).glob(pattern))
    return [(path.name.split(".")[0], path.read_bytes()) for path in found]
