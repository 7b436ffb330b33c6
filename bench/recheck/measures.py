"""What tables say of runs: success, effort and other quantities, each as a cell with two intervals."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import summaries
from cells import Cell, Exact, Percentile, Word, mark
from ledger import Calibration, Rate, Run
from resampling import Distribution, Statistic

T = TypeVar("T")
K = TypeVar("K")
# Things of runs, each with its run.
OfRuns = Sequence[tuple[Run, T]]

# What each method does with a changed task is in the list of methods: all take corrections but these two.
FROM_SCRATCH = "from_scratch"
CONTROL = "no_update"
SITU = "situ"

EDITS = ("node-addition", "edge-addition", "node-modification", "none")
MILLISECONDS = 1000.0

EFFORT: dict[str, Callable[[Run], float]] = {
    "demonstrations": lambda run: run.charged(),
    "tries": lambda run: run.effort.tries,
    "keyframes": lambda run: run.effort.keyframes,
    "seconds": lambda run: run.effort.seconds,
    "metres": lambda run: run.effort.metres,
}


def grouped(items: Iterable[tuple[K, T]]) -> dict[K, list[T]]:
    """The items that share a key."""
    groups: dict[K, list[T]] = {}
    for key, item in items:
        groups.setdefault(key, []).append(item)
    return groups


def _sum_pairs(pairs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return sum(pair[0] for pair in pairs), sum(pair[1] for pair in pairs)


def _quotient(pairs: Sequence[tuple[float, float]]) -> float | None:
    above, below = _sum_pairs(pairs)
    return above / below if below > 0 else None


RATIO: Statistic[tuple[float, float]] = Statistic(_sum_pairs, _quotient)


def _of_all(statistic: Callable[[Sequence[T]], float | None]) -> Statistic[T]:
    return Statistic(list, lambda parts: statistic([one for part in parts for one in part]))


MEDIAN: Statistic[float] = _of_all(summaries.median)
INTERQUARTILE_MEAN: Statistic[float] = _of_all(summaries.interquartile_mean)


def _improvement(scores: Sequence[tuple[Any, float, float]]) -> float | None:
    tasks = grouped((task, (own, other)) for task, own, other in scores)
    return summaries.improvement([([one for one, _ in of], [other for _, other in of]) for of in tasks.values()])


IMPROVEMENT: Statistic[tuple[Any, float, float]] = _of_all(_improvement)

BRIER: Statistic[Calibration] = Statistic(
    lambda all_of: _sum_pairs([(one.squares, sum(one.choices)) for one in all_of]), _quotient
)


def _bins(all_of: Sequence[Calibration]) -> tuple[list[float], int]:
    """In each bin, the sum of probabilities less the number of those that were right; and all choices."""
    apart = [
        sum(one.probability[index] - one.right[index] for one in all_of) for index in range(len(all_of[0].choices))
    ]
    return apart, sum(sum(one.choices) for one in all_of)


def _calibration_error(parts: Sequence[tuple[list[float], int]]) -> float | None:
    choices = sum(part[1] for part in parts)
    apart = (abs(sum(one)) for one in zip(*(part[0] for part in parts)))
    return sum(apart) / choices if choices else None


CALIBRATION_ERROR: Statistic[Calibration] = Statistic(_bins, _calibration_error)


def _interval(clusters: Sequence[Sequence[T]], strata: Sequence[int], statistic: Statistic[T]) -> list[Any]:
    if len(clusters) < 2:
        return [Word(""), Word("")]
    distribution = Distribution(clusters, strata, statistic)
    return [Percentile(distribution, upper=False), Percentile(distribution, upper=True)]


def pooled(of: OfRuns[T], statistic: Statistic[T], bound: str = "") -> Cell:
    """A statistic of things of runs, with an interval by units within families and one by variations.

    Where a family has one unit alone, the units of all families are drawn together.
    """
    value = statistic.whole([statistic.part([thing for _, thing in of])]) if of else None
    if value is None:
        return None
    units = grouped((run.unit(), thing) for run, thing in of)
    of_family = Counter(task for task, _ in units)
    in_order = [units[unit] for task in of_family for unit in units if unit[0] == task]
    strata = [len(units)] if 1 in of_family.values() else list(of_family.values())
    variations = list(grouped((run.changed_task(), thing) for run, thing in of).values())
    return [
        Exact(value),
        *_interval(in_order, strata, statistic),
        *_interval(variations, [len(variations)], statistic),
        Word(bound),
    ]


def ratio(of: OfRuns[tuple[float, float]], bound: str = "") -> Cell:
    """The sum of the first numbers over that of the second."""
    return pooled(of, RATIO, bound)


def share(of: OfRuns[tuple[float, float]]) -> Cell:
    """The same of a share. Where all agree, each interval is Wilson's of as many units, or variations, that agree."""
    cell = ratio(of)
    above, below = _sum_pairs([pair for _, pair in of])
    if cell is None or 0 < above < below:
        return cell
    counts = units(run for run, _ in of), variations(run for run, _ in of)
    ends: list[Any] = []
    for count, (low, high) in zip(counts, (cell[1:3], cell[3:5])):
        is_there = not isinstance(low, Word)
        agreeing = map(Exact, summaries.wilson(count if above else 0, count)) if is_there else (low, high)
        ends.extend(agreeing)
    return [cell[0], *ends, cell[5]]


def of_runs(runs: Iterable[Run], of: Callable[[Run], T | None]) -> list[tuple[Run, T]]:
    """A thing of each run that has one."""
    return [(run, thing) for run in runs if (thing := of(run)) is not None]


def rate(of: Rate | None) -> float | None:
    """The share of rollouts that succeeded."""
    return of.successes / of.rollouts if of is not None and of.rollouts else None


def success(runs: Iterable[Run], of: Callable[[Run], Rate | None]) -> Cell:
    """The share of rollouts of runs that succeeded."""
    return share([(run, (one.successes, one.rollouts)) for run, one in of_runs(runs, of)])


def once(runs: Iterable[Run]) -> Cell:
    """The share of rollouts on the changed task in which the goal held at some time."""
    return share([(run, (one.once, one.rollouts)) for run, one in of_runs(runs, lambda run: run.after)])


def mean(runs: Iterable[Run], of: Callable[[Run], float | None], bound: str = "") -> Cell:
    """The mean of a quantity over the runs that have it."""
    return ratio([(run, (value, 1)) for run, value in of_runs(runs, of)], bound)


def median(runs: Iterable[Run], of: Callable[[Run], float | None]) -> Cell:
    """The median of it."""
    return pooled(of_runs(runs, of), MEDIAN)


def effort(runs: Sequence[Run], name: str) -> Cell:
    """The mean effort: a lower bound where a run did not reach the target; nothing for what is taught nothing."""
    if any(run.method == CONTROL for run in runs):
        return None
    return mean(runs, EFFORT[name], mark(all(run.is_reached() for run in runs)))


def effort_ratio(pairs: Sequence[tuple[Run, Run]], name: str) -> Cell:
    """The effort of runs over that of the runs beside them."""
    bound = mark(all(own.is_reached() for own, _ in pairs), all(other.is_reached() for _, other in pairs))
    return ratio([(own, (EFFORT[name](own), EFFORT[name](other))) for own, other in pairs], bound)


def difference(of: Iterable[tuple[Run, float | None, float | None]]) -> Cell:
    """The mean difference of two quantities over the runs that have both."""
    return ratio([(run, (own - other, 1)) for run, own, other in of if own is not None and other is not None])


def update_ms(run: Run) -> float | None:
    """The mean time of an update of a run, milliseconds."""
    seconds = run.update_seconds()
    return None if seconds is None else MILLISECONDS * seconds


def made(sets: Iterable[frozenset[str]]) -> str | None:
    """How often each set of edits was made, in words; sets in the order of their edits."""
    counts = Counter(tuple(sorted(EDITS.index(edit) for edit in edits)) for edits in sets)
    words = ["+".join(EDITS[index] for index in edits) + f" {counts[edits]}" for edits in sorted(counts)]
    return ", ".join(words) or None


def all_edits(run: Run) -> frozenset[str] | None:
    """The set of edits of all corrections together: `none` where they made none."""
    together: frozenset[str] = frozenset().union(*(one.edits for one in run.corrections))
    return (together - {"none"} or together) or None


def first_edits(run: Run) -> frozenset[str] | None:
    """The set of edits of the first correction that shows what changed."""
    return next((one.edits for one in run.corrections if one.shows_change), None)


def units(runs: Iterable[Run]) -> int:
    """The number of units, family × seed."""
    return len({run.unit() for run in runs})


def variations(runs: Iterable[Run]) -> int:
    """The number of variations."""
    return len({run.changed_task() for run in runs})


def partners(runs: Iterable[Run], method: str) -> dict[Any, Run]:
    """The runs of a method, by their places."""
    return {run.place(): run for run in runs if run.method == method}


def beside(runs: Iterable[Run], others: dict[Any, Run]) -> list[tuple[Run, Run]]:
    """Each run with the one in its place, where there is one."""
    return [(run, others[run.place()]) for run in runs if run.place() in others]
