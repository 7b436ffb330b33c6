"""The tables over updates of synthetic automata, each by the definitions in its note."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import summaries
from cells import Cell, Column, Exact, Percentile, Table, Word, count, estimate, number, table, text
from ledger import Cost, Ledger
from measures import MEDIAN, MILLISECONDS, RATIO, SITU, grouped, made
from model_tables import COUNTERS
from resampling import Distribution, Statistic

T = TypeVar("T")
Measure = Callable[[Cost], float]
SLOW = 0.99


@dataclass(frozen=True)
class Row:
    """Updates that share a row, and those of `situ` in its place: none in the rows of `situ`."""

    key: tuple[str, ...]
    costs: list[Cost]
    situ: list[Cost]


def _rows(ledger: Ledger, sizes: Callable[[Cost], tuple[int, ...]]) -> list[Row]:
    def key(cost: Cost) -> tuple[str, ...]:
        return (cost.protocol, cost.series, cost.method, cost.edit, *map(str, sizes(cost)))

    groups = grouped((key(cost), cost) for cost in ledger.costs)
    return [
        Row(one, costs, [] if one[2] == SITU else groups.get((*one[:2], SITU, *one[3:]), []))
        for one, costs in groups.items()
    ]


def _word(name: str, index: int) -> Column[Row]:
    return text(name, lambda row: row.key[index])


def _keys(*sizes: str) -> list[Column[Row]]:
    return [_word(name, index) for index, name in enumerate(("protocol", "series", "method", "edit_planted", *sizes))]


def _records(rows: Sequence[Row]) -> int:
    return sum(len(row.costs) for row in rows)


def _drawn(values: Sequence[T], statistic: Statistic[T]) -> Cell:
    """A statistic with one interval over the values themselves."""
    value = statistic.whole([statistic.part(values)]) if values else None
    if value is None:
        return None
    distribution = Distribution([[one] for one in values], [len(values)], statistic)
    return [Exact(value), Percentile(distribution, False), Percentile(distribution, True), Word("")]


def _median(values: Sequence[float]) -> Cell:
    return _drawn(values, MEDIAN)


def _to_situ(row: Row, of: Measure) -> Cell:
    """The ratio of a cost to that of `situ` on the same automata."""
    situ: dict[int, Cost] = {}
    for cost in row.situ:
        if cost.correction == 0:
            situ[cost.seed] = cost
    return _drawn([(of(cost), of(situ[cost.seed])) for cost in row.costs if cost.seed in situ], RATIO)


def _counter(name: str) -> Measure:
    return lambda cost: cost.counters[name]


def _median_counter(name: str) -> Column[Row]:
    return number(name, lambda row: summaries.median([cost.counters[name] for cost in row.costs]))


def _seconds(cost: Cost) -> float:
    return cost.update_seconds


def _milliseconds(row: Row) -> list[float]:
    return [MILLISECONDS * cost.update_seconds for cost in row.costs]


def _edit_made(row: Row) -> str | None:
    return made(frozenset({cost.edit_made}) for cost in row.costs)


def scaling(ledger: Ledger) -> Table:
    """Cost by the size of the automaton."""
    rows = _rows(ledger, lambda cost: (cost.nodes, cost.originals))
    columns: list[Column[Row]] = [
        count("automata", lambda row: len(row.costs)),
        text("edit_made", _edit_made),
        number("|Z|", lambda row: summaries.median([z for cost in row.costs for z in cost.applicable])),
        *map(_median_counter, COUNTERS),
        estimate("hmm_fits_ratio", lambda row: _to_situ(row, _counter("hmm_fits"))),
        estimate("update_ms", lambda row: _median(_milliseconds(row)), wall=True),
        estimate("ratio", lambda row: _to_situ(row, _seconds), wall=True),
    ]
    heading = "T4 update cost by the size of the task model"
    return table("t4_scaling", heading, _keys("nodes", "originals"), columns, rows, _records(rows))


def _is_over_nodes(row: Row) -> bool:
    """Whether the series varies the nodes; else it varies the originals."""
    return len({cost.nodes for cost in row.costs}) > 1


def _slope(row: Row, of: Measure) -> Cell:
    """The exponent of the power law of a cost over what the series varies."""
    over_nodes = _is_over_nodes(row)
    law = summaries.power_law([(cost.nodes if over_nodes else cost.originals, of(cost)) for cost in row.costs])
    if law is None:
        return None
    value, half, _ = law
    return [Exact(value), Exact(value - half), Exact(value + half), Word("")]


def _growth(name: str) -> Column[Row]:
    return estimate(name, lambda row: _slope(row, _counter(name)))


def slopes(ledger: Ledger) -> Table:
    """How costs grow."""
    rows = _rows(ledger, lambda cost: ())
    columns: list[Column[Row]] = [
        text("over", lambda row: "nodes" if _is_over_nodes(row) else "originals"),
        count("automata", lambda row: len(row.costs)),
        estimate("|Z|", lambda row: _slope(row, lambda cost: summaries.mean(cost.applicable) or 0.0)),
        *map(_growth, COUNTERS),
        estimate("update_time", lambda row: _slope(row, _seconds), wall=True),
    ]
    return table("t4_slopes", "T4 growth of the update cost", _keys(), columns, rows, _records(rows))


def _meeting(row: Row, of: Measure) -> str | None:
    """Where the power laws of `situ` and of the row meet, in words."""
    own, situ = (
        summaries.power_law([(cost.nodes, of(cost)) for cost in costs]) for costs in (row.costs, row.situ)
    )
    if own is None or situ is None:
        return None
    if own[0] <= situ[0]:
        return "never"
    nodes = math.exp((situ[2] - own[2]) / (own[0] - situ[0]))
    least = min(cost.nodes for cost in row.costs + row.situ)
    return f"< {least}" if nodes < least else f"{nodes:.0f}"


def _crossing(name: str) -> Column[Row]:
    return text(name, lambda row: _meeting(row, _counter(name)))


def _time_crossing(row: Row) -> Cell:
    words = _meeting(row, _seconds)
    return None if words is None else [Word(words)]


def crossover(ledger: Ledger) -> Table:
    """From which size on a local update is the cheaper one."""
    every = [
        row for row in _rows(ledger, lambda cost: ())
        if _is_over_nodes(row) and not any(cost.applicable for cost in row.costs)
    ]
    rows = [row for row in every if row.situ]
    columns: list[Column[Row]] = [
        *map(_crossing, ("hmm_fits", "em_iterations", "classifier_fits")),
        Column("update_time", "text", _time_crossing, wall=True),
    ]
    heading = "T4 crossover: the nodes below which retraining is cheaper"
    return table("t4_crossover", heading, _keys(), columns, rows, _records(every))


def latency(ledger: Ledger) -> Table:
    """The time of one update, and of the slowest."""
    rows = [
        row for row in _rows(ledger, lambda cost: (cost.nodes,)) if any(cost.correction for cost in row.costs)
    ]

    def segments(row: Row) -> list[float]:
        return [MILLISECONDS * cost.update_seconds / cost.segments for cost in row.costs if cost.segments]

    columns: list[Column[Row]] = [
        count("corrections", lambda row: len(row.costs)),
        text("edit_made", _edit_made),
        number("segments", lambda row: summaries.median([cost.segments for cost in row.costs])),
        estimate("update_ms", lambda row: _median(_milliseconds(row)), wall=True),
        number("update_p99_ms", lambda row: summaries.quantile(_milliseconds(row), SLOW), wall=True),
        estimate("segment_ms", lambda row: _median(segments(row)), wall=True),
        number("segment_p99_ms", lambda row: summaries.quantile(segments(row), SLOW), wall=True),
    ]
    heading = "T4 time of one update, and of the slowest"
    return table("t4_latency", heading, _keys("nodes"), columns, rows, _records(rows))
