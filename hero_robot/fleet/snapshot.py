"""The fleet as plain data, for the page, the command line and the ROS bridge."""

from __future__ import annotations

from typing import Any

from hero_robot.fleet.coordinator import FleetCoordinator
from hero_robot.fleet.frames import REASONS
from hero_robot.fleet.robot_link import RobotLink

EVENTS = 20
"""Newest events that are shown."""


def snapshot(coordinator: FleetCoordinator, now_us: int) -> dict[str, Any]:
    """What there is to know at this server time, us."""
    return {
        "fleet": coordinator.fleet.name,
        "stopped": coordinator.stopped,
        "run": coordinator.run,
        "robots": [_describe(link, now_us) for link in coordinator.links.values()],
        "events": coordinator.events[-EVENTS:],
    }


def _describe(link: RobotLink, now_us: int) -> dict[str, Any]:
    status = link.status
    described: dict[str, Any] = {"name": link.entry.name, "connected": link.connected(now_us)}
    if status is None:
        return described | {"state": "UNKNOWN"}
    return described | {
        "state": status.state.name,
        "reason": REASONS[status.reason],
        "faults": [fault.name for fault in status.faults],
        "start_pending": status.start_pending,
        "detected": status.seen,
        "range": status.range,
        "battery": status.battery,
        "battery_low": status.battery_low,
        "version": status.version,
        "v": status.v,
        "omega": status.omega,
        "x": status.x,
        "y": status.y,
        "theta": status.theta,
        "lease": status.lease_us / 1e6,
        "silent": (now_us - link.heard_us) / 1e6,
        "round_trip": link.clock.round_trip_us / 1e6,
        "refused": status.refused,
    }
