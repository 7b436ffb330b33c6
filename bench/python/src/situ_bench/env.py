"""The tasks as environments of Gymnasium: one step is one keyframe, done by the arm, the gripper and the physics of the
benchmark.

    import gymnasium
    import situ_bench.env

    env = gymnasium.make("situ_bench/pour-lid-v1")

`bench/docs/serve.md` says what a step means. This module needs gymnasium and numpy; the rest of the package does not.
"""

from __future__ import annotations

import base64
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Optional

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from .client import Client, ServeError
from .demonstration import Demonstration, Pose

#: The version of the environments.
VERSION = 1
#: A scaled feature is never beyond this while the physics is sound: nothing is further than 50 m from the table.
MOST_SCALES = 1000.0
#: A step to where the hand is already, with the gripper as it is, waits for so many seconds.
WAIT = 0.5
#: The hand is there already where it is this near: metres, and radians.
NEAR = (1e-3, 1e-2)
#: A start that the physics refuses is drawn again so often, where no seed was given.
TRIES = 20

Floats = NDArray[np.float64]


def _quaternion(turn: Sequence[float]) -> list[float]:
    """The quaternion w, x, y, z of a rotation vector, radians."""
    x, y, z = turn
    angle = math.sqrt(x * x + y * y + z * z)
    share = 0.5 if angle == 0.0 else math.sin(0.5 * angle) / angle
    return [math.cos(0.5 * angle), x * share, y * share, z * share]


def _turn(quaternion: Sequence[float]) -> list[float]:
    """The rotation vector of a quaternion w, x, y, z: radians, at most a half turn."""
    w, *axis = quaternion if quaternion[0] >= 0.0 else [-value for value in quaternion]
    sine = math.sqrt(sum(value * value for value in axis))
    share = 2.0 if sine == 0.0 else 2.0 * math.atan2(sine, w) / sine
    return [value * share for value in axis]


def _pose(keys: dict[str, Any]) -> Pose:
    x, y, z = keys["position"]
    w, i, j, k = keys["quaternion_wxyz"]
    return Pose((x, y, z), (w, i, j, k))


class Env(gymnasium.Env[Floats, Floats]):
    """A task family, or a variation of one, as an environment.

    The action is position (metres, world frame), rotation vector (radians, world frame; zero points straight down) and
    opening of the gripper (0 to 1). The observation is the task's state, each feature divided by its scale.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}

    def __init__(
        self,
        task: str,
        variation: Optional[str] = None,
        *,
        teacher: str = "expert",
        plant: str = "arm",
        tasks: Sequence[str | Path] = (),
        teachers: Sequence[str | Path] = (),
        ends_at_abort: bool = False,
        render_mode: Optional[str] = None,
        size: tuple[int, int] = (480, 300),
        program: Optional[str] = None,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f"render_mode {render_mode!r}: expected one of {self.metadata['render_modes']} or None")
        self.task, self.variation, self.teacher = task, variation, teacher
        self.ends_at_abort, self.render_mode, self.size = ends_at_abort, render_mode, size
        self._arguments, self._program = _arguments(plant, tasks, teachers), program
        self._client: Optional[Client] = None
        known = self._ask("tasks")
        found = [own for own in known["tasks"] if own["task"] == task]
        if not found:
            names = ", ".join(own["task"] for own in known["tasks"])
            self.close()
            raise ServeError(f"there is no task {task!r}: expected one of {names}")
        changed = [own["variation"] for own in found[0]["variations"]]
        if variation is not None and variation not in changed:
            self.close()
            raise ServeError(f"{task} has no variation {variation!r}: expected one of {', '.join(changed)}, or None")
        #: Names and scales of the features of the observation.
        self.features: list[dict[str, Any]] = found[0]["features"]
        #: The task's limit: simulated seconds and keyframes.
        self.limit: dict[str, float] = found[0]["limit"]
        #: The largest opening of the gripper, metres.
        self.stroke: float = known["stroke"]
        low, high = known["reach"]["low"], known["reach"]["high"]
        self._least: Floats = np.array([*low, *[-math.pi] * 3, 0.0])
        self._most: Floats = np.array([*high, *[math.pi] * 3, 1.0])
        self.action_space = spaces.Box(self._least, self._most, dtype=np.float64)
        self.observation_space = spaces.Box(-MOST_SCALES, MOST_SCALES, (len(self.features),), np.float64)
        self._last: Optional[dict[str, Any]] = None

    def _ask(self, do: str, **keys: Any) -> dict[str, Any]:
        if self._client is None or self._client.is_closed:
            self._client = Client(*self._arguments, program=self._program)
        return self._client.ask(do, **keys)

    def _seen(self, observation: dict[str, Any], **more: Any) -> tuple[Floats, dict[str, Any]]:
        """The state, and what is beside it."""
        self._last = observation
        info = {
            "objects": {own["name"]: _pose(own) for own in observation["objects"]},
            "seen": {own["name"]: own["seen"] and _pose(own["seen"]) for own in observation["objects"]},
            "hand": _pose(observation["hand"]),
            "opening": observation["opening"],
            "seconds": observation["seconds"],
            "keyframes": observation["keyframes"],
            "events": observation["events"],
            "solved": observation["solved"],
            **more,
        }
        return np.array(observation["scaled"], dtype=np.float64), info

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode. `reset(seed=7)` is the start that `situ-bench show --seed 7` has."""
        super().reset(seed=seed)
        for left in reversed(range(1 if seed is not None else TRIES)):
            own = int(self.np_random.integers(2**31)) if seed is None else seed
            try:
                begun = self._ask("reset", task=self.task, variation=self.variation, seed=own, teacher=self.teacher)
                return self._seen(begun, seed=own)
            except ServeError:
                if not left or self.is_closed:
                    raise
        raise AssertionError("the last try returns or raises")

    def _is_there(self, position: list[float], quaternion: list[float], opening: float) -> bool:
        """Whether the hand is there already, and the gripper has this command."""
        if self._last is None:
            return False
        hand = self._last["hand"]
        way = math.dist(position, hand["position"])
        cosine = abs(sum(one * other for one, other in zip(quaternion, hand["quaternion_wxyz"])))
        command = self._last["gripper"].get("open")
        is_same = command is not None and abs(command - opening * self.stroke) < NEAR[0]
        return is_same and way < NEAR[0] and 2.0 * math.acos(min(1.0, cosine)) < NEAR[1]

    def step(self, action: ArrayLike) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Goes to a keyframe. What is beyond the action space is taken as its border."""
        numbers = np.asarray(action, dtype=np.float64)
        if numbers.shape != self.action_space.shape or not np.isfinite(numbers).all():
            raise ValueError(f"the action {action!r}: expected 7 finite numbers")
        numbers = np.clip(numbers, self._least, self._most)
        position, opening = [float(value) for value in numbers[:3]], float(numbers[6])
        quaternion = _quaternion([float(value) for value in numbers[3:6]])
        hold = WAIT if self._is_there(position, quaternion, opening) else 0.0
        gone = self._ask("move", position=position, quaternion_wxyz=quaternion, gripper=opening, hold=hold)
        abort = gone["end"] if gone["aborted"] else None
        observation, info = self._seen(gone["observation"], end=gone["end"], abort=abort, about=gone["about"])
        solved = bool(info["solved"])
        truncated = not solved and (gone["observation"]["truncated"] or (abort is not None and self.ends_at_abort))
        return observation, float(solved), solved, truncated, info

    def snapshot(self) -> str:
        """The episode as a text: `restore` in any process of the same program goes on from here, bit for bit."""
        return str(self._ask("snapshot")["snapshot"])

    def restore(self, snapshot: str) -> tuple[Floats, dict[str, Any]]:
        """Goes on from a snapshot. Returns what `reset` does."""
        return self._seen(self._ask("restore", snapshot=snapshot))

    def demonstrate(self, attempt: int = 0) -> Optional[Demonstration]:
        """What the teacher shows from the start of this episode, which stays where it is.

        None where the teacher fails at this attempt, as those who err do; another attempt may not.
        """
        return self._shown("demonstrate", attempt)

    def correct(self, attempt: int = 0) -> Optional[Demonstration]:
        """What the teacher shows from here, from this very state; as `demonstrate`. None, too, where all is done."""
        return self._shown("correct", attempt)

    def _shown(self, do: str, attempt: int) -> Optional[Demonstration]:
        answer = self._ask(do, attempt=attempt)
        return Demonstration.of(answer["demonstration"]) if answer["clean"] else None

    def actions(self, demonstration: Demonstration) -> Floats:
        """The keyframes of a demonstration as actions, shape (keyframes, 7). A grasp by force is the opening 0."""
        rows = []
        for keyframe in demonstration.keyframes:
            gripper, pose = keyframe.gripper, keyframe.gripper_pose
            opening = gripper.get("open", 0.0) / self.stroke if isinstance(gripper, dict) else gripper
            rows.append([*pose.position, *_turn(pose.quaternion), opening])
        return np.array(rows, dtype=np.float64)

    def render(self) -> Any:
        """A picture from the front, shape (height, width, 3), where `render_mode` is `rgb_array`."""
        if self.render_mode is None:
            return None
        width, height = self.size
        answer = self._ask("picture", width=width, height=height, format="rgb")
        return np.frombuffer(base64.b64decode(answer["rgb"]), dtype=np.uint8).reshape(height, width, 3).copy()

    @property
    def pid(self) -> Optional[int]:
        """The number of the process that serves; None where none does."""
        return None if self.is_closed or self._client is None else self._client.pid

    @property
    def is_closed(self) -> bool:
        """Whether no process serves."""
        return self._client is None or self._client.is_closed

    def close(self) -> None:
        """Ends the process. Whoever resets afterwards starts another."""
        if self._client is not None:
            self._client.close()


def _arguments(plant: str, tasks: Sequence[str | Path], teachers: Sequence[str | Path]) -> list[str]:
    folders = [word for folder in tasks for word in ("--tasks", str(folder))]
    files = [word for file in teachers for word in ("--teachers", str(file))]
    return ["--plant", plant, *folders, *files]


def register_all(
    *, tasks: Sequence[str | Path] = (), teachers: Sequence[str | Path] = (), program: Optional[str] = None
) -> list[str]:
    """Registers every family and variation that the program knows, those of one's own folders among them.

    Returns their names, such as `situ_bench/pour-v1` and `situ_bench/pour-lid-v1`.
    """
    names = []
    with Client(*_arguments("arm", tasks, teachers), program=program) as client:
        known = client.ask("tasks")["tasks"]
    own = {"tasks": [str(folder) for folder in tasks], "teachers": [str(file) for file in teachers]}
    own = {key: paths for key, paths in own.items() if paths}
    for task in known:
        for variation in [None, *(changed["variation"] for changed in task["variations"])]:
            label = task["task"] if variation is None else f"{task['task']}-{variation}"
            name = f"situ_bench/{label}-v{VERSION}"
            names.append(name)
            if name not in gymnasium.registry:
                kwargs = {"task": task["task"], "variation": variation, **own}
                gymnasium.register(name, entry_point="situ_bench.env:Env", kwargs=kwargs)
    return names


try:
    register_all()
except ServeError as error:
    warnings.warn(f"no environment of situ_bench is registered: {error}", stacklevel=2)
