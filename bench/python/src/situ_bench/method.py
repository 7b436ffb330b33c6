"""What a method must do, and what it is told."""

from __future__ import annotations

import base64
import pickle
from dataclasses import dataclass, field
from typing import Any, Literal, Optional

from .demonstration import Demonstration, Gripper, Pose, State

#: The place that is the end of a task. No primitive may be called so.
END = "end"

Execution = Literal["mean", "sample"]
#: Exact counts of work, by the names of the ledger: `hmm_fits`, `classifier_fits` and so on.
Counters = dict[str, int]


class Refused(Exception):
    """Raised by a method that refuses what it is told; its model must be as it was before."""


@dataclass(frozen=True)
class Schema:
    """The numbers of a state, in order."""

    names: list[str]
    #: The typical size of a difference that matters, for each number.
    scales: list[float]
    #: The axis of the hand (`x`, `y` or `z`) about which half a turn is the same grasp, if there is one.
    half_turn: Optional[str] = None


@dataclass(frozen=True)
class Step:
    """A choice of the rollout that failed."""

    place: str
    #: The world in which it was made.
    state: State
    #: `finished`, `interrupted`, or `prevented` where it was stopped before it began.
    ended: str


@dataclass(frozen=True)
class Child:
    """A place that may follow, and how probable that is, from 0 to 1."""

    place: str
    probability: float


@dataclass(frozen=True)
class RelativeKeyframe:
    """A keyframe in the frame of its reference object."""

    pose: Pose
    gripper: Gripper
    #: Seconds of rest.
    hold: float = 0.0


@dataclass(frozen=True)
class Node:
    """A primitive: its name, and the segments that it was learned from (demonstration's name, index)."""

    place: str
    segments: list[tuple[str, int]]
    #: How many ways of doing it there are.
    ways: int = 1


@dataclass(frozen=True)
class Graph:
    """The structure of a model. An edge from `None` is one from the start; `end` is the end."""

    nodes: list[Node] = field(default_factory=list)
    edges: list[tuple[Optional[str], str]] = field(default_factory=list)


class Method:
    """A way to keep a task model up to date. One object holds one model."""

    #: One sentence: what it does.
    summary: str = ""
    #: Where it comes from.
    source: str = ""
    #: `correct`, `from_scratch` (is taught every changed task anew), or `control` (is never corrected).
    role: Literal["correct", "from_scratch", "control"] = "correct"
    #: The edits that it can make, whatever it is shown.
    edits: list[str] = ["node_addition", "edge_addition", "node_modification"]
    #: The name of the method whose original model it takes over, where that is another's.
    original: Optional[str] = None

    def teach(self, schema: Schema, demonstrations: list[Demonstration], seed: int) -> Optional[list[list[int]]]:
        """Makes a new model of whole demonstrations. All that it draws comes from the seed.

        A method that cuts demonstrations in its own way returns the number of keyframes of each segment of each.
        """
        raise NotImplementedError

    def correct(
        self, last: Optional[str], interrupted: Optional[str], trail: list[Step], demonstration: Demonstration
    ) -> Optional[dict[str, Any]]:
        """Folds a correction in, all of it or nothing.

        `last` is the primitive that ran last to its end, `interrupted` the one that was under way, if any. A dictionary
        that is returned may have the keys `edits`, `counters` and `segments`.
        """
        raise NotImplementedError

    def next(self, last: Optional[str], state: State) -> list[Child]:
        """The places that may follow, the likeliest first."""
        raise NotImplementedError

    def keyframes(
        self, place: str, state: State, execution: Execution, attempt: int, seed: int
    ) -> tuple[str, list[RelativeKeyframe]]:
        """The reference object of a primitive, and the keyframes of one execution.

        `attempt` is the number of the way of doing it, from 0. Where `execution` is `sample`, draws come from the seed.
        """
        raise NotImplementedError

    def graph(self) -> Graph:
        """The structure of the model."""
        raise NotImplementedError

    def save(self) -> Any:
        """The model, as anything that JSON can hold; it only ever comes back to `load` of the same program."""
        return base64.b64encode(pickle.dumps(self.__dict__)).decode("ascii")

    def load(self, model: Any) -> None:
        """Takes a saved model."""
        self.__dict__ = pickle.loads(base64.b64decode(model))
