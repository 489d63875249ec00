"""How good is a map? Where the truth is known: odometry alone, matching alone, loops closed."""

import loopstone as ls

# A laser as on many older robots: 180 degrees, one beam a degree.
drive = ls.simulate(
    "office", seed=2, duration_s=150.0, laser__rate_hz=5.0, laser__beams=181, laser__fov_rad=3.14159
)
print(f"{drive.scans} scans, {drive.route_length_m:.0f} m")
matched = ls.map(drive, loop_closure=False)
closed = ls.map(drive)

paths = {
    "odometry": closed.odometry,
    "matching alone": matched.trajectory,
    "loops closed": closed.trajectory,
}
errors = {name: ls.evaluate(path, drive.truth) for name, path in paths.items()}
for name, error in errors.items():
    ate = error.ate_translation_m
    print(f"{name:16} {ate.rmse:8.3f} m rmse {ate.max:8.3f} m max")
assert errors["loops closed"].ate_translation_m.rmse < errors["odometry"].ate_translation_m.rmse
