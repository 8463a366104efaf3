"""The dimensions: taken from robot and world file, consistent, printable."""

import copy
from dataclasses import replace

import pytest

from hardware.dimensions import BED, Hardware, from_files, hardware
from swarm_envs.worlds import load_robot_file, load_world


@pytest.fixture(scope="module")
def h() -> Hardware:
    return hardware()


@pytest.mark.parametrize(
    ("key", "field", "scale"),
    [
        ("chassis_diameter", "chassis_diameter", 1000.0),
        ("wheel_diameter", "wheel_diameter", 1000.0),
        ("shield_outer_radius", "shield_radius", 1000.0),
        ("sensor_height", "sensor_height", 1000.0),
        ("wall_height", "wall_height", 1000.0),
        ("encoder_ticks", "encoder_ticks", 1.0),
    ],
)
def test_a_changed_robot_file_changes_the_hardware(key: str, field: str, scale: float) -> None:
    robot = copy.deepcopy(load_robot_file("hero_plus"))
    robot["parts"][key] *= 2
    assert getattr(from_files(robot, load_world("hero_plus")), field) == pytest.approx(scale * robot["parts"][key])


def test_two_edges_a_slot_make_the_firmwares_ticks(h: Hardware) -> None:
    assert 2 * h.encoder_slots == h.encoder_ticks


def test_slots_are_wide_enough_to_print_and_wider_than_the_switchs_aperture(h: Hardware) -> None:
    inner = h.slot_width * (h.track_radius - h.slot_reach) / h.track_radius
    assert inner > 2 * 0.4
    assert h.slot_width > 2 * 0.5


def test_the_stretched_o_ring_gives_the_firmwares_wheel(h: Hardware) -> None:
    assert h.groove_diameter + 2 * h.mounted_tire_section == pytest.approx(h.wheel_diameter)
    stretch = h.groove_diameter / (h.tire_diameter - 2 * h.tire_section) - 1
    assert 0.01 < stretch < 0.06
    assert h.groove_diameter < h.rim_diameter < h.wheel_diameter


def test_the_servos_fit_back_to_back_between_the_wheels(h: Hardware) -> None:
    assert h.servo_back_gap + h.servo.turret < h.wheel_inner
    assert h.wheel_inner < h.horn_outer < h.wheel_outer - 3


def test_encoder_and_switch_stay_inside_the_shield(h: Hardware) -> None:
    assert h.disc_y + h.switch.length / 2 < h.shield_radius - h.shield_wall - 1


def test_the_cone_clears_the_wall_over_the_published_thresholds(h: Hardware) -> None:
    assert h.sensor_height > h.wall_height
    for threshold in (370.0, 600.0):
        assert h.cone_height(threshold) > h.wall_height


def test_without_tilt_the_cone_would_see_the_wall(h: Hardware) -> None:
    assert replace(h, sensor_tilt=0.0).wall_clear_distance < 370.0


def test_printed_walls_close_the_worlds_arena(h: Hardware) -> None:
    length, leg, long, short = h.wall_plan
    assert (long * length + 2 * leg, short * length + 2 * leg) == pytest.approx(h.arena)
    assert max(length, leg + h.arena_foot) < BED


def test_an_arena_that_no_walls_close_is_refused(h: Hardware) -> None:
    with pytest.raises(ValueError, match="no equal segments"):
        _ = replace(h, arena=(1000.0, 999.0)).wall_plan


def test_the_template_has_the_worlds_spacing(h: Hardware) -> None:
    start = load_world("hero_plus").start
    assert [link + 2 * h.template_arm for link in h.template_links] == pytest.approx([1000 * start.spacing_x, 1000 * start.spacing_y])
