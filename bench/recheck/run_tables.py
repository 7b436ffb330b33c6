"""The tables over runs in physics, each by the definitions in its note."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import resampling
import summaries
from cells import Between, Cell, Column, Exact, Table, count, number, pooled, share, table, text
from ledger import Joint, Ledger, Rate, Run, Structure
from measures import (
    BRIER, CALIBRATION_ERROR, CONTROL, EDITS, EFFORT, FROM_SCRATCH, IMPROVEMENT, INTERQUARTILE_MEAN, MEDIAN,
    MILLISECONDS, SITU, beside, difference, effort, effort_ratio, grouped, made, mean, median, of_runs, once, partners,
    pooled as over_runs, rate, ratio, success, units, update_ms, variations,
)

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


def _rows(runs: Sequence[Run], key: Callable[[Run], tuple[str, ...]], pairs: Sequence[Pair] = ()) -> list[Row]:
    of_pairs = grouped((key(own), (own, other)) for own, other in pairs)
    return [Row(one, of, of_pairs.get(one, [])) for one, of in grouped((key(run), run) for run in runs).items()]


def _keys(*names: str) -> list[Column[Row]]:
    return [text(name, lambda row, index=index: row.key[index]) for index, name in enumerate(names)]


def _method_key(run: Run) -> tuple[str, ...]:
    return run.protocol, run.method, run.edit


METHOD_KEYS = ("protocol", "method", "edit_needed")

RUNS = count("runs", lambda row: len(row.runs))
UNITS = count("units", lambda row: units(row.runs))
VARIATIONS = count("variations", lambda row: variations(row.runs))


def _endings(*names: str) -> list[Column[Row]]:
    """How many runs ended so."""
    return [
        count(name, lambda row, name=name: sum(run.ending == name for run in row.runs)) for name in names
    ]


def _efforts(*names: str) -> list[Column[Row]]:
    return [pooled(name, lambda row, name=name: effort(row.counted(), name)) for name in names]


def headline(ledger: Ledger) -> Table:
    """Every method over all changes that need an edit."""
    runs = [run for run in ledger.counted() if run.edit != "none"]
    rows = _rows(runs, lambda run: (run.protocol, run.teacher, run.method))

    def original_before(row: Row) -> Cell:
        return None if row.key[2] == FROM_SCRATCH else success(row.runs, lambda run: run.original_before)

    columns = [
        RUNS, UNITS, VARIATIONS,
        pooled("changed", lambda row: success(row.runs, lambda run: run.after)),
        pooled("original_before", original_before),
        pooled("original", lambda row: success(row.runs, lambda run: run.original_after)),
        *_efforts("demonstrations", "keyframes"),
        pooled("update_ms", lambda row: median(row.runs, update_ms), wall=True),
    ]
    keys = _keys("protocol", "teacher", "method")
    return table("headline", "What each method reaches, and what it keeps", keys, columns, rows, len(runs))


def t1(ledger: Ledger) -> Table:
    """What corrections take, cell by cell."""
    runs = ledger.single()
    corrected = [run for run in ledger.counted() if run.method not in (FROM_SCRATCH, CONTROL)]
    pairs = beside(corrected, partners(ledger.counted(), FROM_SCRATCH))
    names = ("protocol", "task", "variation", "edit", "teacher", "method")
    rows = _rows(runs, lambda run: tuple(getattr(run, name) for name in names), pairs)

    def reached(row: Row) -> Rate:
        of = sum(run.is_reached() for run in row.counted())
        return Rate(of, of, len(row.counted()))

    columns = [
        count("seeds", lambda row: len(row.runs)),
        *_endings("not_applicable", "untaught", "spoilt", "gave_up"),
        pooled("before", lambda row: success(row.counted(), lambda run: run.before)),
        pooled("after", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("once", lambda row: once(row.counted())),
        share("reached", reached),
        *_efforts(*EFFORT),
        pooled("demonstrations_ratio", lambda row: effort_ratio(row.pairs, "demonstrations")),
        pooled("keyframes_ratio", lambda row: effort_ratio(row.pairs, "keyframes")),
        pooled("originals", lambda row: mean(row.counted(), lambda run: run.originals.demonstrations)),
        text("made_first", lambda row: made(run.corrections[0].edits for run in row.counted() if run.corrections)),
        text("made_in_all", lambda row: made(one.edits for run in row.counted() for one in run.corrections)),
    ]
    keys = _keys("protocol", "task", "variation", "edit_needed", "teacher", "method")
    heading = "T1 effort: what corrections take, against teaching from scratch"
    return table("t1", heading, keys, columns, rows, len(runs))


def methods(ledger: Ledger) -> Table:
    """Every method beside every edit."""
    counted = ledger.counted()
    pairs = beside([run for run in counted if run.method != SITU], partners(counted, SITU))
    rows = _rows(ledger.single(), _method_key, pairs)

    def demonstrations(row: Row) -> Cell:
        return None if row.key[1] == CONTROL else effort_ratio(row.pairs, "demonstrations")

    def times(row: Row) -> Cell:
        both = [(own, own.update_seconds(), situ.update_seconds()) for own, situ in row.pairs]
        return over_runs([(own, one / other) for own, one, other in both if one is not None and other], MEDIAN)

    columns = [
        RUNS, UNITS, VARIATIONS,
        *_endings("not_applicable", "untaught", "spoilt", "gave_up"),
        pooled("reached", lambda row: mean(row.counted(), lambda run: float(run.is_reached()))),
        pooled("after", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("once", lambda row: once(row.counted())),
        pooled("IQM", lambda row: over_runs(of_runs(row.counted(), lambda run: rate(run.after)), INTERQUARTILE_MEAN)),
        pooled("original", lambda row: success(row.counted(), lambda run: run.original_after)),
        *_efforts("demonstrations", "tries"),
        pooled("demonstrations_to_situ", demonstrations),
        pooled("update_ms", lambda row: median(row.counted(), update_ms), wall=True),
        pooled("update_to_situ", times, wall=True),
    ]
    heading = "Methods: every method beside every edit"
    return table("methods", heading, _keys(*METHOD_KEYS), columns, rows, len(ledger.single()))


def t2(ledger: Ledger) -> Table:
    """Successive corrections against all demonstrations at once."""
    runs = [run for run in ledger.counted() if run.joint is not None]
    rows = [
        row
        for task in (lambda run: "all", lambda run: run.task)
        for row in _rows(runs, lambda run: (*_method_key(run), task(run)))
    ]

    def of_joint(of: Callable[[Joint], Any]) -> Callable[[Run], Any]:
        return lambda run: of(run.joint) if run.joint else None

    def gain(row: Row) -> Cell:
        return difference((run, rate(run.after), rate(run.joint.changed)) for run in row.runs if run.joint)

    columns = [
        RUNS, UNITS,
        pooled("separate", lambda row: success(row.runs, lambda run: run.after)),
        pooled("joint", lambda row: success(row.runs, of_joint(lambda joint: joint.changed))),
        pooled("difference", gain),
        pooled("original_separate", lambda row: success(row.runs, lambda run: run.original_after)),
        pooled("original_joint", lambda row: success(row.runs, of_joint(lambda joint: joint.original))),
    ]
    measures: dict[str, Callable[[Structure], float | None]] = {
        "nodes": lambda structure: structure.nodes,
        "node_F1": lambda structure: structure.node_f1,
        "edge_F1": lambda structure: structure.edge_f1,
    }
    for name, measure in measures.items():
        def scored(of: Any, measure: Callable[[Structure], float | None] = measure) -> float | None:
            return measure(of.structure) if of.structure else None

        columns += [
            pooled(f"{name}_separate", lambda row, scored=scored: mean(row.runs, scored)),
            pooled(f"{name}_joint", lambda row, scored=scored: mean(row.runs, of_joint(scored))),
        ]

    def likelihood(of: Any) -> float | None:
        return of.held_out.per_keyframe() if of.held_out else None

    columns += [
        pooled("likelihood_separate", lambda row: median(row.runs, likelihood)),
        pooled("likelihood_joint", lambda row: median(row.runs, of_joint(likelihood))),
    ]
    heading = "T2 separate or joint: successive corrections against all demonstrations at once"
    return table("t2", heading, _keys(*METHOD_KEYS, "task"), columns, rows, len(runs))


def t3(ledger: Ledger) -> Table:
    """Edits needed and made."""
    runs = [run for run in ledger.counted() if run.method != FROM_SCRATCH]
    rows = _rows(runs, _method_key)

    def every(run: Run) -> list[frozenset[str]]:
        return [one.edits for one in run.corrections]

    def first(run: Run) -> list[frozenset[str]]:
        return [one.edits for one in run.corrections if one.shows_change][:1]

    columns = [RUNS, UNITS, VARIATIONS, count("uncorrected", lambda row: sum(not run.corrections for run in row.runs))]
    for name, sets in (("first", first), ("all", every)):
        def several(row: Row, sets: Any = sets) -> int:
            return sum(len(edits) > 1 for run in row.runs for edits in sets(run))

        def right(row: Row, sets: Any = sets) -> Cell:
            of = [(run, sets(run)) for run in row.runs if sets(run)]
            return ratio([(run, (sum(one == {run.edit} for one in edits), len(edits))) for run, edits in of])

        columns += [
            count(f"{name}_{edit}", lambda row, edit=edit, sets=sets: sum(
                edits == {edit} for run in row.runs for edits in sets(run)))
            for edit in EDITS
        ]
        columns += [count(f"{name}_several", several), pooled(f"{name}_right", right)]
    scores: dict[str, Callable[[Structure], float | None]] = {
        "node_F1": lambda structure: structure.node_f1,
        "edge_F1": lambda structure: structure.edge_f1,
        "duplicates": lambda structure: structure.duplicates,
    }
    columns += [
        pooled(name, lambda row, of=of: mean(row.runs, lambda run: of(run.structure) if run.structure else None))
        for name, of in scores.items()
    ]
    return table("t3", "T3 edits: needed and made", _keys(*METHOD_KEYS), columns, rows, len(runs))


def t4_physics(ledger: Ledger) -> Table:
    """What corrections in physics cost."""
    runs = [run for run in ledger.counted() if run.corrections]
    rows = _rows(runs, _method_key)

    def corrections(row: Row) -> list[Any]:
        return [(run, one) for run in row.runs for one in run.corrections]

    def steps(row: Row) -> list[Any]:
        return [(run, step) for run, one in corrections(row) for step in one.steps]

    def of_model(row: Row) -> Cell:
        return over_runs(
            [(run, step.applicable / step.model_size) for run, step in steps(row) if step.model_size], MEDIAN
        )

    def held(row: Row) -> list[Any]:
        return [(run, step.retrieved) for run, step in steps(row) if step.retrieved is not None]

    def times(row: Row) -> Cell:
        return over_runs([(run, MILLISECONDS * one.update_seconds) for run, one in corrections(row)], MEDIAN)

    columns = [
        count("corrections", lambda row: len(corrections(row))),
        count("steps", lambda row: len(steps(row))),
        number("|Z|", lambda row: summaries.median([step.applicable for _, step in steps(row)])),
        number("|T|", lambda row: summaries.median([step.model_size for _, step in steps(row)])),
        pooled("|Z|/|T|", of_model),
        count("held", lambda row: len(held(row))),
        pooled("A1.6_right", lambda row: ratio([(run, (float(found), 1)) for run, found in held(row)])),
        *(
            number(name, lambda row, name=name: summaries.median([one.counters[name] for _, one in corrections(row)]))
            for name in COUNTERS
        ),
        pooled("update_ms", times, wall=True),
    ]
    return table("t4_physics", "T4 update cost in physics", _keys(*METHOD_KEYS), columns, rows, len(runs))


COUNTERS = (
    "hmm_fits", "em_iterations", "divergences", "classifier_fits", "classifier_evaluations", "nodes_touched",
    "segments_touched",
)


def t5(ledger: Ledger) -> Table:
    """What a corrected model still does."""
    runs = [
        run for run in ledger.runs
        if run.counts() and run.original_after is not None and run.method != FROM_SCRATCH
    ]

    def key(run: Run) -> tuple[str, ...]:
        sequence, number_of = run.stage or ("", "")
        return (run.protocol, run.task, sequence, str(number_of), run.variation, run.edit, run.teacher, run.method)

    def earlier(run: Run) -> Rate | None:
        rates = list(run.earlier.values())
        if not rates:
            return None
        return Rate(*(sum(getattr(one, name) for one in rates) for name in ("successes", "once", "rollouts")))

    def word(name: str, index: int) -> Column[Row]:
        return text(name, lambda row: row.key[index] or None)

    keys = _keys("protocol", "task", "sequence", "stage", "variation", "edit_needed", "teacher", "method")
    keys[2:4] = [word("sequence", 2), word("stage", 3)]
    columns = [
        RUNS,
        pooled("before", lambda row: success(row.runs, lambda run: run.before)),
        pooled("after", lambda row: success(row.runs, lambda run: run.after)),
        pooled("original_before", lambda row: success(row.runs, lambda run: run.original_before)),
        pooled("original_after", lambda row: success(row.runs, lambda run: run.original_after)),
        pooled("earlier", lambda row: success(row.runs, earlier)),
        *_efforts("demonstrations"),
    ]
    heading = "T5 retention: what a corrected model still does"
    return table("t5", heading, keys, columns, _rows(runs, key), len(runs))


def t5_sequences(ledger: Ledger) -> Table:
    """What is learned and what is kept over several changes."""
    stages = [run for run in ledger.runs if run.stage is not None]
    names = ("protocol", "task", "teacher", "method", "seed")
    scored: list[tuple[tuple[str, ...], Run, tuple[float, float | None, float]]] = []
    for key, runs in grouped(
        ((*(getattr(run, name) for name in names), run.stage[0]), run) for run in stages if run.stage
    ).items():
        runs.sort(key=lambda run: run.stage[1] if run.stage else 0)
        rates = [[rate(run.earlier.get(other.variation)) for other in runs[:n]] + [rate(run.after)]
                 for n, run in enumerate(runs)]
        is_whole = [run.stage[1] for run in runs if run.stage] == list(range(1, len(runs) + 1))
        if is_whole and all(one is not None for row in rates for one in row):
            score = summaries.sequence(rates)
            protocol, task, teacher, method, _, sequence = key
            for place in (("all", "all"), (task, sequence)):
                scored.append(((protocol, teacher, method, *place), runs[-1], score))
    groups = list(grouped((key, (run, score)) for key, run, score in scored).items())

    def column(name: str, index: int) -> Column[Any]:
        return pooled(name, lambda row: ratio(
            [(run, (score[index], 1)) for run, score in row[1] if score[index] is not None]))

    keys = [
        text(name, lambda row, index=index: row[0][index])
        for index, name in enumerate(("protocol", "teacher", "method", "task", "sequence"))
    ]
    columns = [count("runs", lambda row: len(row[1])), column("FWT", 0), column("NBT", 1), column("AUC", 2)]
    heading = "T5 sequences: what is learned, and what is kept, over several changes"
    return table("t5_sequences", heading, keys, columns, groups, len(scored) // 2)


def t6(ledger: Ledger) -> Table:
    """What it takes, by the teacher."""
    runs = [run for run in ledger.single() if run.edit != "none" and run.ending != "not_applicable"]
    rows = _rows(runs, lambda run: (run.protocol, run.method, run.teacher))

    def failed(row: Row) -> Cell:
        given = ((run, run.originals, run.effort) for run in row.runs)
        return ratio([
            (run, (first.tries + last.tries - first.demonstrations - last.demonstrations, first.tries + last.tries))
            for run, first, last in given
        ])

    def primitives(run: Run) -> float | None:
        return run.structure.nodes / run.structure.skills if run.structure and run.structure.skills else None

    columns = [
        RUNS, UNITS, VARIATIONS,
        *_endings("untaught", "spoilt", "gave_up"),
        pooled("changed", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("original", lambda row: success(row.counted(), lambda run: run.original_after)),
        *_efforts(*EFFORT),
        pooled("failed", failed),
        pooled("primitives_a_skill", lambda row: mean(row.counted(), primitives)),
    ]
    heading = "T6 teachers: what it takes, and what comes of it, by the teacher"
    return table("t6", heading, _keys("protocol", "method", "teacher"), columns, rows, len(runs))


def t7(ledger: Ledger) -> Table:
    """Calibration and likelihood."""
    runs = ledger.counted()

    def calibrations(row: Row) -> list[Any]:
        return of_runs(row.runs, lambda run: run.calibration)

    def accuracy(row: Row) -> Cell:
        return ratio([(run, (sum(one.right), sum(one.choices))) for run, one in calibrations(row)])

    def explained(row: Row) -> Cell:
        return ratio([(run, (one.explained, one.segments)) for run, one in of_runs(row.runs, lambda run: run.held_out)])

    columns = [
        RUNS, UNITS, VARIATIONS,
        count("choices", lambda row: sum(sum(one.choices) for _, one in calibrations(row))),
        pooled("accuracy", accuracy),
        pooled("Brier", lambda row: over_runs(calibrations(row), BRIER)),
        pooled("ECE", lambda row: over_runs(calibrations(row), CALIBRATION_ERROR)),
        pooled("explained", explained),
        pooled("likelihood", lambda row: median(
            row.runs, lambda run: run.held_out.per_keyframe() if run.held_out else None)),
    ]
    heading = "T7 confidence: calibration at the branches, and likelihood of what was held out"
    return table("t7", heading, _keys(*METHOD_KEYS), columns, _rows(runs, _method_key), len(runs))


def endings(ledger: Ledger) -> Table:
    """Why runs came to nothing."""
    names = {"untaught": "untaught", "gave_up": "gave up", "spoilt": "spoilt"}

    def key(run: Run) -> tuple[str, ...]:
        place = ("all", "all") if run.ending == "untaught" else (run.variation, run.method)
        return (run.protocol, run.task, place[0], run.teacher, place[1], names[run.ending], run.why)

    def runs_of(row: Row) -> int:
        return len({run.seed for run in row.runs}) if row.key[5] == "untaught" else len(row.runs)

    runs = [run for run in ledger.runs if run.ending in names]
    keys = _keys("protocol", "task", "variation", "teacher", "method", "ending", "why")
    heading = "Runs that came to nothing, and why"
    return table("endings", heading, keys, [count("runs", runs_of)], _rows(runs, key), len(runs))


def _groups(run: Run) -> list[str]:
    """The groups of pooled rows that a run is in."""
    if run.edit == "none":
        return []
    if run.edit != "edge-addition":
        return ["all", "all but self-loops", run.edit]
    return ["all", "edge-addition: self-loop"] if run.self_loop else ["all", "all but self-loops", "edge-addition: other"]


def _question(runs: Sequence[Run], pairs: Sequence[Pair] = ()) -> list[Row]:
    of_pairs = {own.place() + (own.method,): (own, other) for own, other in pairs}
    groups = grouped(
        ((run.protocol, run.teacher, run.method, group), run) for run in runs for group in _groups(run)
    )
    return [
        Row(key, of, [of_pairs[place] for run in of if (place := run.place() + (run.method,)) in of_pairs])
        for key, of in groups.items()
    ]


QUESTION_KEYS = ("protocol", "teacher", "method", "edit_needed")


def correct_or_scratch(ledger: Ledger) -> Table:
    """The paper's first question."""
    anew = partners(ledger.counted(), FROM_SCRATCH)
    pairs = beside([run for run in ledger.counted() if run.method not in (FROM_SCRATCH, CONTROL)], anew)
    rows = _question([own for own, _ in pairs], pairs)
    columns = [
        RUNS, UNITS, VARIATIONS,
        *(pooled(name, lambda row, name=name: effort_ratio(row.pairs, name)) for name in EFFORT),
        pooled("success", lambda row: difference((own, rate(own.after), rate(other.after)) for own, other in row.pairs)),
    ]
    records = sum(own.edit != "none" for own, _ in pairs)
    heading = "To correct, or to teach from scratch"
    return table("correct_or_scratch", heading, _keys(*QUESTION_KEYS), columns, rows, records)


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
    return table("separate_or_joint", "Separate, or joint", _keys(*QUESTION_KEYS), columns, _question(runs), records)


def _charged(run: Run) -> float | None:
    """The demonstrations that a run took; nothing of a control, which is taught nothing."""
    return None if run.method == CONTROL else run.charged()


MEASURES: dict[str, Callable[[Run], float | None]] = {
    "success": lambda run: rate(run.after),
    "demonstrations": _charged,
    "original": lambda run: rate(run.original_after),
}


def paired(ledger: Ledger) -> Table:
    """SITU beside every other method."""
    counted = [run for run in ledger.counted() if run.edit != "none"]
    others = [(situ, other) for other, situ in beside([run for run in counted if run.method != SITU],
                                                      partners(counted, SITU))]
    groups = grouped(((situ.protocol, situ.teacher, other.method), (situ, other)) for situ, other in others)
    rows = [Row(key, [own for own, _ in pairs], pairs) for key, pairs in groups.items()]

    def apart(row: Row, name: str) -> list[tuple[Run, float]]:
        both = ((own, MEASURES[name](own), MEASURES[name](other)) for own, other in row.pairs)
        return [(own, one - other) for own, one, other in both if one is not None and other is not None]

    tests: dict[tuple[tuple[str, ...], str], resampling.FlipTest] = {}
    for row in rows:
        for name in MEASURES:
            means = [
                summaries.mean(of) or 0.0
                for of in grouped((run.unit(), value) for run, value in apart(row, name)).values()
            ]
            if means:
                tests[row.key, name] = resampling.flip_test(means)
    corrected = [
        dict(zip(tests, summaries.holm([getattr(test, part) for test in tests.values()])))
        for part in ("low", "high")
    ]

    def least(row: Row) -> float | None:
        return next((tests[row.key, name].least for name in MEASURES if (row.key, name) in tests), None)

    def p(row: Row, name: str) -> Cell:
        test = tests.get((row.key, name))
        if test is None:
            return None
        return [Between(test.low, test.high) if test.is_drawn else Exact(test.p)]

    def holm(row: Row, name: str) -> Cell:
        if (row.key, name) not in tests:
            return None
        low, high = (of[row.key, name] for of in corrected)
        return [Exact(low) if low == high else Between(low, high)]

    def improvement(row: Row) -> Cell:
        both = ((own, rate(own.after), rate(other.after)) for own, other in row.pairs)
        return over_runs([(own, (own.changed_task(), one, other)) for own, one, other in both
                          if one is not None and other is not None], IMPROVEMENT)

    columns: list[Column[Row]] = [RUNS, UNITS, pooled("improvement", improvement), number("least_p", least)]
    for name in MEASURES:
        columns += [
            pooled(name, lambda row, name=name: ratio([(run, (value, 1)) for run, value in apart(row, name)])),
            Column(f"p_{name}", "number", lambda row, name=name: p(row, name)),
            Column(f"Holm_{name}", "number", lambda row, name=name: holm(row, name)),
        ]
    keys = _keys("protocol", "teacher", "other")
    return table("paired", "SITU beside every other method, paired", keys, columns, rows, len(others))
