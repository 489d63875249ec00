#!/usr/bin/env python3
"""Measures the colour of the floor and writes the tables of docs/texture.md.

The programs are built by `make bench` (-DLOOPSTONE_BENCH=ON). Recordings with RGB-D are simulated
into build/bench (about 200 MB each). What was measured is kept in build/bench/texture.json.

  bench/texture.py                           measures and writes
  bench/texture.py --only accuracy           one of: accuracy, clock, speed
  bench/texture.py --quick                   a shorter look; writes nothing into docs/
  bench/texture.py --only                    no measurement: writes the tables from texture.json
                                             again
"""
import json
import math
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, run, say  # noqa: E402
from sections import measure_sections, section_parser, verdicts  # noqa: E402

PAGE = ROOT / "docs/texture.md"
SECTIONS = ["accuracy", "clock", "speed"]
FLOORS = [("mixed", 1), ("text", 3), ("tiles", 2), ("wood", 4), ("carpet", 5)]
PSNR_DB, LOSS_DB, LETTERS, PITCH_DEG, CLOCK_MS = 28.0, 1.0, 0.95, 0.1, 5.0
FILES_PER_S, MEMORY_PER_S = 60.0, 200.0
OFFSETS_S = [0.05, -0.08]


def recording(loopstone, floor, seed, duration_s, flags=()):
    return loopstone.simulate(
        "office", seed, ["--rgbd", "--floor", floor, "--duration", duration_s, *flags]
    )


def texture(loopstone, log, trajectory, name, flags=()):
    folder = loopstone.work / ("texture-" + name)
    _, cost = run(
        [
            loopstone.program,
            "texture",
            log,
            "--trajectory",
            trajectory,
            "-o",
            folder,
            "--force",
            "--quiet",
            *flags,
        ]
    )
    return folder, json.loads((folder / "summary.json").read_text()), cost


def found(summary, world):
    """What was found out about the camera, against what was simulated."""
    true_pitch = world["camera"]["robot_T_camera"]["pitch_rad"]
    given_pitch = true_pitch - world["options"]["camera"]["pitch_error_rad"]
    pitch_deg = math.degrees(given_pitch) + summary["floor"]["pitch_error_deg"]
    # The trajectory carries the laser's stamps, which are late themselves.
    late_s = world["camera"]["clock_offset_s"] - world["options"]["laser"]["clock_offset_s"]
    return {
        "pitch_off_deg": pitch_deg - math.degrees(true_pitch),
        "late_ms": 1e3 * summary["clock"]["late_s"],
        "late_sigma_ms": 1e3 * summary["clock"]["sigma_s"],
        "true_late_ms": 1e3 * late_s,
        "clock": summary["clock"]["status"],
        "seen_area_m2": summary["seen_area_m2"],
        "frames": summary["frames"],
        "frames_used": summary["frames_used"],
    }


def measure_accuracy(arguments, loopstone):
    rows = []
    for floor, seed in FLOORS[:1] if arguments.quick else FLOORS:
        log = recording(loopstone, floor, seed, 30 if arguments.quick else 60)
        world = json.loads((log / "world.json").read_text())
        mapped, _, _ = loopstone.map(log, f"rgbd-{floor}", ["--no-texture"])
        for poses, trajectory in (("true", log / "truth.tum"), ("SLAM", mapped / "trajectory.tum")):
            folder, summary, _ = texture(loopstone, log, trajectory, f"{floor}-{poses}")
            alignment = [] if poses == "true" else [trajectory, log / "truth.tum"]
            likeness = json.loads(
                run([arguments.programs / "measure_texture", folder, floor, seed, *alignment])[0]
            )
            rows.append(
                {"floor": floor, "seed": seed, "poses": poses, **likeness, **found(summary, world)}
            )
            say(f"  {floor}, {poses} poses: {likeness['psnr_db']:.1f} dB")
        if floor == FLOORS[0][0] or floor == "text":
            rows[-1]["ate_rmse_m"] = loopstone.evaluate(
                "--estimate", mapped / "trajectory.tum", "--reference", log / "truth.tum"
            )["ate_rmse_m"]
    return {"rows": rows}


def measure_clock(arguments, loopstone):
    rows = []
    for offset_s in OFFSETS_S[:1] if arguments.quick else OFFSETS_S:
        log = recording(
            loopstone,
            "mixed",
            1,
            30 if arguments.quick else 60,
            ["--set", f"camera.clock_offset_s={offset_s}"],
        )
        world = json.loads((log / "world.json").read_text())
        for flags in ([], ["--set", "texture.correct_clock=false"]):
            folder, summary, _ = texture(loopstone, log, log / "truth.tum", "clock", flags)
            likeness = json.loads(
                run([arguments.programs / "measure_texture", folder, "mixed", 1])[0]
            )
            rows.append(
                {
                    "corrected": not flags,
                    "warned": any("stamps" in w for w in summary["warnings"]),
                    **likeness,
                    **found(summary, world),
                }
            )
    return {"rows": rows}


def measure_speed(arguments, loopstone):
    log = recording(loopstone, "mixed", 1, 30 if arguments.quick else 60)
    program = arguments.programs / "measure_texture_speed"
    half, whole = (
        json.loads(run([program, log, log / "truth.tum", count])[0]) for count in (150, 300)
    )
    return {"whole": whole, "half_peak_mb": half["streaming_peak_mb"]}


MEASURE = {"accuracy": measure_accuracy, "clock": measure_clock, "speed": measure_speed}


def accuracy_targets(figures):
    rows = figures["rows"]
    true = {row["floor"]: row for row in rows if row["poses"] == "true"}
    slam = {row["floor"]: row for row in rows if row["poses"] == "SLAM"}
    targets = []
    for floor, row in true.items():
        targets.append(
            (
                f"{floor}, true poses: likeness to the true floor",
                f">= {PSNR_DB:.0f} dB",
                f"{row['psnr_db']:.1f} dB",
                row["psnr_db"] >= PSNR_DB,
            )
        )
    for floor, row in slam.items():
        loss = true[floor]["psnr_db"] - row["psnr_db"]
        targets.append(
            (
                f"{floor}, poses of loopstone map: likeness lost",
                f"<= {LOSS_DB:.0f} dB",
                f"{loss:.1f} dB",
                loss <= LOSS_DB,
            )
        )
    if "text" in true:
        share = true["text"]["letters_read"] / max(1, true["text"]["letters"])
        targets.append(
            (
                "text, true poses: letters of 5 cm read",
                f">= {100 * LETTERS:.0f} %",
                f"{100 * share:.1f} %",
                share >= LETTERS,
            )
        )
    worst = max(abs(row["pitch_off_deg"]) for row in rows)
    targets.append(
        (
            "pitch of the camera, worst error",
            f"<= {PITCH_DEG} deg",
            f"{worst:.3f} deg",
            worst <= PITCH_DEG,
        )
    )
    return targets


def clock_targets(figures):
    return [
        (
            f"camera's stamps late by {row['true_late_ms']:+.0f} ms: found, and said",
            f"within {CLOCK_MS:.0f} ms",
            f"{row['late_ms']:+.1f} ms",
            abs(row["late_ms"] - row["true_late_ms"]) <= CLOCK_MS and row["warned"],
        )
        for row in figures["rows"]
        if row["corrected"]
    ]


def speed_targets(figures):
    whole = figures["whole"]
    return [
        (
            "frames a second, one core, pictures from PNG files",
            f">= {FILES_PER_S:.0f}",
            f"{whole['from_files_without_clock_per_s']:.0f}",
            whole["from_files_without_clock_per_s"] >= FILES_PER_S,
        ),
        (
            "frames a second, one core, pictures in memory",
            f">= {MEMORY_PER_S:.0f}",
            f"{whole['from_memory_without_clock_per_s']:.0f}",
            whole["from_memory_without_clock_per_s"] >= MEMORY_PER_S,
        ),
    ]


TARGETS = {"accuracy": accuracy_targets, "clock": clock_targets, "speed": speed_targets}


def accuracy_text(figures):
    rows = [
        [
            row["floor"],
            row["poses"],
            f"{row['seen_area_m2']:.0f}",
            f"{row['psnr_db']:.1f}",
            f"{row['psnr_levelled_db']:.1f}",
            f"{row['letters_read']:,} of {row['letters']:,}" if row["letters"] else "",
            f"{row['pitch_off_deg']:+.3f}",
            f"{row['late_ms']:+.1f} +- {row['late_sigma_ms']:.1f}",
        ]
        for row in figures["rows"]
    ]
    return table(
        [
            "floor",
            "poses",
            "seen [m2]>",
            "PSNR [dB]>",
            "after one common gain [dB]>",
            "letters of 5 cm read>",
            "pitch, error [deg]>",
            "clock found [ms]>",
        ],
        rows,
    )


def clock_text(figures):
    rows = [
        [
            "yes" if row["corrected"] else "no",
            f"{row['true_late_ms']:+.0f}",
            f"{row['late_ms']:+.1f} +- {row['late_sigma_ms']:.1f}" if row["corrected"] else "",
            f"{row['psnr_db']:.1f}",
        ]
        for row in figures["rows"]
    ]
    return table(["corrected", "true [ms]>", "found [ms]>", "PSNR [dB]>"], rows)


def speed_text(figures):
    whole = figures["whole"]
    rows = [
        [
            "from PNG files",
            f"{whole['from_files_without_clock_per_s']:.0f}",
            f"{whole['from_files_per_s']:.0f}",
        ],
        [
            "already in memory",
            f"{whole['from_memory_without_clock_per_s']:.0f}",
            f"{whole['from_memory_per_s']:.0f}",
        ],
    ]
    return (
        table(
            [
                "pictures",
                "frames a second>",
                f"with the clock's offset, over {whole['frames']} frames>",
            ],
            rows,
        )
        + f"\n\nPeak memory while frames stream from files: {figures['half_peak_mb']:.0f} MB after"
        f" 150 frames, {whole['streaming_peak_mb']:.0f} MB after {whole['frames']}; what grows"
        " are the cells that were seen."
    )


TEXT = {"accuracy": accuracy_text, "clock": clock_text, "speed": speed_text}
BLOCKS = {"texture-accuracy": ["accuracy", "clock"], "texture-speed": ["speed"]}


def main():
    arguments = section_parser(__doc__, SECTIONS, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    if arguments.only:
        loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
        sections, failed = measure_sections(
            "texture", arguments, loopstone, lambda name: MEASURE[name](arguments, loopstone)
        )
    else:
        sections, failed = json.loads((arguments.work / "texture.json").read_text()), []
    for block, names in BLOCKS.items():
        present = [name for name in names if name in sections]
        if not present:
            continue
        parts = []
        for name in present:
            figures = sections[name]["figures"]
            parts += [
                tables.provenance(sections[name]),
                "",
                TEXT[name](figures),
                "",
                tables.targets_table(TARGETS[name](figures)),
                "",
            ]
        text = "\n".join(parts)
        if arguments.quick:
            print(text)
        elif write_block(PAGE, block, text):
            say(f"wrote {PAGE.name}: {block}")
    print(
        verdicts(
            [
                row
                for name in SECTIONS
                if name in sections
                for row in TARGETS[name](sections[name]["figures"])
            ]
        )
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
