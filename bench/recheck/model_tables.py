"""Tables of the models that corrections led to, each by the definitions in its note."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import summaries
from cells import Cell, Column, Table, count, number, pooled, table, text
from ledger import Calibration, Correction, Joint, Ledger, Rate, Run, Step, Structure
from measures import (
    BRIER, CALIBRATION_ERROR, CONTROL, EDITS, FROM_SCRATCH, MEDIAN, MILLISECONDS, all_edits, difference, first_edits,
    grouped, mean, median, of_runs, pooled as over_runs, rate, ratio, share, success,
)
from rows import METHOD_KEYS, RUNS, UNITS, VARIATIONS, Row, efforts, keys, method_key, rows


T = TypeVar("T")

COUNTERS = (
    "hmm_fits", "em_iterations", "divergences", "classifier_fits", "classifier_evaluations", "nodes_touched",
    "segments_touched",
)


Measure = Callable[[Structure], float | None]

F1: dict[str, Measure] = {
    "node_F1": lambda structure: structure.node_f1,
    "edge_F1": lambda structure: structure.edge_f1,
}


def _scored(measure: Measure) -> Callable[[Run | Joint], float | None]:
    """A measure of the structure of a model, where it is known."""
    return lambda of: measure(of.structure) if of.structure else None


def _likelihood(of: Run | Joint) -> float | None:
    """Nats per keyframe of the demonstration that was held out."""
    return of.held_out.per_keyframe() if of.held_out else None


def _of_joint(of: Callable[[Joint], T | None]) -> Callable[[Run], T | None]:
    """Something of the joint model of a run."""
    return lambda run: of(run.joint) if run.joint else None


def _structures(name: str, measure: Measure) -> list[Column[Row]]:
    """A measure of the structure of both models."""
    own = _scored(measure)
    return [
        pooled(f"{name}_separate", lambda row: mean(row.runs, own)),
        pooled(f"{name}_joint", lambda row: mean(row.runs, _of_joint(own))),
    ]


def t2(ledger: Ledger) -> Table:
    """Successive corrections against all demonstrations at once."""
    runs = [run for run in ledger.counted() if run.joint is not None]
    every = rows(runs, lambda run: (*method_key(run), "all"))
    each = rows(runs, lambda run: (*method_key(run), run.task))

    def gain(row: Row) -> Cell:
        return difference((run, rate(run.after), rate(run.joint.changed)) for run in row.runs if run.joint)

    columns = [
        RUNS, UNITS,
        pooled("separate", lambda row: success(row.runs, lambda run: run.after)),
        pooled("joint", lambda row: success(row.runs, _of_joint(lambda joint: joint.changed))),
        pooled("difference", gain),
        pooled("original_separate", lambda row: success(row.runs, lambda run: run.original_after)),
        pooled("original_joint", lambda row: success(row.runs, _of_joint(lambda joint: joint.original))),
        *_structures("nodes", lambda structure: structure.nodes),
    ]
    for name, measure in F1.items():
        columns += _structures(name, measure)
    columns += [
        pooled("likelihood_separate", lambda row: median(row.runs, _likelihood)),
        pooled("likelihood_joint", lambda row: median(row.runs, _of_joint(_likelihood))),
    ]
    heading = "T2 separate or joint: successive corrections against all demonstrations at once"
    return table("t2", heading, keys(*METHOD_KEYS, "task"), columns, every + each, len(runs))


def _made(name: str, of: Callable[[Run], frozenset[str] | None]) -> list[Column[Row]]:
    """How often each edit was made alone and several were, and the share that was the edit needed."""

    def sets(row: Row) -> list[tuple[Run, frozenset[str]]]:
        return of_runs(row.runs, of)

    def alone(edit: str) -> Column[Row]:
        return count(f"{name}_{edit}", lambda row: sum(edits == {edit} for _, edits in sets(row)))

    def right(row: Row) -> Cell:
        return share([(run, (edits == {run.edit}, 1)) for run, edits in sets(row)])

    several: Column[Row] = count(f"{name}_several", lambda row: sum(len(edits) > 1 for _, edits in sets(row)))
    return [*map(alone, EDITS), several, pooled(f"{name}_right", right)]


UNCORRECTED: Column[Row] = count("uncorrected", lambda row: sum(not run.corrections for run in row.runs))


def _structure(name: str, measure: Measure) -> Column[Row]:
    return pooled(name, lambda row: mean(row.runs, _scored(measure)))


def _obedience(name: str) -> Column[Row]:
    """How often the models of a row had to be made to do what was shown, or do not."""

    def of(row: Row) -> int:
        return sum(correction.obedience.get(name, 0) for run in row.runs for correction in run.corrections)

    return count(name, of)


def t3(ledger: Ledger) -> Table:
    """Edits needed and made."""
    runs = [run for run in ledger.counted() if run.method not in (FROM_SCRATCH, CONTROL)]
    columns = [
        RUNS, UNITS, VARIATIONS, UNCORRECTED,
        *_made("first", first_edits),
        *_made("all", all_edits),
        *map(_obedience, ("retired", "aliased", "disobeyed")),
        *(_structure(name, measure) for name, measure in F1.items()),
        _structure("duplicates", lambda structure: structure.duplicates),
    ]
    return table("t3", "T3 edits: needed and made", keys(*METHOD_KEYS), columns, rows(runs, method_key), len(runs))


def _corrections(row: Row) -> list[tuple[Run, Correction]]:
    return [(run, one) for run in row.runs for one in run.corrections]


def _steps(row: Row) -> list[tuple[Run, Step]]:
    return [(run, step) for run, one in _corrections(row) for step in one.steps]


CORRECTIONS: Column[Row] = count("corrections", lambda row: len(_corrections(row)))


def _counter(name: str) -> Column[Row]:
    """The median of a counter over corrections."""
    return number(name, lambda row: summaries.median([one.counters[name] for _, one in _corrections(row)]))


def t4_physics(ledger: Ledger) -> Table:
    """What corrections in physics cost."""
    runs = [run for run in ledger.counted() if run.corrections]

    def of_model(row: Row) -> Cell:
        steps = [(run, step) for run, step in _steps(row) if step.model_size]
        return over_runs([(run, step.applicable / step.model_size) for run, step in steps], MEDIAN)

    def held(row: Row) -> list[tuple[Run, bool]]:
        return [(run, step.retrieved) for run, step in _steps(row) if step.retrieved is not None]

    def right(row: Row) -> Cell:
        return share([(run, (found, 1)) for run, found in held(row)])

    def times(row: Row) -> Cell:
        return over_runs([(run, MILLISECONDS * one.update_seconds) for run, one in _corrections(row)], MEDIAN)

    columns = [
        CORRECTIONS,
        count("steps", lambda row: len(_steps(row))),
        number("|Z|", lambda row: summaries.median([step.applicable for _, step in _steps(row)])),
        number("|T|", lambda row: summaries.median([step.model_size for _, step in _steps(row)])),
        pooled("|Z|/|T|", of_model),
        count("held", lambda row: len(held(row))),
        pooled("A1.6_right", right),
        *map(_counter, COUNTERS),
        pooled("update_ms", times, wall=True),
    ]
    heading = "T4 update cost in physics"
    return table("t4_physics", heading, keys(*METHOD_KEYS), columns, rows(runs, method_key), len(runs))


def _stage(run: Run) -> tuple[str, int]:
    """The sequence that a run is a stage of, and its number."""
    return run.stage or ("", 0)


def t5(ledger: Ledger) -> Table:
    """What a corrected model still does."""
    kept = [run for run in ledger.runs if run.counts() and run.original_after is not None]
    runs = [run for run in kept if run.method != FROM_SCRATCH]

    def key(run: Run) -> tuple[str, ...]:
        sequence, stage = _stage(run)
        of_stage = (sequence, str(stage or ""))
        return (run.protocol, run.task, *of_stage, run.variation, run.edit, run.teacher, run.method)

    def earlier(run: Run) -> Rate | None:
        rates = list(run.earlier.values())
        if not rates:
            return None
        return Rate(*(sum(getattr(one, name) for one in rates) for name in ("successes", "once", "rollouts")))

    columns = [
        RUNS,
        pooled("before", lambda row: success(row.runs, lambda run: run.before)),
        pooled("after", lambda row: success(row.runs, lambda run: run.after)),
        pooled("original_before", lambda row: success(row.runs, lambda run: run.original_before)),
        pooled("original_after", lambda row: success(row.runs, lambda run: run.original_after)),
        pooled("earlier", lambda row: success(row.runs, earlier)),
        *efforts("demonstrations"),
    ]
    names = ("protocol", "task", "sequence", "stage", "variation", "edit_needed", "teacher", "method")
    heading = "T5 retention: what a corrected model still does"
    return table("t5", heading, keys(*names), columns, rows(runs, key), len(runs))


Score = tuple[float, float | None, float]


def _score(stages: list[Run]) -> Score | None:
    """FWT, NBT and AUC of the stages of a sequence, in order; nothing where a stage or a rate is missing."""
    if [_stage(run)[1] for run in stages] != list(range(1, len(stages) + 1)):
        return None
    rates: list[list[float]] = []
    for n, run in enumerate(stages):
        found = [rate(run.earlier.get(other.variation)) for other in stages[:n]] + [rate(run.after)]
        rates.append([one for one in found if one is not None])
        if len(rates[-1]) != n + 1:
            return None
    return summaries.sequence(rates)


@dataclass(frozen=True)
class _Sequences:
    """A row of sequences, each by its last run and its score."""

    key: tuple[str, ...]
    scores: list[tuple[Run, Score]]


def _sequence_key(name: str, index: int) -> Column[_Sequences]:
    return text(name, lambda row: row.key[index])


def _mean_score(name: str, index: int) -> Column[_Sequences]:
    def cell(row: _Sequences) -> Cell:
        values = ((run, score[index]) for run, score in row.scores)
        return ratio([(run, (value, 1)) for run, value in values if value is not None])

    return pooled(name, cell)


def t5_sequences(ledger: Ledger) -> Table:
    """What is learned and what is kept over several changes."""
    runs = [run for run in ledger.runs if run.stage is not None]
    sequences = grouped(
        ((run.protocol, run.task, run.teacher, run.method, run.seed, _stage(run)[0]), run) for run in runs
    )
    scored: list[tuple[tuple[str, ...], tuple[Run, Score]]] = []
    for stages in sequences.values():
        stages.sort(key=_stage)
        score, last = _score(stages), stages[-1]
        if score is not None:
            for of in (("all", "all"), (last.task, _stage(last)[0])):
                scored.append(((last.protocol, last.teacher, last.method, *of), (last, score)))
    names = ("protocol", "teacher", "method", "task", "sequence")
    columns = [
        count("runs", lambda row: len(row.scores)),
        *(_mean_score(name, index) for index, name in enumerate(("FWT", "NBT", "AUC"))),
    ]
    heading = "T5 sequences: what is learned, and what is kept, over several changes"
    of_rows = [_Sequences(key, scores) for key, scores in grouped(scored).items()]
    of_keys = [_sequence_key(name, index) for index, name in enumerate(names)]
    return table("t5_sequences", heading, of_keys, columns, of_rows, len(scored) // 2)


def _calibrations(row: Row) -> list[tuple[Run, Calibration]]:
    return of_runs(row.runs, lambda run: run.calibration)


def t7(ledger: Ledger) -> Table:
    """Calibration and likelihood."""
    runs = ledger.counted()

    def accuracy(row: Row) -> Cell:
        return share([(run, (sum(one.right), sum(one.choices))) for run, one in _calibrations(row)])

    def error(row: Row) -> float | None:
        all_of = [one for _, one in _calibrations(row)]
        return CALIBRATION_ERROR.whole([CALIBRATION_ERROR.part(all_of)]) if all_of else None

    def explained(row: Row) -> Cell:
        return share([(run, (one.explained, one.segments)) for run, one in of_runs(row.runs, lambda run: run.held_out)])

    columns = [
        RUNS, UNITS, VARIATIONS,
        count("choices", lambda row: sum(sum(one.choices) for _, one in _calibrations(row))),
        pooled("accuracy", accuracy),
        pooled("Brier", lambda row: over_runs(_calibrations(row), BRIER)),
        number("ECE", error),
        pooled("explained", explained),
        pooled("likelihood", lambda row: median(row.runs, _likelihood)),
    ]
    heading = "T7 confidence: calibration at the branches, and likelihood of what was held out"
    return table("t7", heading, keys(*METHOD_KEYS), columns, rows(runs, method_key), len(runs))
