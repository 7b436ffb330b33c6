"""Tables that hold one method against another, each by the definitions in its note."""

import csv
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import resampling
import summaries
from cells import Between, Cell, Column, Exact, Table, number, pooled, table
from ledger import Joint, Ledger, Rate, Run
from measures import (
    CONTROL, EFFORT, FROM_SCRATCH, IMPROVEMENT, SITU, beside, difference, effort_ratio, grouped, partners,
    pooled as over_runs, rate, ratio,
)
from rows import RUNS, UNITS, VARIATIONS, Pair, Row, keys


LIST_OF_SHOWN = Path(__file__).parents[2] / "results" / "tasks" / "shown.csv"


def _shown() -> dict[tuple[str, str], bool]:
    """Whether a task and variation shows its change at every decision that differs, by the committed list."""
    shown: dict[tuple[str, str], bool] = {}
    with LIST_OF_SHOWN.open(newline="", encoding="utf-8") as lines:
        for row in csv.DictReader(lines):
            changed = row["task"], row["variation"]
            shown[changed] = shown.get(changed, True) and row["shown"] == "true"
    return shown


SHOWN = _shown()


def _edit_groups(run: Run) -> list[str]:
    """The groups by edit of pooled rows that a run is in."""
    if run.edit != "edge-addition":
        return ["all", "all but self-loops", run.edit]
    if run.self_loop:
        return ["all", "edge-addition: self-loop"]
    return ["all", "all but self-loops", "edge-addition: other"]


def _groups(run: Run) -> list[str]:
    """The groups of pooled rows that a run is in."""
    if run.edit == "none":
        return []
    shown = SHOWN.get(run.changed_task())
    if shown is None:
        return _edit_groups(run)
    word = "shown" if shown else "not shown"
    apart = [f"{run.edit}: {word}"] if run.edit == "node-modification" else []
    return [*_edit_groups(run), *apart, f"all: {word}"]


QUESTION_KEYS = ("protocol", "teacher", "method", "edit_needed")


def _question(pairs: Sequence[Pair]) -> list[Row]:
    """Pooled rows of these pairs: a pair is in the row of each group of its first run."""
    groups = grouped(
        ((own.protocol, own.teacher, own.method, group), (own, other))
        for own, other in pairs for group in _groups(own)
    )
    return [Row(key, [own for own, _ in of], of) for key, of in groups.items()]


def _effort_ratio(name: str) -> Column[Row]:
    return pooled(name, lambda row: effort_ratio(row.pairs, name))


def correct_or_scratch(ledger: Ledger) -> Table:
    """The paper's first question."""
    anew = partners(ledger.counted(), FROM_SCRATCH)
    pairs = beside([run for run in ledger.counted() if run.method not in (FROM_SCRATCH, CONTROL)], anew)

    def gain(row: Row) -> Cell:
        return difference((own, rate(own.after), rate(other.after)) for own, other in row.pairs)

    columns = [RUNS, UNITS, VARIATIONS, *map(_effort_ratio, EFFORT), pooled("success", gain)]
    records = sum(own.edit != "none" for own, _ in pairs)
    heading = "To correct, or to teach from scratch"
    return table("correct_or_scratch", heading, keys(*QUESTION_KEYS), columns, _question(pairs), records)


def separate_or_joint(ledger: Ledger) -> Table:
    """The paper's second question."""
    runs = [run for run in ledger.counted() if run.joint is not None]

    def gain(row: Row, own: Callable[[Run], Rate | None], joint: Callable[[Joint], Rate]) -> Cell:
        return difference((run, rate(own(run)), rate(joint(run.joint))) for run in row.runs if run.joint)

    columns = [
        RUNS, UNITS, VARIATIONS,
        pooled("success", lambda row: gain(row, lambda run: run.after, lambda joint: joint.changed)),
        pooled("original", lambda row: gain(row, lambda run: run.original_after, lambda joint: joint.original)),
    ]
    records = sum(run.edit != "none" for run in runs)
    of_rows = _question([(run, run) for run in runs])
    return table("separate_or_joint", "Separate, or joint", keys(*QUESTION_KEYS), columns, of_rows, records)


MEASURES: dict[str, Callable[[Run], float | None]] = {
    "success": lambda run: rate(run.after),
    "demonstrations": lambda run: run.charged(),
    "original": lambda run: rate(run.original_after),
}


def _apart(row: Row, name: str) -> list[tuple[Run, float]]:
    """The differences of a measure over the pairs that have it."""
    both = ((own, MEASURES[name](own), MEASURES[name](other)) for own, other in row.pairs)
    return [(own, one - other) for own, one, other in both if one is not None and other is not None]


def _improvement(row: Row) -> Cell:
    """The probability of improvement."""
    both = ((own, rate(own.after), rate(other.after)) for own, other in row.pairs)
    scores = [(own, one, other) for own, one, other in both if one is not None and other is not None]
    return over_runs([(own, (own.changed_task(), one, other)) for own, one, other in scores], IMPROVEMENT)


# What a test of a row is called: the key of the row, and the measure.
Name = tuple[tuple[str, ...], str]


class _Tests:
    """All tests of a table, and their corrected p-values."""

    def __init__(self, of_rows: Sequence[Row]) -> None:
        self.tests: dict[Name, resampling.FlipTest] = {}
        for row in of_rows:
            for name in MEASURES:
                units = grouped((run.unit(), value) for run, value in _apart(row, name))
                if units:
                    sums = [math.fsum(of) for of in units.values()]
                    self.tests[row.key, name] = resampling.flip_test(sums)
        # A corrected p-value grows with each of the p-values.
        self.low = dict(zip(self.tests, summaries.holm([test.low for test in self.tests.values()])))
        self.high = dict(zip(self.tests, summaries.holm([test.high for test in self.tests.values()])))

    def least(self, row: Row) -> float | None:
        """The least p-value that the units of a row can give."""
        return next((test.least for (key, _), test in self.tests.items() if key == row.key), None)

    def columns(self, name: str) -> list[Column[Row]]:
        """The difference of a measure and its test."""

        def p(row: Row) -> Cell:
            test = self.tests.get((row.key, name))
            if test is None:
                return None
            return [Between(test.low, test.high) if test.is_drawn else Exact(test.p)]

        def corrected(row: Row) -> Cell:
            if (row.key, name) not in self.tests:
                return None
            low, high = self.low[row.key, name], self.high[row.key, name]
            return [Exact(low) if low == high else Between(low, high)]

        return [
            pooled(name, lambda row: ratio([(run, (value, 1)) for run, value in _apart(row, name)])),
            Column(f"p_{name}", "number", p),
            Column(f"Holm_{name}", "number", corrected),
        ]


def _fits(row: Row) -> Cell:
    """The difference in hidden Markov models fitted at an update."""

    def fitted(run: Run) -> float | None:
        fits = [one.counters["hmm_fits"] for one in run.corrections]
        return sum(fits) / len(fits) if fits else None

    return difference((own, fitted(own), fitted(other)) for own, other in row.pairs)


def paired(ledger: Ledger) -> Table:
    """SITU beside every other method."""
    counted = [run for run in ledger.counted() if run.edit != "none"]
    others = beside([run for run in counted if run.method not in (SITU, CONTROL)], partners(counted, SITU))
    groups = grouped(((other.protocol, other.teacher, other.method), (situ, other)) for other, situ in others)
    of_rows = [Row(key, [situ for situ, _ in pairs], pairs) for key, pairs in groups.items()]
    tests = _Tests(of_rows)
    columns = [RUNS, UNITS, pooled("improvement", _improvement), number("least_p", tests.least)]
    for name in MEASURES:
        columns += tests.columns(name)
    columns.append(pooled("fits", _fits))
    of_keys = keys("protocol", "teacher", "other")
    return table("paired", "SITU beside every other method, paired", of_keys, columns, of_rows, len(others))
