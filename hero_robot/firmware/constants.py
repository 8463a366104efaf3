"""From the robot file to the firmware's constants: one file of numbers for world, CAD and firmware.

:func:`render_header` writes ``hero_config.h``. The copy in ``firmware/core`` is that of ``hero_plus``, so that a board can be built
without Python; a test fails when it and the robot file part. Another robot file gives another header, and another build.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hero_robot.firmware.errors import FirmwareError
from swarm_envs.worlds import load_robot_file

FIX_ONE = 65536
"""One, as the firmware's Q16.16."""


@dataclass(frozen=True)
class Constant:
    """A macro of ``hero_config.h``."""

    name: str
    value: int
    meaning: str
    """Unit and origin, the comment beside it."""
    unsigned: bool = False

    def line(self) -> str:
        """The macro's definition."""
        return f"#define HERO_{self.name} {self.value}{'u' if self.unsigned else ''} /* {self.meaning} */"


def robot_constants(robot_file: str | Path = "hero_plus") -> list[Constant]:
    """The firmware's constants for this robot, in the order of the header.

    Raises:
        FirmwareError: When the robot file lacks a number that the firmware needs.
    """
    robot = load_robot_file(robot_file)
    try:
        constants = [
            *_motion(robot["drive"], robot["parts"], robot["electronics"]),
            *_servos(robot["electronics"]),
            *_sensing(robot["sensors"][0], robot["electronics"]),
            *_battery(robot["electronics"]),
            *_link(robot["electronics"]["link"]),
            *_pins(robot["electronics"]["pins"]),
        ]
    except (KeyError, IndexError) as error:
        raise FirmwareError(f"robot file {robot_file}: {error} is missing; the firmware needs it, add it with unit and source") from None
    for constant in constants:
        if not -(2**31) <= constant.value < 2**31 + constant.unsigned * 2**31:
            raise FirmwareError(f"robot file {robot_file}: {constant.name} is {constant.value}, beyond 32 bits; check the unit")
    return constants


def render_header(robot_file: str | Path = "hero_plus") -> str:
    """The text of ``hero_config.h`` for this robot."""
    name = load_robot_file(robot_file)["name"]
    lines = [constant.line() for constant in robot_constants(robot_file)]
    return "\n".join(
        [
            f"/* Constants of the robot file `{name}`: written by `python -m hero_robot.firmware.constants`, never by hand.",
            " * Q16.16: units of 1/65536. Q8.24: units of 2^-24. Binary angle: 2^32 is one turn. */",
            "#ifndef HERO_CONFIG_H",
            "#define HERO_CONFIG_H",
            "",
            *lines,
            "",
            "#endif",
            "",
        ]
    )


def _fix(value: float) -> int:
    return round(value * FIX_ONE)


def _microseconds(seconds: float) -> int:
    return round(seconds * 1e6)


def _motion(drive: dict[str, Any], parts: dict[str, Any], electronics: dict[str, Any]) -> list[Constant]:
    tick = math.pi * parts["wheel_diameter"] / parts["encoder_ticks"]
    rim = electronics["servo_no_load_speed"] * parts["wheel_diameter"] / 2
    base = drive["wheel_base"]
    step = round(electronics["velocity_ki"] * electronics["control_period"])
    per_speed = round((electronics["servo_span_us"] - electronics["servo_deadband_us"] / 2) / rim)
    return [
        Constant("CONTROL_PERIOD_US", _microseconds(electronics["control_period"]), "us, control_period"),
        Constant("MAX_SPEED", _fix(drive["max_linear_speed"]), "m/s as Q16.16, max_linear_speed"),
        Constant("MAX_TURN", _fix(drive["max_angular_speed"]), "rad/s as Q16.16, max_angular_speed"),
        Constant("WHEEL_BASE", _fix(base), "m as Q16.16, wheel_base"),
        Constant("WHEEL_BASE_INVERSE", _fix(1 / base), "1/m as Q16.16, 1 / wheel_base"),
        Constant("MAX_RIM_SPEED", _fix(rim), "m/s as Q16.16, servo_no_load_speed x wheel_diameter / 2"),
        Constant(
            "TICK_SPEED", round(tick * FIX_ONE * 1e6), "rim speed, Q16.16 m/s, of one tick a us: pi wheel_diameter / encoder_ticks", True
        ),
        Constant("HALF_TICK", round(tick / 2 * 2**24), "m as Q8.24, rim path of half a tick"),
        Constant(
            "HALF_TICK_TURN", round(tick / base / (4 * math.pi) * 2**32), "binary angle, half the turn of one tick of one wheel", True
        ),
        Constant("VELOCITY_KP", round(electronics["velocity_kp"]), "us of pulse for 1 m/s of error, velocity_kp"),
        Constant("VELOCITY_KI_STEP", step, "us of pulse for 1 m/s of error in one control period, velocity_ki x control_period"),
        Constant("SERVO_US_PER_SPEED", per_speed, "us of pulse for 1 m/s, (servo_span_us - servo_deadband_us / 2) / MAX_RIM_SPEED"),
        Constant("ENCODER_STANDSTILL_US", _microseconds(electronics["encoder_standstill"]), "us, encoder_standstill", True),
        Constant("ENCODER_REVERSAL_US", _microseconds(electronics["encoder_reversal"]), "us, encoder_reversal", True),
        Constant("STALL_US", _microseconds(electronics["stall_time"]), "us, stall_time", True),
    ]


def _servos(electronics: dict[str, Any]) -> list[Constant]:
    names = ("halt", "min", "max", "span", "deadband")
    pulses = [Constant(f"SERVO_{name.upper()}_US", round(electronics[f"servo_{name}_us"]), f"us, servo_{name}_us") for name in names]
    refresh = Constant("SERVO_REFRESH_US", _microseconds(electronics["servo_refresh"]), "us, servo_refresh", True)
    lag = Constant("SERVO_LAG_US", _microseconds(electronics["servo_lag"]), "us, servo_lag: of the simulated servo alone")
    return [*pulses, refresh, lag]


def _sensing(sensor: dict[str, Any], electronics: dict[str, Any]) -> list[Constant]:
    return [
        Constant("TOF_THRESHOLD_MM", round(sensor["range"] * 1e3), "mm, range of the first sensor"),
        Constant("TOF_MIN_MM", round(electronics["tof_min_range"] * 1e3), "mm, tof_min_range"),
        Constant("TOF_DEBOUNCE", electronics["tof_debounce"], "readings, tof_debounce"),
        Constant("TOF_PERIOD_MS", round(electronics["tof_period"] * 1e3), "ms, tof_period"),
        Constant("TOF_BUDGET_MS", round(electronics["tof_timing_budget"] * 1e3), "ms, tof_timing_budget"),
        Constant("TOF_TIMEOUT_US", _microseconds(electronics["tof_timeout"]), "us, tof_timeout", True),
    ]


def _battery(electronics: dict[str, Any]) -> list[Constant]:
    return [
        Constant("BATTERY_NOMINAL_MV", round(electronics["battery_voltage"] * 1e3), "mV, battery_voltage"),
        Constant("BATTERY_WARNING_MV", round(electronics["battery_warning"] * 1e3), "mV, battery_warning"),
        Constant("BATTERY_CUTOFF_MV", round(electronics["battery_cutoff"] * 1e3), "mV, battery_cutoff"),
        Constant("BATTERY_FULL_SCALE_MV", round(electronics["battery_full_scale"] * 1e3), "mV, battery_full_scale"),
        Constant("BATTERY_HOLD_OFF_US", _microseconds(electronics["battery_hold_off"]), "us, battery_hold_off", True),
    ]


def _link(link: dict[str, Any]) -> list[Constant]:
    return [
        Constant("LINK_PORT", link["port"], "UDP, link.port"),
        Constant("LEASE_MAX_US", _microseconds(link["lease_max"]), "us, link.lease_max", True),
        Constant("START_HORIZON_US", _microseconds(link["start_horizon"]), "us, link.start_horizon", True),
        Constant("STATUS_PERIOD_US", _microseconds(link["status_period"]), "us, link.status_period", True),
        Constant("FRAMES_PER_POLL", link["frames_per_poll"], "frames, link.frames_per_poll"),
    ]


def _pins(pins: dict[str, Any]) -> list[Constant]:
    return [Constant(f"PIN_{name.upper()}", number, f"GPIO, pins.{name}") for name, number in pins.items()]


def main() -> None:
    """Write the header of ``hero_plus`` into ``firmware/core``."""
    from hero_robot.firmware.sources import core_folder

    path = core_folder() / "hero_config.h"
    path.write_text(render_header(), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
