"""A world file is read as written or refused with file, key and reason."""

from __future__ import annotations

import dataclasses
import pickle
from pathlib import Path

import numpy as np
import pytest

from swarm_envs.worlds import WorldError, load_robot_file, load_world, world_names
from swarm_envs.worlds.dump import world_from_text, world_to_text
from swarm_envs.worlds.geometry import start_points
from swarm_envs.worlds.load import WORLDS, _read_yaml

MINIMAL = """
robot: hero_plus
num_robots: 2
arena: {outline: [[0, 0], [1.7, 0], [1.7, 1.42], [0, 1.42]]}
limits: {linear_speed: 0.09, angular_speed: 1.6}
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "mine.yaml"
    path.write_text(text)
    return path


def test_the_papers_world_has_the_papers_numbers() -> None:
    world = load_world("hero_plus")
    robot = world.robots[0]
    assert world.num_robots == 8
    assert world.size == (1.70, 1.42)
    assert (world.limits.linear_speed, world.limits.angular_speed) == (0.09, 1.6)
    assert (robot.drive.max_linear_speed, robot.drive.max_angular_speed) == (0.20, 3.0)
    assert (robot.body.contact_radius, robot.body.visible_radius, robot.drive.wheel_base) == (0.060, 0.040, 0.063)
    assert (robot.sensors[0].half_angle, robot.sensors[0].range, robot.sensors[0].period) == (0.12, 1.0, 0.1)
    assert world.contact.robot_friction > 0
    assert world.contact.wall_friction > 0


def test_the_papers_start_grid_has_twelve_points_around_the_centre() -> None:
    points = start_points(load_world("hero_plus"))
    assert points.shape == (12, 2)
    assert points.mean(axis=0) == pytest.approx([0.85, 0.71])


def leaves(node: object, key: str = "") -> list[tuple[str, object]]:
    if isinstance(node, dict) and "value" not in node:
        return [leaf for name, item in node.items() for leaf in leaves(item, f"{key}.{name}")]
    if isinstance(node, list):
        return [leaf for index, item in enumerate(node) for leaf in leaves(item, f"{key}[{index}]")]
    return [(key, node)]


@pytest.mark.parametrize("path", sorted([*WORLDS.glob("*.yaml"), *WORLDS.glob("robots/*.yaml")]), ids=lambda path: path.stem)
def test_every_number_of_a_shipped_file_has_unit_and_source(path: Path) -> None:
    texts = {"name", "description", "robot", "shape", "extends"}
    for key, leaf in leaves(_read_yaml(path)):
        if key.rsplit(".", 1)[-1] in texts or isinstance(leaf, bool):
            continue
        assert isinstance(leaf, dict), f"{key} has no unit and source"
        assert {"value", "unit", "source"} <= set(leaf), f"{key} lacks unit or source"


@pytest.mark.parametrize("name", world_names())
def test_a_world_written_out_reads_back_equal(name: str) -> None:
    world = load_world(name)
    again = world_from_text(world_to_text(world))
    assert again == world
    assert pickle.loads(pickle.dumps(world)) == world


def test_sources_survive_writing_out() -> None:
    world = load_world("hero_plus")
    assert world_from_text(world_to_text(world)).provenance["arena.outline"] == world.provenance["arena.outline"]


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("robt: hero_plus", "robt: unknown key; did you mean 'robot'?"),
        ("arena: {outline: [[0, 0], [1, 1]]}", "at least 3 points"),
        ("arena: {outline: [[0, 0], [1, 1], [1, 0], [0, 1]]}", "not a simple polygon"),
        ("limits: {linear_speed: 0.09}", "limits.angular_speed: missing"),
        ("limits: {linear_speed: -1, angular_speed: 1}", "limits.linear_speed: given -1, expected a number from 0 to 100"),
        ("limits: {linear_speed: .nan, angular_speed: 1}", "limits.linear_speed"),
        ("limits: {linear_speed: fast, angular_speed: 1}", "given 'fast', expected a number"),
        ("limits: {linear_speed: {value: 9, unit: cm/s}, angular_speed: 1}", "unit is 'cm/s', expected 'm/s'"),
        ("limits: {linear_speed: 0.5, angular_speed: 1}", "expected at most what its slowest robot can do, 0.2 m/s"),
        ("robot: {extends: hero_plus, body: {contact_radius: -0.06}}", "body.contact_radius: given -0.06"),
        ("robot: hero_pluss", "did you mean 'hero_plus'?"),
        ("num_robots: 500", "500 robots of radius 0.06 m do not fit"),
        ("num_robots: 0", "expected a whole number from 1 to 1000"),
        ("objects: [{shape: ball, size: [0.1]}]", "given 'ball', expected 'disc' or 'box'"),
        ("effects: {motor_lagg: 0.1}", "did you mean 'motor_lag'?"),
        ("arena: 3", "arena: given 3, expected a mapping of keys"),
    ],
)
def test_a_wrong_world_is_refused_with_file_key_and_reason(tmp_path: Path, change: str, complaint: str) -> None:
    key = change.split(":")[0]
    kept = [line for line in MINIMAL.splitlines() if not line.startswith(f"{key}:")]
    with pytest.raises(WorldError) as error:
        load_world(write(tmp_path, "\n".join([*kept, change])))
    message = str(error.value)
    assert complaint in message
    assert "mine" in message
    assert "\n" not in message


@pytest.mark.parametrize("text", ["{", "- a", "", "name: \xff\x00"])
def test_a_file_that_is_no_mapping_is_refused_in_one_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(WorldError) as error:
        load_world(write(tmp_path, text))
    assert "\n" not in str(error.value)


def test_unknown_worlds_are_refused_with_the_known_ones() -> None:
    with pytest.raises(WorldError, match="unknown world 'hero_plu'; did you mean 'hero_plus'"):
        load_world("hero_plu")
    with pytest.raises(WorldError, match="no such world file"):
        load_world("missing.yaml")


def test_a_world_file_can_extend_another_and_change_one_number(tmp_path: Path) -> None:
    world = load_world(write(tmp_path, "extends: hero_plus\nname: slick\ncontact: {wall_friction: 0.0}\n"))
    assert world.contact.wall_friction == 0.0
    assert dataclasses.replace(world.contact, wall_friction=0.4) == load_world("hero_plus").contact


def test_a_circle_of_extends_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("extends: b")
    (tmp_path / "b.yaml").write_text("extends: a")
    with pytest.raises(WorldError, match="remove the circle"):
        load_world(tmp_path / "a.yaml")


def test_mixed_populations_keep_their_order(tmp_path: Path) -> None:
    text = MINIMAL.replace("robot: hero_plus\nnum_robots: 2\n", "") + (
        "robots: [{robot: hero_plus, count: 2}, {robot: {extends: hero_plus, effects: {linear_gain: 0.5}}, count: 3}]\n"
    )
    world = load_world(write(tmp_path, text))
    assert [robot.effects.linear_gain for robot in world.robots] == [1.0, 1.0, 0.5, 0.5, 0.5]
    assert world_from_text(world_to_text(world)) == world


def test_a_thousand_robots_fit_when_the_arena_grows_with_them() -> None:
    world = load_world("hero_plus").with_robots(1000, scale_arena=True)
    points = start_points(world)
    assert len(points) >= 1000
    assert np.prod(world.size) / 1000 == pytest.approx(1.70 * 1.42 / 8)


def test_the_robot_file_serves_firmware_and_cad_without_units() -> None:
    robot = load_robot_file("hero_plus")
    assert robot["parts"]["encoder_ticks"] == 96
    assert robot["drive"]["wheel_base"] == 0.063


def test_a_gain_has_room_for_commands_in_a_drivers_own_units() -> None:
    text = MINIMAL + "effects: {angular_gain: 97.0, linear_gain: 600.0}\n"
    effects = world_from_text(text).robots[0].effects
    assert (effects.angular_gain, effects.linear_gain) == (97.0, 600.0)
