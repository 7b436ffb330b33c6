"""The questions that all sides are asked, and how a side is run."""

import gc
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Any

from operations import FitCount
from values import Values


@dataclass(frozen=True)
class Measured:
    """Some runs of one side."""

    runs: list[float]
    """The milliseconds of each."""
    values: Callable[[], Values]
    """The numbers that came out of the last run."""

    @property
    def milliseconds(self) -> float:
        """The median of the runs."""
        return statistics.median(self.runs)


Measure = Callable[[float], Measured]
"""Runs a side for so many seconds, and at least once."""


@dataclass(frozen=True)
class Way:
    """One way of a peer to compute a case."""

    name: str
    measure: Measure


@dataclass(frozen=True)
class Peer:
    """A package that computes a case, too."""

    package: str
    ways: list[Way]
    expected: Callable[[], Values] | None = None
    """The values with which its own must agree, where those are not ours. hmmlearn computes them."""


@dataclass(frozen=True)
class Case:
    """One computation, asked of all sides."""

    name: str
    ours: Measure
    peers: list[Peer]
    count: Callable[[], FitCount] | None = None
    """Counts what the computation needs, where the share of the core's peak is asked for."""


def in_process(prepare: Callable[[], Callable[[], Any]], values: Callable[[Any], Values]) -> Measure:
    """Measures Python in this process.

    `prepare` makes the timed function anew for each run; `values` reads the values from the result of a run.
    """

    def measure(seconds: float) -> Measured:
        taken: list[int] = []
        gc.collect()
        gc.disable()
        while not taken or sum(taken) < seconds * 1e9:
            work = prepare()
            start = perf_counter_ns()
            result = work()
            taken.append(perf_counter_ns() - start)
        gc.enable()
        return Measured([nanoseconds / 1e6 for nanoseconds in taken], lambda: values(result))

    return measure
