from __future__ import annotations

import numpy as np
import pytest

import loopstone as ls


def test_replace_changes_what_is_named_and_nothing_else() -> None:
    robot = ls.Robot()
    other = robot.replace(footprint_radius_m=0.3, wheels__track_width_m=0.5, name="mine")
    assert (other.footprint_radius_m, other.wheels.track_width_m, other.name) == (0.3, 0.5, "mine")
    assert robot.footprint_radius_m == 0.25 and robot.wheels.track_width_m == 0.39
    changed = set(other.to_toml().splitlines()) - set(robot.to_toml().splitlines())
    assert {line.split(" = ")[0] for line in changed} == {
        "name",
        "footprint_radius_m",
        "track_width_m",
    }
    assert ls.Robot(other.to_toml()).to_toml() == other.to_toml()
    assert robot.replace().to_toml() == robot.to_toml()
    tilted = robot.replace({"camera.pitch_rad": 0.5})
    assert "pitch_rad = 0.5 " in tilted.to_toml()


def test_lidars_are_replaced_or_changed_one_by_one() -> None:
    front = ls.LidarMount(x_m=0.2, y_m=0.01, yaw_rad=0.1)
    rear = front.replace(x_m=-0.2, yaw_rad=np.pi, name="rear", upside_down=True)
    robot = ls.Robot().replace(lidars=[front, rear])
    assert robot.lidars == [front, rear] and robot.lidars[1].name == "rear"
    np.testing.assert_allclose(robot.robot_T_lidars, [[0.2, 0.01, 0.1], [-0.2, 0.01, np.pi]])
    moved = robot.replace({"lidars[1].height_m": 0.3}, odometry_scale=1.01)
    assert [lidar.height_m for lidar in moved.lidars] == [front.height_m, 0.3]
    assert moved.odometry_scale == 1.01 and moved.lidars[0] == front
    assert robot.replace(lidars=[]).lidars == []


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(ls.OptionsError) as caught:
        ls.Robot().replace(
            {"lidars[4].x_m": 0.1},
            lidars=[ls.LidarMount(x_m=1e6)],
            wheels__track=0.4,
            footprint_radius_m=-1.0,
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {"lidars[4].x_m", "lidars[0].x_m", "wheels.track", "footprint_radius_m"}
    with pytest.raises(TypeError):
        ls.LidarMount().replace(z_m=1.0)
    with pytest.raises(AttributeError):
        ls.Robot().name = "mine"  # type: ignore[misc]


def test_a_log_is_read_as_the_changed_robot_says(drive: ls.Simulation, log: object) -> None:
    robot = drive.robot.replace({"lidars[0].x_m": drive.robot.lidars[0].x_m + 0.5})
    scan = next(m for m in ls.open_log(str(log), robot=robot) if isinstance(m, ls.LaserScan))
    there, here = scan.points(robot=robot), scan.points(robot=drive.robot)
    np.testing.assert_allclose(there - here, np.broadcast_to([0.5, 0.0], here.shape), atol=1e-9)
