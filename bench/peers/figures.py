"""What a simulation got right: poses in, figures out, by the same code for all.

A speed is the difference of two poses over the step between them, and the height that belongs to it is the mean of
both: with these, a free fall in steps keeps its energy exactly. What a soft contact stores is in no pose, so energy
that it gives back counts as gained. Contacts are flat or of balls; so two cuboids overlap by the least that any normal
of their faces shows.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from scenes import FALLS, GRAVITY, HOLDS, INCLINE_FRICTION, ROLLS, SLIDES, Body, Part, Scene

Figures = dict[str, float]
TABLE = Part((1.5, 1.5, 0.05), place=(0.0, 0.0, -0.05, 1.0, 0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Film:
    """What moved where: one frame before the first step and one after each. Places in metres, quaternions w first."""

    step: float
    """Seconds between frames."""
    poses: np.ndarray
    """Those of the bodies, and then of the beads, shape (frames, bodies + beads, 7)."""
    hand: np.ndarray
    """Pose of the tool centre point, distance of the pads, squeeze asked for, shape (frames, 9)."""
    steps: list[int]
    """Of each phase."""

    def end(self, phase: int) -> int:
        """The frame after the last step of a phase."""
        return sum(self.steps[:phase + 1])

    def span(self, phase: int) -> slice:
        """The frames of a phase, the one before its first step among them."""
        return slice(self.end(phase) - self.steps[phase], self.end(phase) + 1)


def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The products of quaternions, shape (..., 4)."""
    scalar = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def conjugate(a: np.ndarray) -> np.ndarray:
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def turned(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Vectors turned by quaternions, shapes (..., 4) and (..., 3)."""
    twice = 2 * np.cross(quaternion[..., 1:], vector)
    return vector + quaternion[..., :1] * twice + np.cross(quaternion[..., 1:], twice)


def compose(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Poses after one another, shape (..., 7)."""
    a, b = np.broadcast_arrays(a, b)
    place = a[..., :3] + turned(a[..., 3:], b[..., :3])
    return np.concatenate([place, times(a[..., 3:], b[..., 3:])], axis=-1)


def relative(frame: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Poses as seen from frames, shape (..., 7)."""
    back = conjugate(frame[..., 3:])
    place = turned(back, pose[..., :3] - frame[..., :3])
    return np.concatenate([place, times(back, pose[..., 3:])], axis=-1)


def angle(quaternion: np.ndarray) -> np.ndarray:
    """Angles of rotations in radians."""
    return 2 * np.arctan2(np.linalg.norm(quaternion[..., 1:], axis=-1), np.abs(quaternion[..., 0]))


def interpolated(poses: np.ndarray, step: float, at: np.ndarray) -> np.ndarray:
    """Poses at other times, along a smooth curve through those given; at rest before and after. Shape (frames, 7)."""
    poses = poses.copy()
    flips = np.cumprod(np.where(np.sum(poses[1:, 3:] * poses[:-1, 3:], axis=1) < 0, -1.0, 1.0))
    poses[1:, 3:] *= flips[:, None]
    curve = CubicSpline(step * np.arange(len(poses)), poses, bc_type="clamped")
    found = curve(np.clip(at, 0.0, step * (len(poses) - 1)))
    found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
    return found


def masses(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Mass and moments of inertia of all bodies and beads, shapes (N,) and (N, 3). What is fixed or slides has none."""
    sliding = {slide.child for slide in scene.slides}
    found: list[tuple[float, list[float]]] = []
    for body in scene.bodies:
        part = body.parts[0]
        mass = 0.0 if body.fixed or body.name in sliding else body.density * part.volume
        x, y, z = (half * half for half in part.half) if part.half else (0.6 * part.radius**2,) * 3
        found.append((mass, [mass / 3 * (y + z), mass / 3 * (x + z), mass / 3 * (x + y)]))
    if scene.beads:
        one = scene.beads.mass
        found += [(one, [0.4 * one * scene.beads.radius**2] * 3)] * len(scene.beads.centers)
    return np.array([mass for mass, _ in found]), np.array([inertia for _, inertia in found])


def energies(scene: Scene, film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Kinetic and potential energy in joules during each step, shapes (frames - 1,)."""
    mass, inertia = masses(scene)
    place, turn = film.poses[..., :3], film.poses[..., 3:]
    speed = np.diff(place, axis=0) / film.step
    spin = times(conjugate(turn[:-1]), turn[1:])
    spin = 2 * spin[..., 1:] * np.sign(spin[..., :1]) / film.step
    kinetic = 0.5 * (np.sum(speed**2, axis=2) @ mass + np.sum(spin**2 * inertia, axis=(1, 2)))
    height = 0.5 * (place[:-1, :, 2] + place[1:, :, 2])
    return kinetic, GRAVITY * height @ mass


def box_overlap(a: Part, pose_a: np.ndarray, b: Part, pose_b: np.ndarray) -> np.ndarray:
    """How deep two cuboids are in each other, metres, negative where they are apart. Poses have shape (frames, 7)."""
    frames = [compose(poses, np.array(part.place)) for part, poses in ((a, pose_a), (b, pose_b))]
    axes = [[turned(frame[..., 3:], unit) for unit in np.eye(3)] for frame in frames]
    apart = frames[1][..., :3] - frames[0][..., :3]
    overlaps = []
    for normal in axes[0] + axes[1]:
        reach = sum(half * np.abs(np.sum(axis * normal, axis=-1))
                    for part, of in zip((a, b), axes, strict=True) for half, axis in zip(part.half, of, strict=True))
        overlaps.append(reach - np.abs(np.sum(apart * normal, axis=-1)))
    return np.min(overlaps, axis=0)


def ball_overlap(center: np.ndarray, radius: float, part: Part, body: np.ndarray) -> np.ndarray:
    """How deep balls are in a cuboid, metres, negative where they are apart. Shapes (..., 3) and (7,)."""
    frame = compose(body, np.array(part.place))
    local = turned(conjugate(frame[3:]), center - frame[:3])
    outside = np.abs(local) - np.array(part.half)
    distance = np.linalg.norm(np.maximum(outside, 0), axis=-1) + np.minimum(outside.max(axis=-1), 0)
    return radius - distance


def beads_overlap(scene: Scene, frames: np.ndarray) -> float:
    """The deepest that any bead was in another or in the bowl, metres."""
    count = len(scene.bodies)
    deepest = -math.inf
    for frame in frames:
        centers = frame[count:, :3]
        walls = (ball_overlap(centers, scene.beads.radius, part, pose).max()
                 for body, pose in zip(scene.bodies, frame[:count], strict=True) for part in body.parts)
        square = np.sum(centers**2, axis=1)
        gaps = square[:, None] + square - 2 * centers @ centers.T
        np.fill_diagonal(gaps, math.inf)
        deepest = max(deepest, *walls, 2 * scene.beads.radius - math.sqrt(max(gaps.min(), 0.0)))
    return deepest


def beads_lost(scene: Scene, frame: np.ndarray) -> int:
    """How many beads are not inside the bowl: beyond the middle of its floor or of a wall."""
    [body] = scene.bodies
    local = relative(frame[0], frame[1:])[:, :3]
    floor, *walls = body.parts
    lost = local[:, 2] < floor.place[2]
    for wall in walls:
        outward = turned(np.array(wall.place[3:]), np.array([1.0, 0.0, 0.0]))
        lost |= (local - np.array(wall.place[:3])) @ outward > 0
    return int(lost.sum())


def of_stack(scene: Scene, film: Film) -> Figures:
    blocks = [index for index, body in enumerate(scene.bodies) if not body.fixed]
    span = film.span(1)
    poses = film.poses[span]
    first, last = blocks[0], blocks[-1]
    ground, under = ((TABLE, np.tile([0, 0, 0, 1.0, 0, 0, 0], (len(poses), 1))) if first == 0
                     else (scene.bodies[0].parts[0], poses[:, 0]))
    parts = [ground] + [scene.bodies[index].parts[0] for index in blocks]
    places = [under] + [poses[:, index] for index in blocks]
    deepest = max(box_overlap(*pair).max() for pair in
                  ((a, at, b, there) for a, at, b, there in zip(parts, places, parts[1:], places[1:])))
    seen = poses if first == 0 else relative(poses[:, :1], poses)
    drift = np.linalg.norm(seen[-1, blocks, :2] - seen[0, blocks, :2], axis=-1).max()
    found = {"deepest overlap, mm": 1e3 * deepest, "drift, mm": 1e3 * drift,
             "lean, °": math.degrees(angle(poses[-1, last, 3:]))}
    if first == 0:
        kinetic, _ = energies(scene, film)
        found["kinetic energy in the last second, µJ"] = 1e6 * kinetic[-round(1 / film.step):].max()
    return found


def of_beads(scene: Scene, film: Film) -> Figures:
    last = round(1 / film.step)
    kinetic, potential = energies(scene, film)
    total = kinetic + potential
    gained = (total - np.minimum.accumulate(total)).max()
    rest = film.poses[film.span(1)]
    moved = np.linalg.norm(rest[-1, :, :3] - rest[0, :, :3], axis=-1).max()
    every = max(1, last // 24)
    return {"beads lost": beads_lost(scene, film.poses[-1]),
            "deepest overlap at rest, mm": 1e3 * beads_overlap(scene, film.poses[-last::every]),
            "deepest overlap while falling in, mm": 1e3 * beads_overlap(scene, film.poses[film.span(0)]),
            "kinetic energy in the last second, µJ": 1e6 * kinetic[-last:].max(),
            "moved at rest, mm": 1e3 * moved,
            "energy gained, % of what was lost": 100 * gained / (total[0] - total.min())}


def of_shaken(scene: Scene, film: Film) -> Figures:
    kinetic, _ = energies(scene, film)
    return {"beads lost": beads_lost(scene, film.poses[-1]),
            "deepest overlap, mm": 1e3 * beads_overlap(scene, film.poses[film.span(1)]),
            "mean kinetic energy, mJ": 1e3 * kinetic[film.span(1).start:].mean()}


def in_hand(scene: Scene, film: Film) -> np.ndarray:
    """The pose of what is held as the hand sees it, shape (frames, 7)."""
    return relative(film.hand[:, :7], film.poses[:, scene.body(scene.held)])


def of_gripper(scene: Scene, film: Film) -> Figures:
    """By phase, the greatest distance from where the cube was in the hand when that had closed."""
    seen = in_hand(scene, film)
    found = {}
    taken = seen[film.end(0)]
    for index, phase in enumerate(scene.phases[1:], start=1):
        here = seen[film.span(index)]
        found[f"slip, {phase.name}, mm"] = 1e3 * np.linalg.norm(here[:, :3] - taken[:3], axis=1).max()
        found[f"turn, {phase.name}, °"] = math.degrees(angle(relative(taken, here)[:, 3:]).max())
    width = 2 * scene.bodies[0].parts[0].half[1]
    found["pads in the cube, mm a side"] = 1e3 * 0.5 * (width - film.hand[film.end(0):, 7]).max()
    return found


def of_drawer(scene: Scene, film: Film) -> Figures:
    seen = in_hand(scene, film)
    drawer, fin = film.poses[:, scene.body(scene.held)], scene.bodies[scene.body(scene.held)].parts[1]
    return {"pulled open, mm": 1e3 * (drawer[0, 0] - drawer[-1, 0]),
            "slip in the hand, mm": 1e3 * np.linalg.norm(seen[film.end(0):, :3] - seen[film.end(0), :3], axis=1).max(),
            "pads in the fin, mm a side": 1e3 * 0.5 * (2 * fin.half[1] - film.hand[film.end(0):, 7]).max()}


OF_SCENE: dict[str, Callable[[Scene, Film], Figures]] = {
    "stack": of_stack, "stack-shaken": of_stack, "beads-50": of_beads, "beads-200": of_beads,
    "shaken-50": of_shaken, "shaken-200": of_shaken, "gripper": of_gripper, "drawer": of_drawer,
}


def down_slope(film: Film) -> float:
    """How far the thing on the slab has come, metres along the slab."""
    seen = relative(film.poses[:, 0], film.poses[:, 1])
    return float(seen[-1, 0] - seen[0, 0])


def of_oracle(name: str, film: Film) -> Iterator[tuple[str, float, float]]:
    """What was found, and what is so on paper."""
    seconds = film.step * (len(film.poses) - 1)
    if name == "holds":
        yield "block on a slope 2° below the angle of friction: creeps in 2 s, mm", 1e3 * down_slope(film), 0.0
    elif name == "slides":
        pull = GRAVITY * (math.sin(SLIDES) - INCLINE_FRICTION * math.cos(SLIDES))
        yield "block on a slope 2° above it: slides in 1 s, mm", 1e3 * down_slope(film), 500 * pull * seconds**2
    elif name == "rolls":
        pull = 5 / 7 * GRAVITY * math.sin(ROLLS)
        yield "ball on a slope of 10°: rolls in 0.7 s, mm", 1e3 * down_slope(film), 500 * pull * seconds**2
    elif name == "fall":
        height = film.poses[:, 0, 2]
        done = film.steps[0] * film.step
        yield f"ball: falls in {FALLS} s, mm", 1e3 * (height[0] - height[film.end(0)]), 500 * GRAVITY * done**2
        low = int(np.argmin(height))
        yield "ball: is in the table at impact, mm", 1e3 * max(0.02 - height[low], 0.0), 0.0
        yield "ball: rebounds after a fall of 500 mm, mm", 1e3 * (height[low:].max() - 0.02), 0.0
    else:
        sideways = film.poses[:, 1:, 0]
        yield "two balls meet without friction: they part by, mm", 1e3 * abs(np.diff(sideways[-1])[0]), math.nan
        moved = sideways[-1].mean() - sideways[0].mean()
        yield "the same: their common centre moves sideways, mm", 1e3 * abs(moved), 0.0
