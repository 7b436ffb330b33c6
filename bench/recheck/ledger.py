"""The records of a ledger: a reader of its own, which shares nothing with the program that wrote it."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SCHEMA = 2
BINS = 10
# How a run ends that is not done to its end: it counts its budget and no success.
FAILURES = ("method_error", "timed_out", "panicked")

# A decoded JSON object.
Object = dict[str, Any]


class LedgerError(Exception):
    """A line that is no record."""


@dataclass(frozen=True)
class Rate:
    """Rollouts, those at whose end the goal held, and those in which it held at some time."""

    successes: int
    once: int
    rollouts: int


@dataclass(frozen=True)
class Effort:
    """Demonstrations that the robot was given, tries of the teacher, lengths over all tries, and grasps dropped."""

    demonstrations: int
    tries: int
    keyframes: int
    seconds: float
    metres: float
    foreseen: int


@dataclass(frozen=True)
class Step:
    """A local update: |Z|, |T|, and whether A1.6 alone found a primitive with the segment's skill, if one held it."""

    applicable: int
    model_size: int
    retrieved: bool | None


@dataclass(frozen=True)
class Correction:
    """A correction and the update that it led to. `edits` is the set of edits made: `none` where nothing changed.

    The rollouts of `decided_by` decided whether another correction was asked for.
    """

    effort: Effort
    decided_by: Rate
    shows_change: bool
    edits: frozenset[str]
    steps: tuple[Step, ...]
    counters: dict[str, int]
    update_seconds: float
    obedience: dict[str, int]


@dataclass(frozen=True)
class Structure:
    """A model's structure against what the teacher meant; an F1 is missing where neither side has an element."""

    nodes: int
    skills: int
    duplicates: int
    node_f1: float | None
    edge_f1: float | None


@dataclass(frozen=True)
class HeldOut:
    """The likelihood of a demonstration that was given to nobody: that of the segments which can be explained."""

    segments: int
    explained: int
    keyframes: int
    log_likelihood: float

    def per_keyframe(self) -> float | None:
        """Nats per keyframe that was explained."""
        return self.log_likelihood / self.keyframes if self.keyframes else None


@dataclass(frozen=True)
class Calibration:
    """Choices in ten bins of their probability: how many, how many right, the sum of probabilities; squared errors."""

    squares: float
    choices: tuple[int, ...]
    right: tuple[int, ...]
    probability: tuple[float, ...]


@dataclass(frozen=True)
class Joint:
    """The model that is made of the same demonstrations at once."""

    changed: Rate
    original: Rate
    structure: Structure | None
    held_out: HeldOut | None


@dataclass(frozen=True)
class Run:
    """A run in physics. `stage` is (sequence, number) in a sequence; `ending` is the outcome, `why` its reason."""

    protocol: str
    task: str
    variation: str
    edit: str
    teacher: str
    method: str
    seed: int
    stage: tuple[str, int] | None
    ending: str
    why: str
    self_loop: bool
    budget: int
    target: float
    originals: Effort
    effort: Effort
    before: Rate | None
    after: Rate | None
    original_before: Rate | None
    original_after: Rate | None
    corrections: tuple[Correction, ...]
    structure: Structure | None
    joint: Joint | None
    calibration: Calibration | None
    held_out: HeldOut | None
    earlier: dict[str, Rate]

    def counts(self) -> bool:
        """Whether it says something about the method: it reached the target, or its budget or its teacher ended it."""
        return self.ending in ("reached", "censored", "gave_up", *FAILURES)

    def is_reached(self) -> bool:
        """Whether the target was reached."""
        return self.ending == "reached"

    def is_reached_by_luck(self) -> bool:
        """Whether the rollouts that decided reached the target, and fewer did from fresh starts."""
        after = self.after
        return self.is_reached() and after is not None and after.successes < self.target * after.rollouts

    def charged(self) -> int:
        """Demonstrations that it took: the budget, where the target was not reached."""
        return self.effort.demonstrations if self.is_reached() else self.budget

    def update_seconds(self) -> float | None:
        """The mean time of an update."""
        if not self.corrections:
            return None
        return sum(correction.update_seconds for correction in self.corrections) / len(self.corrections)

    def unit(self) -> tuple[str, int]:
        """Family and seed: runs that share these share their originals."""
        return self.task, self.seed

    def changed_task(self) -> tuple[str, str]:
        """The task and its variation."""
        return self.task, self.variation

    def place(self) -> tuple[str, str, str, str, int]:
        """Its cell but for the method, and its seed: what runs of two methods are paired by."""
        return self.protocol, self.task, self.variation, self.teacher, self.seed


@dataclass(frozen=True)
class Cost:
    """An update of a synthetic automaton."""

    protocol: str
    series: str
    method: str
    nodes: int
    originals: int
    edit: str
    seed: int
    correction: int
    applicable: tuple[int, ...]
    segments: int
    counters: dict[str, int]
    edit_made: str
    update_seconds: float


@dataclass(frozen=True)
class Ledger:
    """All records."""

    runs: list[Run]
    costs: list[Cost]

    def single(self) -> list[Run]:
        """The runs that stand alone: no stages of a sequence."""
        return [run for run in self.runs if run.stage is None]

    def counted(self) -> list[Run]:
        """Those of them that say something about their method."""
        return [run for run in self.single() if run.counts()]


def _rate(value: Object | None) -> Rate | None:
    return None if value is None else Rate(value["successes"], value["once"], value["rollouts"])


def _rate_given(value: Object) -> Rate:
    return Rate(value["successes"], value["once"], value["rollouts"])


def _effort(value: Object) -> Effort:
    names = ("demonstrations", "tries", "keyframes", "seconds", "metres")
    return Effort(**{name: value[name] for name in names}, foreseen=value.get("foreseen", 0))


def _structure(value: Object | None) -> Structure | None:
    if value is None:
        return None

    def f1(sets: Object) -> float | None:
        # The harmonic mean of both/model and both/truth.
        size = sets["model"] + sets["truth"]
        return 2 * sets["both"] / size if size else None

    return Structure(
        value["nodes"], value["skills"], value["duplicates"], f1(value["pairs"]), f1(value["transitions"])
    )


def _held_out(value: Object | None) -> HeldOut | None:
    if value is None:
        return None
    return HeldOut(value["segments"], value["explained"], value["keyframes"], value["log_likelihood"])


def _correction(value: Object) -> Correction:
    is_shown_again = value["nodes_added"] + value["nodes_modified"] > 0
    made = {
        "node-addition": value["nodes_added"],
        # A way back along which something else was shown again is no edit of its own.
        "edge-addition": value["edges_added"] - (value.get("edges_back", 0) if is_shown_again else 0),
        "node-modification": value["nodes_modified"],
    }
    steps = (Step(step["applicable"], step["model_size"], step.get("retrieved")) for step in value["steps"])
    edits = frozenset(edit for edit, count in made.items() if count) or frozenset({"none"})
    effort, decided_by = _effort(value["effort"]), _rate_given(value["decided_by"])
    return Correction(
        effort, decided_by, value["shows_change"], edits, tuple(steps), value["counters"], value["update_seconds"],
        value.get("obedience", {}),
    )


def _calibration(value: Object | None) -> Calibration | None:
    if value is None:
        return None
    if len(value["bins"]) != BINS:
        raise LedgerError(f"{len(value['bins'])} bins where {BINS} are expected")
    columns = (tuple(one[name] for one in value["bins"]) for name in ("choices", "right", "probability"))
    return Calibration(value["squares"], *columns)


def _joint(value: Object | None) -> Joint | None:
    if value is None:
        return None
    changed, original = _rate_given(value["joint"]), _rate_given(value["retained"])
    return Joint(changed, original, _structure(value["structure"]), _held_out(value.get("held_out")))


def _reason(outcome: Object) -> tuple[str, str]:
    """An outcome that has a reason, and the reason."""
    ((ending, details),) = outcome.items()
    return ending, details["why"]


def _run(value: Object) -> Run:
    key, stage, outcome = value["key"], value["key"].get("stage"), value["outcome"]
    ending, why = (outcome, "") if isinstance(outcome, str) else _reason(outcome)
    if ending not in ("reached", "censored", "gave_up", "untaught", "spoilt", "not_applicable", *FAILURES):
        raise LedgerError(f"an unknown outcome, {ending}")
    return Run(
        **{name: key[name] for name in ("protocol", "task", "variation", "edit", "teacher", "method", "seed")},
        stage=(stage["sequence"], stage["number"]) if stage else None,
        ending=ending,
        why=why,
        self_loop=value.get("self_loop", False),
        budget=value["budget"],
        target=value["target"],
        originals=_effort(value["original"]),
        effort=_effort(value["effort"]),
        before=_rate(value["before"]),
        after=_rate(value["after"]),
        original_before=_rate(value["original_rate"]),
        original_after=_rate(value["retained"]),
        corrections=tuple(_correction(one) for one in value["corrections"]),
        structure=_structure(value.get("structure")),
        joint=_joint(value.get("joint")),
        calibration=_calibration(value.get("calibration")),
        held_out=_held_out(value.get("held_out")),
        earlier={name: _rate_given(rate) for name, rate in value.get("earlier", {}).items()},
    )


def _cost(value: Object) -> Cost:
    names = ("protocol", "series", "method", "nodes", "originals", "edit", "seed", "counters", "edit_made")
    return Cost(
        **{name: value[name] for name in names},
        correction=value.get("correction", 0),
        applicable=tuple(value["applicable"]),
        segments=len(value["model_size"]),
        update_seconds=value["update_seconds"],
    )


def read(path: Path) -> Ledger:
    """The ledger at `path`. Raises `LedgerError`, which names the line."""
    ledger = Ledger([], [])
    known: set[tuple[object, ...]] = set()
    name: tuple[object, ...]
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        try:
            value = json.loads(line)
            if value["schema"] != SCHEMA:
                raise LedgerError(f"version {value['schema']} where {SCHEMA} is expected")
            if value["kind"] == "run":
                run = _run(value)
                ledger.runs.append(run)
                name = (run.place(), run.edit, run.method, run.stage)
            elif value["kind"] == "cost":
                cost = _cost(value)
                ledger.costs.append(cost)
                name = (cost.protocol, cost.series, cost.method, cost.edit, cost.nodes, cost.originals, cost.seed,
                        cost.correction)
            else:
                raise LedgerError(f"an unknown kind of record, {value['kind']}")
        except (LedgerError, ValueError, KeyError, TypeError) as error:
            raise LedgerError(f"{path}:{number}: {type(error).__name__}: {error}") from error
        if name in known:
            raise LedgerError(f"{path}:{number}: this record is there twice")
        known.add(name)
    return ledger
