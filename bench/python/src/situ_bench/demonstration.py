"""Demonstrations: what a teacher shows, as `situ-bench` writes and reads it.

Positions are in metres, quaternions in the order w, x, y, z and of length 1, and poses in the world frame where nothing
else is said. A keyframe's `state` is the world before the motion to it.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
State = list[float]

#: The command to a gripper: an opening from 0 (closed) to 1 (open), `{"open": metres}` or `{"close": newtons}`.
Gripper = Union[float, dict[str, float]]


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@dataclass(frozen=True)
class Pose:
    """A rigid pose. `a * b` is `b`, given in the frame `a`, in the frame that `a` is given in.

    The operations are those of the benchmark, in its order, so that the same numbers come out to the last bit.
    """

    position: Vector
    quaternion: Quaternion

    def rotate(self, vector: Vector) -> Vector:
        """The vector, turned as this pose is turned."""
        w, *rest = self.quaternion
        axis = (rest[0], rest[1], rest[2])
        x, y, z = _cross(axis, vector)
        t = (x * 2.0, y * 2.0, z * 2.0)
        c = _cross(axis, t)
        return (t[0] * w + c[0] + vector[0], t[1] * w + c[1] + vector[1], t[2] * w + c[2] + vector[2])

    def inverse(self) -> Pose:
        """The frame in which this pose is given, in the frame of this pose."""
        w, x, y, z = self.quaternion
        turned = Pose((0.0, 0.0, 0.0), (w, -x, -y, -z))
        px, py, pz = self.position
        return Pose(turned.rotate((-px, -py, -pz)), turned.quaternion)

    def __mul__(self, other: Pose) -> Pose:
        shift = self.rotate(other.position)
        position = (self.position[0] + shift[0], self.position[1] + shift[1], self.position[2] + shift[2])
        aw, ax, ay, az = self.quaternion
        bw, bx, by, bz = other.quaternion
        quaternion = (
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        )
        return Pose(position, quaternion)

    @classmethod
    def of(cls, value: dict[str, Any]) -> Pose:
        """From its keys in a demonstration."""
        x, y, z = value["position"]
        w, i, j, k = value["quaternion"]
        return cls((x, y, z), (w, i, j, k))

    def keys(self) -> dict[str, Any]:
        """Its keys in a demonstration."""
        return {"position": list(self.position), "quaternion": list(self.quaternion)}


@dataclass(frozen=True)
class Keyframe:
    """A keyframe of a demonstration."""

    #: The object that it is about.
    reference: str
    #: The object's pose.
    reference_pose: Pose
    #: The hand's pose.
    gripper_pose: Pose
    #: The command to the gripper from here on.
    gripper: Gripper
    #: The world before the motion to it; empty where the file gives poses, from which the program derives it.
    state: State
    #: Seconds of rest.
    hold: float = 0.0
    #: Whether the object is named anew here, so that a segment begins.
    announced: bool = False
    #: The teacher's name for the skill, where the teacher says one.
    narration: str | None = None
    #: In a file of version 2: the poses of all objects and of the hand before the motion to it, as the file has them.
    world: dict[str, Any] | None = None


@dataclass(frozen=True)
class Segment:
    """Consecutive keyframes about one object."""

    reference: str
    #: The world in which it begins.
    start: State
    #: The object's pose at its first keyframe.
    frame: Pose
    keyframes: list[Keyframe]

    def relative(self) -> list[Pose]:
        """The hand's poses in the frame that the object had at the first keyframe."""
        inverse = self.frame.inverse()
        return [inverse * keyframe.gripper_pose for keyframe in self.keyframes]


@dataclass(frozen=True)
class Demonstration:
    """A demonstration: the whole task (`original`), or a part of it given at a failure (`corrective`)."""

    name: str
    kind: str
    keyframes: list[Keyframe]
    #: The world after the last keyframe; empty where the file gives poses.
    final_state: State
    #: Whether it went on to the end of the task.
    carried_to_end: bool
    #: The keys of a file that a method is not told here: schema, what ran before, and so on.
    others: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, value: dict[str, Any]) -> Demonstration:
        """From its keys."""
        keyframes = [
            Keyframe(
                reference=keyframe["reference"],
                reference_pose=Pose.of(
                    keyframe["world"]["objects"][keyframe["reference"]]
                    if "world" in keyframe
                    else keyframe["reference_pose"]
                ),
                gripper_pose=Pose.of(keyframe["gripper_pose"]),
                gripper=keyframe["gripper"],
                state=keyframe.get("state", []) if "world" in keyframe else keyframe["state"],
                hold=keyframe.get("hold", 0.0),
                announced=keyframe.get("announced", False),
                narration=keyframe.get("narration"),
                world=keyframe.get("world"),
            )
            for keyframe in value["keyframes"]
        ]
        known = {"name", "kind", "keyframes", "final_state", "carried_to_end"}
        others = {key: other for key, other in value.items() if key not in known}
        final_state = [] if "final_world" in value else value["final_state"]
        return cls(value["name"], value["kind"], keyframes, final_state, value["carried_to_end"], others)

    def keys(self) -> dict[str, Any]:
        """Its keys."""
        keyframes = []
        for keyframe in self.keyframes:
            keys: dict[str, Any] = {
                "reference": keyframe.reference,
                "gripper_pose": keyframe.gripper_pose.keys(),
                "gripper": keyframe.gripper,
                "hold": keyframe.hold,
            }
            if keyframe.world is None:
                keys.update(reference_pose=keyframe.reference_pose.keys(), state=keyframe.state)
            else:
                keys["world"] = keyframe.world
            if keyframe.announced:
                keys["announced"] = True
            if keyframe.narration is not None:
                keys["narration"] = keyframe.narration
            keyframes.append(keys)
        shown: dict[str, Any] = {"carried_to_end": self.carried_to_end, "keyframes": keyframes}
        if "final_world" not in self.others:
            shown["final_state"] = self.final_state
        return {"name": self.name, "kind": self.kind, **self.others, **shown}

    def segments(self) -> list[Segment]:
        """Cut where the teacher names an object: another one, or the same one anew."""
        runs: list[list[Keyframe]] = []
        for keyframe in self.keyframes:
            if runs and runs[-1][-1].reference == keyframe.reference and not keyframe.announced:
                runs[-1].append(keyframe)
            else:
                runs.append([keyframe])
        return [Segment(run[0].reference, run[0].state, run[0].reference_pose, run) for run in runs]


def read_demonstration(path: str | Path) -> Demonstration:
    """A demonstration file of `situ-bench`."""
    return Demonstration.of(json.loads(Path(path).read_text(encoding="utf-8-sig")))


def write_demonstration(path: str | Path, demonstration: Demonstration) -> None:
    """Writes a demonstration file. `others` must hold what ran before it (`after`), and its `schema`.

    Where its keyframes have a `world`, `version` (2) and `final_world` stand in the place of the schema.
    """
    has_worlds = any(keyframe.world is not None for keyframe in demonstration.keyframes)
    needed = {"version", "final_world", "after"} if has_worlds else {"schema", "after"}
    missing = needed - demonstration.others.keys()
    if missing:
        raise ValueError(f"a demonstration file needs {sorted(missing)}: give them in `others`")
    Path(path).write_text(json.dumps(demonstration.keys(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
