"""The scenes in MuJoCo, as somebody who knows it would build them.

Sources: the documentation in the package of mujoco 4.0.0, its chapters on tuning a simulation and on preventing slip
above all. By that, contacts of rigid things want a time constant of 4 to 10 ms and of two steps at least; a grasp wants
elliptic cones with `impratio` 10; two to four iterations are enough where speed matters; very many bodies want CG; a
moving container stands before what is in it; and piles want sleep. Each such choice is in one of the `WAYS`.

What differs from our world: MuJoCo solves a convex problem of soft contacts in double precision, to a tolerance. Ours
makes a few sweeps over contacts as stiff springs, in single precision, with four short steps in each. MuJoCo mixes
frictions by their maximum, ours by their mean, so the fingers here have the friction that a pair has there. Neither has
restitution: what rebounds, rebounds because a contact gives back what it has stored. The table is a plane here, and a
slab there. What spins is damped alike: a bead loses the same share of its spin in a second.

Nothing is kinematic in MuJoCo but mocap bodies, which have no speed in the eyes of a contact, so that nothing goes
along with them. So what our world moves (the hand, a shaken bowl) has joints here, of great inertia, which servos with
feed forward take along the same path: physics.py reads it from our answer, and holds the path that came out against it.
The fingers slide on joints that an equality couples, with motors that press with the squeeze that is asked for.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter_ns
from xml.etree import ElementTree as Xml

import mujoco
import numpy as np
from mujoco import rollout

from cases import Measure, in_process
from figures import Film, interpolated, turned
from scenes import (FINGER_ABOVE, FINGER_FRICTION, FINGER_HALF, FINGER_MASS, GRAVITY, OUR_STEP, PALM_ABOVE, PALM_HALF,
                    TABLE_FRICTION, Body, Part, Scene)

INERTIA = 50.0
"""Of what a servo moves, kg or kg m²: what it meets does not slow it down."""
SERVO = 100.0
"""The servo's rate, 1/s."""
FINGER_SPEED = 0.15
"""That of our fingers where they meet with nothing, m/s."""


@dataclass(frozen=True)
class Way:
    """Settings of MuJoCo."""

    name: str
    step: float = OUR_STEP
    elliptic: bool = True
    solver: str = "Newton"
    iterations: int = 100
    tolerance: float = 1e-8
    time_constant: float = 0.0
    """Of contacts, seconds; 0 for one that suits the step."""
    sparse: bool = False
    integrator: str = "implicitfast"
    noslip: int = 0
    impratio: float = 10.0
    sleep: bool = True


FINE = 0.002
"""MuJoCo's own step."""
_ELLIPTIC = Way("elliptic, Newton")
_PYRAMIDAL = Way("pyramidal, Newton", elliptic=False, impratio=1.0)
_BASES = [
    replace(_ELLIPTIC, name="elliptic, CG", solver="CG"),
    replace(_PYRAMIDAL, name="pyramidal, CG", solver="CG"),
    replace(_PYRAMIDAL, name="pyramidal, CG, tolerance 1e-5", solver="CG", tolerance=1e-5),
    replace(_PYRAMIDAL, name="pyramidal, CG, at most 20 iterations", solver="CG", iterations=20),
    replace(_PYRAMIDAL, name="pyramidal, CG, contacts of 20 ms", solver="CG", time_constant=0.02),
    replace(_ELLIPTIC, name="elliptic, CG, tolerance 1e-5", solver="CG", tolerance=1e-5),
    _PYRAMIDAL,
    replace(_PYRAMIDAL, name="pyramidal, Newton, at most 4 iterations", iterations=4),
    replace(_PYRAMIDAL, name="pyramidal, Newton, tolerance 1e-5", tolerance=1e-5),
    replace(_PYRAMIDAL, name="pyramidal, Newton, sparse, tolerance 1e-5", tolerance=1e-5, sparse=True),
    _ELLIPTIC,
    replace(_ELLIPTIC, name="elliptic, Newton, tolerance 1e-5", tolerance=1e-5),
    replace(_ELLIPTIC, name="elliptic, Newton, noslip 3", noslip=3),
    replace(_ELLIPTIC, name="elliptic, Newton, discrete", integrator="discrete"),
]
WAYS = [replace(way, name=f"{label}, {way.name}", step=step, time_constant=way.time_constant or constant)
        for label, step, constant in (("1/240 s", OUR_STEP, 0.01), ("2 ms", FINE, 0.005)) for way in _BASES]
WAYS.append(Way("2 ms, all defaults", FINE, elliptic=False, impratio=1.0, time_constant=0.02, integrator="Euler",
                sleep=False))


def text(numbers: object) -> str:
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


class Model:
    """A scene in MuJoCo, with a way of stepping it along what is driven."""

    def __init__(self, scene: Scene, way: Way, driven: Film) -> None:
        self.scene, self.way = scene, way
        self.model = mujoco.MjModel.from_xml_string(Xml.tostring(self.xml(), encoding="unicode"))
        if scene.beads:
            joint = self.model.joint("bead 0").dofadr[0]
            spin = self.model.dof_damping[joint:].reshape(-1, 6)[:, 3:]
            spin[:] = scene.beads.damping * 0.4 * scene.beads.mass * scene.beads.radius**2
        self.steps = [round(steps * driven.step / way.step) for steps in driven.steps]
        self.control = self.controls(driven)

    def xml(self) -> Xml.Element:
        way, scene = self.way, self.scene
        root = Xml.Element("mujoco")
        add_option(root, way)
        default = Xml.SubElement(root, "default")
        Xml.SubElement(default, "geom", solref=text([way.time_constant, 1]))
        Xml.SubElement(default, "equality", solref=text([way.time_constant, 1]))
        world, actuators = Xml.SubElement(root, "worldbody"), Xml.SubElement(root, "actuator")
        Xml.SubElement(world, "geom", type="plane", size="2 2 0.1", friction=text([TABLE_FRICTION, 0, 0]))
        if scene.hand:
            self.add_hand(root, world, actuators)
        for body in sorted(scene.bodies, key=lambda body: body.name != scene.driven):
            self.add_body(world, actuators, body)
        if scene.beads:
            ball, friction = Part(radius=scene.beads.radius), scene.beads.friction
            for index, center in enumerate(scene.beads.centers):
                bead = Xml.SubElement(world, "body", pos=text(center))
                Xml.SubElement(bead, "freejoint", name=f"bead {index}")
                add_part(bead, ball, friction, scene.beads.density)
        return root

    def add_body(self, world: Xml.Element, actuators: Xml.Element, body: Body) -> None:
        element = Xml.SubElement(world, "body", name=body.name, pos=text(body.place[:3]), quat=text(body.place[3:]))
        slide = next((slide for slide in self.scene.slides if slide.child == body.name), None)
        if slide:
            Xml.SubElement(element, "joint", type="slide", name=body.name, axis=text(slide.axis), limited="true",
                           range=text([0, slide.travel]), frictionloss=text(slide.friction))
        elif body.name == self.scene.driven:
            add_servo(element, actuators, body.name, "slide", (1, 0, 0))
            element.set("gravcomp", "1")
        elif not body.fixed:
            Xml.SubElement(element, "freejoint", name=body.name)
        for part in body.parts:
            add_part(element, part, body.friction, body.density)

    def add_hand(self, root: Xml.Element, world: Xml.Element, actuators: Xml.Element) -> None:
        tcp, opening = self.scene.hand
        held = self.scene.bodies[self.scene.body(self.scene.held)]
        friction = text([0.5 * (FINGER_FRICTION + held.friction), 0, 0])
        hand = Xml.SubElement(world, "body", name="hand", pos=text(tcp[:3]), quat=text(tcp[3:]), gravcomp="1")
        for name, kind, axis in (("hand x", "slide", (1, 0, 0)), ("hand z", "slide", (0, 0, 1)),
                                 ("hand pitch", "hinge", (0, 1, 0))):
            add_servo(hand, actuators, name, kind, axis)
        Xml.SubElement(hand, "geom", type="box", size=text(PALM_HALF), pos=text([0, 0, PALM_ABOVE]), mass="1",
                       friction=friction)
        squeeze = max(act["close"] for phase in self.scene.phases for act in phase.acts if "close" in act)
        for name, side in (("left", 1), ("right", -1)):
            at = [0, side * (0.5 * opening + FINGER_HALF[1]), FINGER_ABOVE]
            finger = Xml.SubElement(hand, "body", name=name, pos=text(at), gravcomp="1")
            Xml.SubElement(finger, "joint", type="slide", name=name, axis=text([0, -side, 0]),
                           damping=text(squeeze / FINGER_SPEED))
            Xml.SubElement(finger, "geom", type="box", size=text(FINGER_HALF), mass=text(FINGER_MASS),
                           friction=friction)
            Xml.SubElement(actuators, "motor", joint=name, name=name)
        Xml.SubElement(Xml.SubElement(root, "equality"), "joint", joint1="left", joint2="right")
        Xml.SubElement(Xml.SubElement(root, "contact"), "exclude", body1="left", body2="right")

    def controls(self, driven: Film) -> np.ndarray:
        """What the actuators are told before each step, shape (steps, actuators)."""
        count = sum(self.steps)
        if not self.model.nu:
            return np.zeros((count, 0))
        wanted, columns = {}, {}
        times = np.arange(-1, count + 1) * self.way.step
        if self.scene.driven:
            poses = interpolated(driven.poses[:, self.scene.body(self.scene.driven)], driven.step, times)
            wanted[self.scene.driven] = poses[:, 0] - poses[0, 0]
        if self.scene.hand:
            tcp = interpolated(driven.hand[:, :7], driven.step, times)
            wanted |= {"hand x": tcp[:, 0] - tcp[0, 0], "hand z": tcp[:, 2] - tcp[0, 2],
                       "hand pitch": 2 * np.arctan2(tcp[:, 5], tcp[:, 3])}
            squeeze = driven.hand[1:, 8]
            index = np.minimum((times[1:-1] / driven.step + 1e-9).astype(int), len(squeeze) - 1)
            columns |= {"left": squeeze[index], "right": squeeze[index]}
        for name, path in wanted.items():
            speed = np.diff(path)[1:] / self.way.step
            columns[f"{name} place"], columns[f"{name} speed"] = path[1:-1], speed
            columns[f"{name} force"] = INERTIA * np.diff(path, 2) / self.way.step**2
        names = [self.model.actuator(index).name for index in range(self.model.nu)]
        return np.stack([columns[name] for name in names], axis=1)

    def film(self, patience: float) -> tuple[Film, list[float]] | None:
        """What moves where, and the milliseconds of each phase (with what recording takes).

        Nothing where all phases together take longer than `patience`, in milliseconds.
        """
        data = mujoco.MjData(self.model)
        places, milliseconds, at = [data.qpos.copy()], [], 0
        for steps in self.steps:
            start = perf_counter_ns()
            for control in self.control[at:at + steps]:
                data.ctrl[:] = control
                mujoco.mj_step(self.model, data)
                places.append(data.qpos.copy())
                if sum(milliseconds) + (perf_counter_ns() - start) / 1e6 > patience:
                    return None
            milliseconds.append((perf_counter_ns() - start) / 1e6)
            at += steps
        return self.poses(np.array(places)), milliseconds

    def poses(self, places: np.ndarray) -> Film:
        """The poses at these positions of the joints, shape (frames, nq)."""
        poses = []
        for body in self.scene.bodies:
            joint = None
            if not body.fixed or body.name == self.scene.driven:
                joint = self.model.joint(body.name)
                columns = places[:, joint.qposadr[0]:joint.qposadr[0] + (7 if joint.type[0] == 0 else 1)]
            if joint is None:
                poses.append(np.tile(body.place, (len(places), 1)))
            elif columns.shape[1] == 7:
                poses.append(columns)
            else:
                moved = np.tile(body.place, (len(places), 1))
                moved[:, :3] += columns * turned(np.array(body.place[3:]), joint_axis(self.model, body.name))
                poses.append(moved)
        if self.scene.beads:
            first = self.model.joint("bead 0").qposadr[0]
            poses += list(places[:, first:].reshape(len(places), -1, 7).swapaxes(0, 1))
        return Film(self.way.step, np.stack(poses, axis=1), self.hands(places), self.steps)

    def hands(self, places: np.ndarray) -> np.ndarray:
        if not self.scene.hand:
            return np.zeros((len(places), 9))
        tcp, opening = self.scene.hand
        of = {name: places[:, self.model.joint(name).qposadr[0]]
              for name in ("hand x", "hand z", "hand pitch", "left", "right")}
        zero = np.zeros(len(places))
        half = 0.5 * of["hand pitch"]
        columns = [tcp[0] + of["hand x"], tcp[1] + zero, tcp[2] + of["hand z"], np.cos(half), zero, np.sin(half), zero,
                   opening - of["left"] - of["right"], zero]
        return np.stack(columns, axis=1)

    def phase(self, index: int) -> Measure:
        """Measures a phase, stepped through in one loop in C. The value is the positions of the joints at its end."""
        first, steps = sum(self.steps[:index]), self.steps[index]
        start = mujoco.MjData(self.model)
        for control in self.control[:first]:
            start.ctrl[:] = control
            mujoco.mj_step(self.model, start)
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS
        state = np.empty((1, mujoco.mj_stateSize(self.model, full)))
        mujoco.mj_getState(self.model, start, state[0], full)
        controls = self.control[None, first:first + steps].copy()

        def free() -> Callable[[], np.ndarray]:
            data = mujoco.MjData(self.model)
            mujoco.mj_copyData(data, self.model, start)

            def work() -> np.ndarray:
                mujoco.mj_step(self.model, data, steps)
                return data.qpos

            return work

        def driven() -> Callable[[], np.ndarray]:
            data = mujoco.MjData(self.model)
            mujoco.mj_copyData(data, self.model, start)
            states, warm = np.empty((1, steps, state.shape[1])), start.qacc_warmstart[None].copy()

            def work() -> np.ndarray:
                rollout.rollout(self.model, data, state, controls, nstep=steps, state=states, initial_warmstart=warm)
                return states[0, -1, 1:1 + self.model.nq]

            return work

        return in_process(driven if self.model.nu else free, lambda places: {"places": places})


def joint_axis(model: mujoco.MjModel, name: str) -> np.ndarray:
    return np.array(model.joint(name).axis)


def add_option(root: Xml.Element, way: Way) -> None:
    cone = "elliptic" if way.elliptic else "pyramidal"
    option = Xml.SubElement(root, "option", timestep=text(way.step), cone=cone, solver=way.solver,
                            iterations=str(way.iterations), tolerance=repr(way.tolerance), integrator=way.integrator,
                            noslip_iterations=str(way.noslip), impratio=text(way.impratio),
                            jacobian="sparse" if way.sparse else "auto", gravity=text([0, 0, -GRAVITY]))
    Xml.SubElement(option, "flag", sleep="enable" if way.sleep else "disable")


def add_part(body: Xml.Element, part: Part, friction: float, density: float) -> None:
    shape = {"type": "box", "size": text(part.half)} if part.half else {"type": "sphere", "size": text(part.radius)}
    # Without friction a contact has a normal only.
    Xml.SubElement(body, "geom", shape, pos=text(part.place[:3]), quat=text(part.place[3:]), density=text(density),
                   friction=text([friction, 0, 0]), condim="3" if friction else "1")


def add_servo(body: Xml.Element, actuators: Xml.Element, name: str, kind: str, axis: tuple[int, int, int]) -> None:
    """A joint with great inertia that is told place, speed and force."""
    Xml.SubElement(body, "joint", type=kind, name=name, axis=text(axis), armature=text(INERTIA))
    # Both gains are those of a critically damped servo; the damping is in the speed's actuator.
    Xml.SubElement(actuators, "position", joint=name, name=f"{name} place", kp=text(INERTIA * SERVO**2))
    Xml.SubElement(actuators, "velocity", joint=name, name=f"{name} speed", kv=text(2 * INERTIA * SERVO))
    Xml.SubElement(actuators, "motor", joint=name, name=f"{name} force")
