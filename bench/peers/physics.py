"""MuJoCo and our world on the same scenes: how long the phases take, and what each gets right.

Both sides get their scene from scenes.py and go through the same seconds: MuJoCo with our step of 1/240 s, and with its
own of 2 ms, since 1/240 s is more than its documentation advises where something is grasped. Both put away what rests.
Our side is the world as the tasks use it, and its hand is always there. Each side steps on one thread through a phase
in a loop of its own language, from a copy of the state at the phase's start. The copying is not timed.

First each way of MuJoCo (mujoco_world.py) does the whole scene once. Among those that get the scene right, by the
limits below, the fastest of each step size is timed. A way that takes `PATIENCE` times as long as a right one is given
up. If no way gets it right, the one that is least beyond a limit is timed, and the table says so. Then both take turns.
A timed phase must end, on either side, in the very state that the figures were made of. Our figures must be finite and
within the limits.

figures.py makes the figures of poses, by the same code for all. How the two differ is told in mujoco_world.py.
"""

import math
import statistics
import sys
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from figures import OF_SCENE, Figures, Film, of_oracle
from mujoco_world import WAYS, Model, Way
from programs import Program
from rounds import Row
from scenes import FINGER_ABOVE, FINGER_HALF, OUR_STEP, ORACLES, PALM_ABOVE, PALM_HALF, SCENES, Scene
from values import Disagreement

PATIENCE = 1.3
ON_PATH = 1e-3
"""How far what MuJoCo's servos move may be from our path, metres."""
LIMITS: dict[str, dict[str, float]] = {
    "stack": {"deepest overlap, mm": 0.5, "drift, mm": 1.0, "lean, °": 1.0,
              "kinetic energy in the last second, µJ": 10.0},
    "stack-shaken": {"deepest overlap, mm": 0.5, "drift, mm": 2.0, "lean, °": 1.0},
    "beads": {"beads lost": 0.0, "deepest overlap at rest, mm": 0.6, "kinetic energy in the last second, µJ": 10.0,
              "energy gained, % of what was lost": 5.0},
    "shaken": {"beads lost": 0.0, "deepest overlap, mm": 3.0},
    "gripper": {f"{motion}, {phase}, {unit}": limit for phase in ("lift", "tilt by 90°", "shake", "hold")
                for motion, unit, limit in (("slip", "mm", 2.0), ("turn", "°", 1.2))}
    | {"pads in the cube, mm a side": 1.0},
    "drawer": {"slip in the hand, mm": 2.0, "pads in the fin, mm a side": 1.0},
}
"""The greatest figures with which a scene counts as right: beads overlap by a tenth of their radius at rest, and by
half of it when shaken; the slip in the hand is that of our own tests."""
ORACLE_LIMITS = {"creeps": 0.1, "slides": 5.0, "rolls": 3.0, "falls": 6.0, "impact": 1.0, "rebounds": 1.0,
                 "centre": 0.1}
"""How far ours may be from what is so on paper, millimetres. A step of 1/240 s adds up to 5 mm to the fall."""


def limits(scene: str) -> dict[str, float]:
    return LIMITS.get(scene) or LIMITS[scene.partition("-")[0]]


@dataclass(frozen=True)
class Trial:
    """A scene done once in one way."""

    way: Way
    milliseconds: float | None
    """Of the timed phases; none where it was given up."""
    whole: float
    """The milliseconds of all phases."""
    figures: Figures
    beyond: str
    """The first figure that is not within its limit; empty where all are."""
    excess: float
    """The greatest of figure over limit."""
    off_path: float
    """How far what is driven was from our path, metres."""

    @property
    def right(self) -> bool:
        return self.milliseconds is not None and not self.beyond


@dataclass(frozen=True)
class Result:
    scene: Scene
    ours: Figures
    trials: list[Trial]
    chosen: list[Trial]
    """One for each step size."""
    rows: list[tuple[str, float, Row]]
    """Phase, simulated seconds and times, for each timed phase and chosen trial."""


@dataclass(frozen=True)
class Oracle:
    """What was found beside what is so on paper: ours, and by the step size of MuJoCo."""

    name: str
    paper: float
    ours: float
    peers: list[float]


def filmed(scene: Scene, program: Program) -> Film:
    """What moves where in our world."""
    values = program.measure(scene.question(None))(0.0).values()
    count = len(scene.bodies) + (len(scene.beads.centers) if scene.beads else 0)
    film = Film(OUR_STEP, values["poses"].reshape(-1, count, 7), values["hand"].reshape(-1, 9),
                [int(steps) for steps in values["steps"]])
    if not all(np.isfinite(numbers).all() for numbers in (film.poses, film.hand)):
        raise Disagreement(f"{scene.name}: ours has a pose that is not finite")
    if scene.hand:
        (x, y, z, *_), low, high = scene.hand[0], *values["bounds"].reshape(2, 3)
        wide, deep, tall = PALM_HALF
        expected = [x - wide, y - deep, z + FINGER_ABOVE - FINGER_HALF[2], x + wide, y + deep, z + PALM_ABOVE + tall]
        for index in np.flatnonzero(np.abs(np.concatenate([low, high]) - expected) > 1e-6)[:1]:
            raise Disagreement(f"{scene.name}: our hand is not as in scenes.py: side {index} of the box that holds it")
    return film


def judged(scene: str, figures: Figures) -> tuple[str, float]:
    """The first figure beyond its limit, and the greatest of figure over limit."""
    beyond, excess = "", 0.0
    for name, limit in limits(scene).items():
        if not figures[name] <= limit:
            beyond = beyond or name
        excess = max(excess, figures[name] / limit if limit else figures[name])
    return beyond, excess if math.isfinite(excess) else math.inf


def attempt(scene: Scene, way: Way, driven: Film, patience: float) -> tuple[Trial, Film | None]:
    """The scene once in one way of MuJoCo."""
    done = Model(scene, way, driven).film(patience)
    if done is None:
        return Trial(way, None, patience, {}, "given up", math.inf, 0.0), None
    film, milliseconds = done
    figures = OF_SCENE[scene.name](scene, film)
    off = max(off_path(scene, film, driven, phase) for phase in range(len(scene.phases)))
    timed = sum(time for time, phase in zip(milliseconds, scene.phases, strict=True) if phase.timed)
    beyond, excess = judged(scene.name, figures)
    return Trial(way, timed, sum(milliseconds), figures, beyond, excess, off), film


def off_path(scene: Scene, film: Film, driven: Film, phase: int) -> float:
    """How far what MuJoCo's servos move is from our path at the end of a phase, metres."""
    there, here = film.end(phase), driven.end(phase)
    off = np.abs(film.hand[there, :3] - driven.hand[here, :3]).max() if scene.hand else 0.0
    if scene.driven:
        index = scene.body(scene.driven)
        off = max(off, np.abs(film.poses[there, index, :3] - driven.poses[here, index, :3]).max())
    return float(off)


def choose(scene: Scene, ours: Film) -> tuple[list[Trial], list[tuple[Trial, Film]]]:
    """All ways once; and for each step size the fastest that is right, else the one that is least wrong."""
    trials, chosen = [], []
    for _, ways in groupby(WAYS, key=lambda way: way.step):
        patience, tried = math.inf, []
        for way in ways:
            trial, film = attempt(scene, way, ours, patience)
            trials.append(trial)
            if film is not None:
                tried.append((trial, film))
            if trial.right:
                patience = min(patience, PATIENCE * trial.whole)
        best = min(tried, key=lambda of: (not of[0].right, of[0].milliseconds if of[0].right else of[0].excess))
        if not best[0].off_path <= ON_PATH:
            raise Disagreement(f"{scene.name} ({best[0].way.name}): the servos are {best[0].off_path} m off our path")
        chosen.append(best)
    return trials, chosen


def run(name: str, program: Program, rounds: int, seconds: float) -> Result:
    """Does a scene on both sides, checks ours, and times the phases in turns. Raises `Disagreement`."""
    scene = SCENES[name]()
    ours = filmed(scene, program)
    figures = OF_SCENE[name](scene, ours)
    beyond, _ = judged(name, figures)
    for wrong in [key for key, value in figures.items() if not math.isfinite(value)] + [beyond] * bool(beyond):
        raise Disagreement(f"{name}: {wrong}: ours has {figures[wrong]}, and the limit is {limits(name).get(wrong)}")
    trials, chosen = choose(scene, ours)
    rows = []
    for index, phase in enumerate(scene.phases):
        if phase.timed:
            rows += turns(scene, index, program, ours, chosen, (rounds, seconds))
    return Result(scene, figures, trials, [trial for trial, _ in chosen], rows)


def turns(scene: Scene, index: int, program: Program, ours: Film, chosen: list[tuple[Trial, Film]],
          effort: tuple[int, float]) -> list[tuple[str, float, Row]]:
    """Times a phase on all sides in turns, for so many rounds and so many seconds in each."""
    phase, (rounds, seconds) = scene.phases[index], effort
    ourselves = program.measure(scene.question(index))
    models = [Model(scene, trial.way, ours) for trial, _ in chosen]
    peers = [model.phase(index) for model in models]
    our_times: list[float] = []
    peer_times: list[list[float]] = [[] for _ in peers]
    for _ in range(rounds):
        for model, (trial, film), measure, taken in zip(models, chosen, peers, peer_times, strict=True):
            measured = measure(seconds)
            taken.append(measured.milliseconds)
            end = model.poses(measured.values()["places"][None]).poses[0]
            same(f"{scene.name}, {phase.name} ({trial.way.name})", end, film.poses[film.end(index)], 1e-6)
        measured = ourselves(seconds)
        our_times.append(measured.milliseconds)
        end = measured.values()["poses"].reshape(ours.poses.shape[1:])
        same(f"{scene.name}, {phase.name} (ours)", end, ours.poses[ours.end(index)], 0.0)
    rows = [Row(scene.title, "mujoco", trial.way.name, taken, our_times, {})
            for (trial, _), taken in zip(chosen, peer_times, strict=True)]
    for row in rows:
        print(f"{scene.name}, {phase.name}: {row.way}: {statistics.median(row.ratios):.3g} ×", file=sys.stderr)
    return [(phase.name, ours.steps[index] * OUR_STEP, row) for row in rows]


def same(what: str, found: np.ndarray, expected: np.ndarray, allowed: float) -> None:
    """Raises `Disagreement` where a timed phase ended elsewhere than the one that was recorded."""
    apart = np.abs(found - expected)
    for index in np.flatnonzero(~(apart <= allowed))[:1]:
        raise Disagreement(f"{what}: number {index} of the poses at its end: {found.flat[index]} where it was timed, "
                           f"{expected.flat[index]} where it was recorded")


PLAIN = [next(way for way in WAYS if way.name == f"{step}, elliptic, Newton") for step in ("1/240 s", "2 ms")]
"""The ways that are held against paper."""


def oracles(program: Program) -> list[Oracle]:
    """Scenes whose course is known on paper. Raises `Disagreement` where ours is too far off."""
    found = []
    for name, make in ORACLES.items():
        scene = make()
        ours = filmed(scene, program)
        films = [Model(scene, way, ours).film(math.inf)[0] for way in PLAIN]
        for (what, value, paper), *peers in zip(of_oracle(name, ours), *(of_oracle(name, film) for film in films)):
            limit = next((limit for key, limit in ORACLE_LIMITS.items() if key in what), None)
            if not math.isfinite(value) or limit is not None and not abs(value - paper) <= limit:
                raise Disagreement(f"{what}: ours has {value}, {paper} is so on paper, and {limit} apart is allowed")
            found.append(Oracle(what, float(paper), float(value), [float(peer) for _, peer, _ in peers]))
    return found
