"""Rows of runs in physics, and the columns that many tables have."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from cells import Column, count, pooled, text
from ledger import FAILURES, Run
from measures import effort, grouped, units, variations

Pair = tuple[Run, Run]


@dataclass(frozen=True)
class Row:
    """A row of runs, and their runs beside those of another method."""

    key: tuple[str, ...]
    runs: list[Run]
    pairs: list[Pair]

    def counted(self) -> list[Run]:
        """The runs that say something about their method."""
        return [run for run in self.runs if run.counts()]


def rows(runs: Iterable[Run], key: Callable[[Run], tuple[str, ...]], pairs: Sequence[Pair] = ()) -> list[Row]:
    """The rows of these runs; a pair is in the row of its first run."""
    of_pairs = grouped((key(own), (own, other)) for own, other in pairs)
    return [Row(one, of, of_pairs.get(one, [])) for one, of in grouped((key(run), run) for run in runs).items()]


def _word(name: str, index: int) -> Column[Row]:
    return text(name, lambda row: row.key[index] or None)


def keys(*names: str) -> list[Column[Row]]:
    """A column for each part of the key."""
    return [_word(name, index) for index, name in enumerate(names)]


METHOD_KEYS = ("protocol", "method", "edit_needed")


def method_key(run: Run) -> tuple[str, ...]:
    """Protocol, method, and the edit that the variation needs."""
    return run.protocol, run.method, run.edit


RUNS: Column[Row] = count("runs", lambda row: len(row.counted()))
UNITS: Column[Row] = count("units", lambda row: units(row.counted()))
VARIATIONS: Column[Row] = count("variations", lambda row: variations(row.counted()))


def _ending(name: str) -> Column[Row]:
    meant = FAILURES if name == "broken_off" else (name,)
    return count(name, lambda row: sum(run.ending in meant for run in row.runs))


def endings(*names: str) -> list[Column[Row]]:
    """How many runs ended so."""
    return [_ending(name) for name in names]


def _effort(name: str) -> Column[Row]:
    return pooled(name, lambda row: effort(row.counted(), name))


def efforts(*names: str) -> list[Column[Row]]:
    """What was spent, on the average of the runs that say something."""
    return [_effort(name) for name in names]
