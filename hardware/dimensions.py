"""Every dimension of the HeRo+ hardware, in millimetres.

What the simulated worlds, the firmware and the CAD share comes from the robot file and the world file. What only a maker
needs (walls, clearances, screws, bought parts) stands here, beside its reason. Lengths are millimetres and angles degrees, as CAD
kernels and slicers have it; x points forward, y to the left, z up, the origin lies on the floor under the middle of the axle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from swarm_envs.worlds import WorldSpec, load_robot_file, load_world

BED = 180.0
"""Side of the print bed that every part must fit."""


@dataclass(frozen=True)
class Print:
    """What a 0.4 mm nozzle gives; print the fit test of ``docs/printing.md`` first and change these, not the parts."""

    wall: float = 1.6
    """Thin walls: four lines of 0.4 mm."""
    slide: float = 0.2
    """Gap on each side of a joint that slides together by hand."""
    press: float = 0.1
    """Gap on each side of a spigot that locates."""
    moving: float = 0.7
    """Least gap between anything that turns and anything that does not."""


@dataclass(frozen=True)
class Screws:
    """Holes for named screws. M3: ISO 7045 pan head or DIN 912 cap head; M2: self-tapping for plastic, as sold with servos."""

    m3: float = 3.4
    """Clearance hole, ISO 273 medium fit."""
    m3_head: float = 6.2
    """Counterbore; a cap head is 5.5 wide, a pan head 5.6."""
    m3_head_height: float = 3.0
    m3_nut: float = 5.8
    """Across flats of a nut pocket; the nut (ISO 4032) is 5.5."""
    m3_nut_height: float = 2.4
    m2: float = 2.3
    """Clearance hole for a 2 mm self-tapping screw."""
    m2_pilot: float = 1.6
    """Hole that a 2 mm self-tapping screw cuts its thread in."""
    m2_head: float = 4.0
    m25: float = 2.8
    """Clearance hole for the sensor board's M2.5 screws."""
    m25_nut: float = 5.3
    """Across flats; the nut is 5.0."""


@dataclass(frozen=True)
class Servo:
    """SG90 size continuous-rotation servo. Outline 22.2 x 11.8 x 31 as its makers give it, the rest as usual for the size."""

    length: float = 22.2
    width: float = 11.8
    overall: float = 31.0
    """Bottom of the case to the tip of the spline."""
    case: float = 22.7
    """Bottom to the flat top of the case."""
    turret: float = 27.0
    """Bottom to the top of the round gear housing."""
    turret_diameter: float = 11.8
    spline_diameter: float = 4.8
    shaft_from_end: float = 5.9
    """Axis of the shaft from the near end of the case."""
    flange_length: float = 32.2
    flange_bottom: float = 15.9
    flange_height: float = 2.5
    hole_pitch: float = 27.8
    play_length: float = 0.6
    """Gap at each end: copies are up to 23.2 long."""
    play_width: float = 0.7
    """Gap above: copies are up to 12.5 wide."""


@dataclass(frozen=True)
class Horn:
    """Double-arm horn as supplied with the servo; it carries the wheel."""

    hub_diameter: float = 7.0
    height: float = 3.8
    arm_thickness: float = 1.5
    arm_span: float = 33.0
    arm_width_hub: float = 6.0
    arm_width_tip: float = 4.2
    play: float = 0.25


@dataclass(frozen=True)
class Switch:
    """Slotted optical switch Vishay TCST2202: 24.5 x 6.3 x 10.8, gap 3.1, aperture 0.5 (data sheet 81147)."""

    length: float = 24.5
    body: float = 11.9
    """Length without the two ears."""
    width: float = 6.3
    height: float = 10.8
    gap: float = 3.1
    ear_height: float = 2.6
    hole_pitch: float = 19.0
    hole: float = 3.2
    beam_height: float = 8.1
    """Optical axis above the base."""
    gap_floor: float = 3.0
    """Bottom of the gap above the base."""
    pin_pitch_length: float = 7.62
    pin_pitch_width: float = 2.54


@dataclass(frozen=True)
class Boards:
    """Circuit boards and the cell: outlines length x width x height."""

    cell: tuple[float, float, float] = (52.0, 34.0, 10.5)
    """Pouch cell 103450, 1800 mAh, with its protection board; new cells are 10.0 thick and swell."""
    charger: tuple[float, float, float] = (28.0, 17.2, 4.6)
    """TP4056 with protection (DW01), USB-C; along x, the socket to the rear."""
    converter: tuple[float, float, float] = (36.6, 17.2, 7.0)
    """MT3608 boost module, with its potentiometer laid flat or replaced; along y."""
    carrier: tuple[float, float, float] = (60.0, 40.0, 1.6)
    """Perforated board 4 x 6 cm; along y."""
    carrier_holes: tuple[float, float] = (56.0, 36.0)
    nodemcu: tuple[float, float, float] = (49.0, 26.0, 1.6)
    """NodeMCU v2 ("Amica"), rows 22.86 apart; along y. The v3 ("Lolin", 58 x 31) does not fit the carrier."""
    socket_height: float = 8.5
    """Female header between carrier and NodeMCU."""
    tof: tuple[float, float, float] = (25.0, 10.7, 1.6)
    """VL53L1X breakout; width y, height z, thickness."""
    tof_hole_pitch: float = 20.0
    tof_chip: tuple[float, float, float] = (4.9, 2.5, 1.5)
    rocker: tuple[float, float] = (13.6, 8.9)
    """Panel cut-out of a KCD11 rocker switch."""


@dataclass(frozen=True)
class Hardware:
    """All dimensions together; build it with :func:`hardware`."""

    # From the robot file.
    chassis_diameter: float
    wheel_base: float
    wheel_diameter: float
    rim_diameter: float
    tire_diameter: float
    encoder_ticks: int
    encoder_slots: int
    track_radius: float
    shield_radius: float
    shield_height: float
    shield_bottom: float
    sensor_height: float
    sensor_forward: float
    sensor_tilt: float
    sensor_cone: float
    hat_radius: float
    hat_top: float
    wall_height: float
    # From the world file.
    arena: tuple[float, float]
    grid: tuple[int, int]
    spacing: tuple[float, float]

    print: Print = field(default_factory=Print)
    screws: Screws = field(default_factory=Screws)
    servo: Servo = field(default_factory=Servo)
    horn: Horn = field(default_factory=Horn)
    switch: Switch = field(default_factory=Switch)
    boards: Boards = field(default_factory=Boards)

    # Stack of the chassis, from the axle downwards and upwards.
    servo_seat: float = 0.1
    """Gap under the servos."""
    servo_back_gap: float = 0.25
    """Each servo's case starts so far from the middle plane."""
    seat_floor: float = 1.6
    """Plate left under the servos' pocket."""
    plate_thickness: float = 3.0
    pillar_thickness: float = 4.5
    standoff: float = 30.0
    """M3 female-female hexagonal standoffs between body plate and deck."""
    boss_height: float = 2.7
    standoff_xy: tuple[float, float] = (28.5, 17.0)
    deck_thickness: float = 3.0
    deck_gap: float = 1.5
    """Deck to shield, all round."""
    tray_thickness: float = 2.0
    """Power tray."""

    # Wheel and encoder.
    wheel_width: float = 6.0
    wheel_gap: float = 1.0
    """Wheel to the flats of the body plate."""
    tire_section: float = 3.5
    """Cross section of the O-ring 41 x 3.5, 48 outside."""
    shaft_diameter: float = 15.0
    shaft_bore: float = 5.6
    """Lets the horn's screw and a screwdriver through."""
    disc_thickness: float = 1.2
    disc_radius: float = 22.5
    slot_reach: float = 1.8
    """Slots reach so far inside and outside the track."""
    switch_gap: float = 0.8
    """Wheel to the inner arm of the switch."""
    bracket_travel: float = 1.0
    """The bracket slides so far either way along the axle."""

    # Skids under the ends of the battery tray, screwed from below so that the cell comes out without taking the robot apart.
    skid_x: float = 32.2
    skid_diameter: float = 9.4
    skid_head: float = 2.0
    """Depth that hides the button head (ISO 7380, 1.65 high) of the skid's screw."""
    front_skid_lift: float = 0.8
    """The robot rests on wheels and rear skid; the front one stops a nod."""

    # Bump shield.
    shield_wall: float = 1.6
    lug_reach: float = 8.9
    lug_radius: float = 51.5
    """Circle of the screws that hold the shield."""
    charge_window: tuple[float, float, float, float] = (18.0, 29.0, 43.0, 2.0)
    """Width, bottom, top and corner radius of the opening for the charging plug."""

    # Hat.
    hat_wall: float = 1.2
    """Three lines of 0.4 mm: nothing pushes the hat."""
    hat_lug_radius: float = 44.5
    hat_lug_angles: tuple[float, ...] = (30.0, 140.0, 220.0, 330.0)
    rocker_angle: float = 162.0
    rocker_radius: float = 47.5
    nodemcu_x: float = -5.0
    ballast_angles: tuple[float, ...] = (184.0, 204.0)
    """M8 nuts on the deck, on the rocker's circle: without them the robot would balance on its axle."""
    ballast_post: float = 7.0
    """Fits an M8 nut's bore with its thread."""

    # Arena walls and start grid.
    arena_wall: float = 3.0
    arena_foot: float = 28.0
    """Width of the foot outside the wall."""
    arena_foot_height: float = 3.0
    template_thickness: float = 2.4
    template_arm: float = 84.0
    """From a node's centre to the end of its arm."""

    @property
    def axle_height(self) -> float:
        """Centre of the wheels above the floor."""
        return self.wheel_diameter / 2

    @property
    def groove_diameter(self) -> float:
        """Bottom of the O-ring groove: the ring, stretched at constant volume, then stands at the wheel's diameter."""
        free = self.tire_diameter - self.tire_section
        mounted = self.tire_section
        for _ in range(50):
            mounted = self.tire_section * math.sqrt(free / (self.wheel_diameter - mounted))
        return self.wheel_diameter - 2 * mounted

    @property
    def mounted_tire_section(self) -> float:
        """Cross section of the stretched O-ring."""
        return (self.wheel_diameter - self.groove_diameter) / 2

    @property
    def plate_bottom(self) -> float:
        """Underside of the body plate."""
        return self.axle_height - self.servo.width / 2 - self.servo_seat - self.seat_floor

    @property
    def plate_top(self) -> float:
        """Upper side of the body plate, around the servos' pocket."""
        return self.plate_bottom + self.plate_thickness

    @property
    def pillar_top(self) -> float:
        """Top of the servo pillars, on which the power tray lies."""
        return self.axle_height + self.servo.width / 2 + self.servo.play_width

    @property
    def deck_bottom(self) -> float:
        """Underside of the deck; the standoffs end there."""
        return self.plate_top + self.boss_height + self.standoff

    @property
    def deck_top(self) -> float:
        """Upper side of the deck, on which hat and carrier stand."""
        return self.deck_bottom + self.deck_thickness

    @property
    def deck_radius(self) -> float:
        """Outline of the deck."""
        return self.shield_radius - self.shield_wall - self.deck_gap

    @property
    def shield_top(self) -> float:
        """Upper edge of the bump shield."""
        return self.shield_bottom + self.shield_height

    @property
    def wheel_inner(self) -> float:
        """The left wheel's face towards the body."""
        return self.wheel_base / 2 - self.wheel_width / 2

    @property
    def wheel_outer(self) -> float:
        """The left wheel's face towards the encoder."""
        return self.wheel_base / 2 + self.wheel_width / 2

    @property
    def horn_outer(self) -> float:
        """Outer face of the left horn, on which the wheel's web sits."""
        return self.servo_back_gap + self.servo.turret + 0.25 + self.horn.height

    @property
    def disc_y(self) -> float:
        """Middle plane of the left encoder disc: the middle of the switch's gap."""
        return self.wheel_outer + self.switch_gap + self.switch.body / 2

    @property
    def switch_base(self) -> float:
        """Height of the switch's base, which looks up; its gap opens downwards over the disc."""
        return self.axle_height + self.track_radius + self.switch.beam_height

    @property
    def slot_width(self) -> float:
        """Width of a slot, and of a tooth, on the track."""
        return math.pi * self.track_radius / self.encoder_slots

    @property
    def tray_floor(self) -> float:
        """Underside of the battery tray."""
        return self.plate_bottom - self.boards.cell[2] - 0.7 - self.print.wall

    @property
    def cone_lower_edge(self) -> float:
        """Lower edge of the sensor's cone above the horizontal, degrees; negative: it falls."""
        return self.sensor_tilt - self.sensor_cone

    def cone_height(self, distance: float) -> float:
        """Height of the cone's lower edge at a distance from the sensor."""
        return self.sensor_height + distance * math.tan(math.radians(self.cone_lower_edge))

    @property
    def wall_clear_distance(self) -> float:
        """Distance from the sensor up to which the cone stays above the arena's wall; infinite if it never sinks to it."""
        slope = math.tan(math.radians(self.cone_lower_edge))
        return math.inf if slope >= 0 else (self.sensor_height - self.wall_height) / -slope

    @property
    def wall_plan(self) -> tuple[float, float, int, int]:
        """How printed walls close the arena: segment length, corner leg, segments on a long and on a short side.

        The longest segment that leaves room on the bed, such that both sides take a whole number of segments between equal corners.
        """
        long, short = max(self.arena), min(self.arena)
        best: tuple[float, float, int, int] | None = None
        for more in range(1, 40):
            length = (long - short) / more
            if not 40 <= length <= BED - 30:
                continue
            for along in range(1, int(short // length) + 1):
                leg = (short - along * length) / 2
                if 40 <= leg <= BED - self.arena_foot - 15 and (best is None or length > best[0]):
                    best = (length, leg, along + more, along)
        if best is None:
            raise ValueError(
                f"arena {long:g} x {short:g} mm: no equal segments of 40 to {BED - 30:g} mm close it; cut the walls from strip"
            )
        return best

    @property
    def template_links(self) -> tuple[float, float]:
        """Lengths of the bars between the start-grid template's nodes, along x and y."""
        return self.spacing[0] - 2 * self.template_arm, self.spacing[1] - 2 * self.template_arm


def hardware(robot: str = "hero_plus", world: str = "hero_plus") -> Hardware:
    """Return the dimensions of the hardware that belongs to a robot file and a world.

    Args:
        robot: A robot file's name or path.
        world: A world's name or path; its arena and start grid set walls and template.
    """
    return from_files(load_robot_file(robot), load_world(world))


def from_files(robot: dict[str, Any], world: WorldSpec) -> Hardware:
    """Return the dimensions for a robot file's values (SI units) and a world."""
    parts = robot["parts"]

    def mm(name: str) -> float:
        return round(1000 * float(parts[name]), 6)

    return Hardware(
        chassis_diameter=mm("chassis_diameter"),
        wheel_base=round(1000 * float(robot["drive"]["wheel_base"]), 6),
        wheel_diameter=mm("wheel_diameter"),
        rim_diameter=mm("wheel_rim_diameter"),
        tire_diameter=mm("wheel_tire_diameter"),
        encoder_ticks=int(parts["encoder_ticks"]),
        encoder_slots=int(parts["encoder_slots"]),
        track_radius=mm("encoder_track_radius"),
        shield_radius=mm("shield_outer_radius"),
        shield_height=mm("shield_height"),
        shield_bottom=mm("shield_ground_clearance"),
        sensor_height=mm("sensor_height"),
        sensor_forward=mm("sensor_forward"),
        sensor_tilt=math.degrees(parts["sensor_tilt"]),
        sensor_cone=math.degrees(parts["sensor_cone"]),
        hat_radius=round(1000 * float(robot["body"]["visible_radius"]), 6),
        hat_top=mm("hat_height"),
        wall_height=mm("wall_height"),
        arena=(round(1000 * world.size[0], 6), round(1000 * world.size[1], 6)),
        grid=(round(world.start.columns), round(world.start.rows)),
        spacing=(round(1000 * world.start.spacing_x, 6), round(1000 * world.start.spacing_y, 6)),
    )
