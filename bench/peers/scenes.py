"""Scenes of rigid bodies: the one source of their dimensions, for MuJoCo and for our world.

Metres, seconds, kg/m³, newtons; z is up, and the top of the table is at z = 0. A pose is x, y, z and the quaternion w,
i, j, k. Two surfaces of our world rub with the mean of their coefficients. Here all bodies of a scene, and the table
where they touch it, have the same one, and so has every pair.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

GRAVITY = 9.81
OUR_STEP = 1 / 240
"""The step of our world."""
TABLE_FRICTION = 0.6
"""That of our table."""
PALM_HALF, PALM_ABOVE = (0.020, 0.055, 0.015), 0.066
FINGER_HALF, FINGER_ABOVE, FINGER_MASS = (0.010, 0.006, 0.030), 0.018, 1.0
"""Our hand: half extents, and the centres above the tool centre point. physics.py holds them against our world."""
FINGER_FRICTION = 1.0
"""That of our fingers."""

Pose = tuple[float, float, float, float, float, float, float]


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Pose:
    """A pose that is pitched about y, and then turned about z, in radians."""
    cos_p, sin_p, cos_y, sin_y = (f(0.5 * angle) for angle in (pitch, yaw) for f in (math.cos, math.sin))
    return (x, y, z, cos_y * cos_p, -sin_y * sin_p, cos_y * sin_p, sin_y * cos_p)


def serde(place: Pose) -> dict[str, list[float]]:
    """The pose as our side reads it."""
    x, y, z, w, i, j, k = place
    return {"rotation": [i, j, k, w], "translation": [x, y, z]}


@dataclass(frozen=True)
class Part:
    """A cuboid of these half extents, or a ball of this radius, in the frame of its body."""

    half: tuple[float, float, float] | None = None
    radius: float = 0.0
    place: Pose = field(default_factory=pose)

    @property
    def volume(self) -> float:
        return 8 * math.prod(self.half) if self.half else 4 / 3 * math.pi * self.radius**3


@dataclass(frozen=True)
class Body:
    name: str
    parts: Sequence[Part]
    place: Pose
    friction: float
    density: float = 1000.0
    fixed: bool = False

    def question(self) -> dict[str, Any]:
        parts = [{"shape": {"Cuboid": {"half": part.half}} if part.half else {"Ball": {"radius": part.radius}},
                  "pose": serde(part.place), "density": self.density, "friction": self.friction, "solid": True}
                 for part in self.parts]
        return {"name": self.name, "fixed": self.fixed, "pose": serde(self.place), "parts": parts}


@dataclass(frozen=True)
class Beads:
    """Equal balls, at rest at these centres, shape (N, 3)."""

    centers: np.ndarray
    radius: float = 0.006
    density: float = 1000.0
    friction: float = 0.4
    damping: float = 2.0
    """The rate at which spinning dies away, 1/s."""

    @property
    def mass(self) -> float:
        return self.density * Part(radius=self.radius).volume

    def question(self) -> dict[str, Any]:
        beads = {"count": len(self.centers), "radius": self.radius, "density": self.density,
                 "friction": self.friction, "angular_damping": self.damping}
        return {"beads": beads, "centers": self.centers}


@dataclass(frozen=True)
class Slide:
    """A body slides along an axis of another, held by dry friction. The two do not collide."""

    parent: str
    child: str
    axis: tuple[float, float, float]
    travel: float
    friction: float

    def question(self) -> dict[str, Any]:
        return {"parent": self.parent, "object": self.child, "axis": self.axis, "travel": self.travel,
                "friction": self.friction}


Act = dict[str, Any]


def wait(seconds: float) -> Act:
    return {"wait": seconds}


def push(body: str, x: float, seconds: float) -> Act:
    """The body is carried along x on a path of the fifth order, at rest at both ends."""
    return {"push": {"body": body, "by": [x, 0.0, 0.0], "seconds": seconds}}


def move(place: Pose) -> Act:
    return {"move": serde(place)}


def close(newtons: float) -> Act:
    return {"close": newtons}


@dataclass(frozen=True)
class Phase:
    name: str
    acts: Sequence[Act]
    timed: bool = True


@dataclass(frozen=True)
class Scene:
    name: str
    title: str
    bodies: Sequence[Body]
    phases: Sequence[Phase]
    beads: Beads | None = None
    slides: Sequence[Slide] = ()
    hand: tuple[Pose, float] | None = None
    """Pose of the tool centre point and distance of the pads. Without one, our hand stands aside; MuJoCo has none."""
    held: str | None = None
    """The body that the hand takes."""
    iterations: int | None = None
    """Of our solver, where the tasks have other than the default."""

    def question(self, timed: int | None) -> dict[str, Any]:
        tcp, opening = self.hand or (pose(-1.0, 0.0, 0.3), 0.04)
        return {"physics": {
            "bodies": [body.question() for body in self.bodies], "beads": self.beads and self.beads.question(),
            "slides": [slide.question() for slide in self.slides],
            "hand": {"tcp": serde(tcp), "opening": opening},
            "iterations": self.iterations,
            "phases": [list(phase.acts) for phase in self.phases], "timed": timed}}

    @property
    def driven(self) -> str | None:
        """The body that is pushed."""
        acts = [act["push"]["body"] for phase in self.phases for act in phase.acts if "push" in act]
        return acts[0] if acts else None

    def body(self, name: str) -> int:
        return next(index for index, body in enumerate(self.bodies) if body.name == name)


BLOCK = Part((0.02, 0.02, 0.02))


def to_and_fro(body: str, reach: float, seconds: float, times: int) -> list[Act]:
    """To one side, across to the other so many times, and back."""
    acts = [push(body, reach, seconds)]
    acts += [push(body, 2 * reach * (-1) ** (index + 1), seconds) for index in range(times)]
    return [*acts, push(body, reach * (-1) ** (times + 1), seconds)]


def stack(shaken: bool) -> Scene:
    """Ten cubes of 40 mm, 64 g, every second one 4 mm aside: on the table, or on a plate that is moved to and fro."""
    plate = Body("plate", [Part((0.06, 0.06, 0.01))], pose(0, 0, 0.01), 0.6, fixed=True)
    ground = 0.02 if shaken else 0.0
    blocks = [Body(f"block {index}", [BLOCK], pose(0.004 * (index % 2), 0, ground + 0.02 + 0.04 * index), 0.6)
              for index in range(10)]
    if shaken:
        phases = [Phase("settling", [wait(1.0)], timed=False), Phase("shaken", to_and_fro("plate", 0.004, 0.5, 6))]
        return Scene("stack-shaken", "stack of ten blocks on a plate moved ± 4 mm", [plate, *blocks], phases)
    phases = [Phase("settling", [wait(1.0)]), Phase("at rest", [wait(10.0)])]
    return Scene("stack", "stack of ten blocks", blocks, phases)


SIDES, INNER, HEIGHT, WALL, FLARE = 16, 0.05, 0.10, 0.005, 0.2
"""A bowl: flat walls, radius of the room at the floor, height, thickness, lean of the walls in radians."""


def bowl() -> Body:
    """Sixteen leaning walls on a square floor, 1 mm above the table."""
    top = INNER + (HEIGHT - WALL) * math.tan(FLARE)
    width = (top + WALL) * math.tan(math.pi / SIDES)
    parts = [Part((INNER + WALL, INNER + WALL, 0.5 * WALL), place=pose(0, 0, 0.5 * WALL))]
    middle = 0.5 * HEIGHT
    out = INNER + (middle - WALL) * math.tan(FLARE) + 0.5 * WALL * math.cos(FLARE)
    for side in range(SIDES):
        yaw = 2 * math.pi * side / SIDES
        at = (out * math.cos(yaw), out * math.sin(yaw), middle - 0.5 * WALL * math.sin(FLARE))
        parts.append(Part((0.5 * WALL, width, 0.5 * HEIGHT / math.cos(FLARE)), place=pose(*at, FLARE, yaw)))
    return Body("bowl", parts, pose(0, 0, 0.001), 0.4, fixed=True)


def column(count: int, radius: float) -> np.ndarray:
    """Layers of a hexagonal lattice above the bowl's floor, every second one shifted; the lowest falls 30 mm."""
    pitch, reach = 2.1 * radius, 0.042
    row = 0.5 * math.sqrt(3) * pitch
    centers: list[tuple[float, float, float]] = []
    for layer in range(count):
        z = 0.001 + WALL + radius + 0.03 + layer * pitch
        for across in range(-6, 7):
            for along in range(-6, 7):
                x, y = (along + 0.5 * (across % 2)) * pitch, across * row + (2 / 3 * row if layer % 2 else 0)
                if math.hypot(x, y) <= reach and len(centers) < count:
                    centers.append((x, y, z))
    return np.array(centers)


def beads(count: int, shaken: bool) -> Scene:
    """Beads of 12 mm, 0.9 g, that fall into the bowl."""
    heap = Beads(column(count, Beads.radius))
    if shaken:
        phases = [Phase("falling", [wait(1.5)], timed=False), Phase("shaken", to_and_fro("bowl", 0.02, 0.2, 8))]
        return Scene(f"shaken-{count}", f"{count} beads in a bowl moved ± 20 mm", [bowl()], phases, heap)
    phases = [Phase("falling in", [wait(1.5)]), Phase("at rest", [wait(3.0)])]
    return Scene(f"beads-{count}", f"{count} beads in a bowl", [bowl()], phases, heap)


def gripper() -> Scene:
    """A cube of 40 mm, 64 g, held by a squeeze of 20 N."""
    up, x = 0.15, 0.1
    quarter = math.pi / 2
    swings = [move(pose(x + side, 0, up, quarter)) for side in (0.04, -0.04, 0.04, -0.04, 0.0)]
    phases = [Phase("grasp", [move(pose(x, 0, 0.028)), close(20.0), wait(0.5)]),
              Phase("lift", [move(pose(x, 0, up)), wait(0.25)]),
              Phase("tilt by 90°", [move(pose(x, 0, up, quarter)), wait(0.25)]),
              Phase("shake", swings), Phase("hold", [wait(3.0)])]
    cube = Body("cube", [BLOCK], pose(x, 0, 0.02), 0.6)
    return Scene("gripper", "gripper with a cube", [cube], phases, hand=(pose(x, 0, 0.15), 0.065), held="cube")


def drawer() -> Scene:
    """A drawer of 0.5 kg on a slide with 3 N of dry friction, pulled 100 mm by a fin that is squeezed with 10 N."""
    cabinet = Body("cabinet", [Part((0.10, 0.10, 0.005))], pose(0.1, 0, 0.005), 0.8, fixed=True)
    parts = [Part((0.10, 0.09, 0.01)), Part((0.022, 0.006, 0.018), place=pose(-0.122, 0, 0.02))]
    box = Body("drawer", parts, pose(0.1, 0, 0.05), 0.8, density=670.0)
    slide = Slide("cabinet", "drawer", (-1.0, 0.0, 0.0), 0.15, 3.0)
    at = -0.034
    phases = [Phase("grasp", [move(pose(at, 0, 0.085)), close(10.0), wait(0.5)]),
              Phase("pull", [move(pose(at - 0.1, 0, 0.085)), wait(0.25)])]
    return Scene("drawer", "gripper pulls a drawer", [cabinet, box], phases, slides=[slide],
                 hand=(pose(at, 0, 0.16), 0.05), held="drawer", iterations=12)


INCLINE_FRICTION = 0.5
SLAB = (0.5, 0.1, 0.02)


def on_slope(name: str, angle: float, part: Part, seconds: float) -> Scene:
    """Something on a slab that goes down towards x, by itself for so many seconds."""
    start, height = -0.3, SLAB[2] + (part.half[2] if part.half else part.radius)
    x = start * math.cos(angle) + height * math.sin(angle)
    z = 0.4 - start * math.sin(angle) + height * math.cos(angle)
    slab = Body("slab", [Part(SLAB)], pose(0, 0, 0.4, angle), INCLINE_FRICTION, fixed=True)
    thing = Body("thing", [part], pose(x, 0, z, angle), INCLINE_FRICTION)
    return Scene(name, name, [slab, thing], [Phase("by itself", [wait(seconds)])])


HOLDS, SLIDES, ROLLS = (math.atan(INCLINE_FRICTION) - math.radians(2), math.atan(INCLINE_FRICTION) + math.radians(2),
                        math.radians(10))
BALL = Part(radius=0.02)
FALLS = 0.25
"""Seconds of the free fall."""


def fall() -> Scene:
    """A ball falls from half a metre."""
    ball = Body("ball", [BALL], pose(0, 0, 0.52), 0.6)
    return Scene("fall", "fall", [ball], [Phase("falling", [wait(FALLS)]), Phase("rebounding", [wait(1.0)])])


def impact() -> Scene:
    """A ball falls on the side of another that lies on a slab, all without friction."""
    slab = Body("slab", [Part((0.3, 0.3, 0.02))], pose(0, 0, 0.3), 0.0, fixed=True)
    balls = [Body("lower", [BALL], pose(0, 0, 0.34), 0.0), Body("upper", [BALL], pose(0.012, 0, 0.40), 0.0)]
    return Scene("impact", "impact", [slab, *balls], [Phase("by itself", [wait(0.4)])])


SCENES: dict[str, Callable[[], Scene]] = {
    "stack": lambda: stack(False),
    "stack-shaken": lambda: stack(True),
    "beads-50": lambda: beads(50, False),
    "shaken-50": lambda: beads(50, True),
    "beads-200": lambda: beads(200, False),
    "shaken-200": lambda: beads(200, True),
    "gripper": gripper,
    "drawer": drawer,
}
ORACLES: dict[str, Callable[[], Scene]] = {
    "holds": lambda: on_slope("holds", HOLDS, BLOCK, 2.0),
    "slides": lambda: on_slope("slides", SLIDES, BLOCK, 1.0),
    "rolls": lambda: on_slope("rolls", ROLLS, BALL, 0.7),
    "fall": fall,
    "impact": impact,
}
"""Scenes whose course is known on paper."""
