"""Tables of what corrections reach and take, each by the definitions in its note."""

from cells import Cell, Table, count, pooled, share, table, text
from ledger import Effort, Ledger, Rate, Run
from measures import (
    CONTROL, EFFORT, FROM_SCRATCH, INTERQUARTILE_MEAN, MEDIAN, SITU, all_edits, beside, effort_ratio, first_edits, made,
    mean, median, of_runs, once, partners, pooled as over_runs, rate, ratio, share as share_of, success, update_ms,
)
from rows import METHOD_KEYS, RUNS, UNITS, VARIATIONS, Row, efforts, endings, keys, method_key, rows


def headline(ledger: Ledger) -> Table:
    """Every method over all changes that need an edit."""
    runs = [run for run in ledger.single() if run.edit != "none" and run.ending != "not_applicable"]
    of_rows = rows(runs, lambda run: (run.protocol, run.teacher, run.method))

    def original_before(row: Row) -> Cell:
        return None if row.key[2] == FROM_SCRATCH else success(row.counted(), lambda run: run.original_before)

    def originals(run: Run) -> float | None:
        return None if run.method == FROM_SCRATCH else run.originals.keyframes

    columns = [
        RUNS, UNITS, VARIATIONS,
        *endings("untaught", "spoilt", "gave_up", "broken_off"),
        pooled("changed", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("original_before", original_before),
        pooled("original", lambda row: success(row.counted(), lambda run: run.original_after)),
        *efforts("demonstrations", "keyframes"),
        pooled("originals", lambda row: mean(row.counted(), originals)),
        pooled("update_ms", lambda row: median(row.counted(), update_ms), wall=True),
    ]
    of_keys = keys("protocol", "teacher", "method")
    return table("headline", "What each method reaches, and what it keeps", of_keys, columns, of_rows, len(runs))


def t1(ledger: Ledger) -> Table:
    """What corrections take, cell by cell."""
    runs = ledger.single()
    corrected = [run for run in ledger.counted() if run.method not in (FROM_SCRATCH, CONTROL)]
    pairs = beside(corrected, partners(ledger.counted(), FROM_SCRATCH))
    names = ("protocol", "task", "variation", "edit", "teacher", "method")
    of_rows = rows(runs, lambda run: tuple(getattr(run, name) for name in names), pairs)

    def reached(row: Row) -> Rate:
        of = sum(run.is_reached() for run in row.counted())
        return Rate(of, of, len(row.counted()))

    def originals(run: Run) -> float | None:
        return None if run.method == FROM_SCRATCH else run.originals.demonstrations

    columns = [
        count("seeds", lambda row: len(row.counted())),
        *endings("not_applicable", "untaught", "spoilt", "gave_up", "broken_off"),
        pooled("before", lambda row: success(row.counted(), lambda run: run.before)),
        pooled("after", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("once", lambda row: once(row.counted())),
        share("reached", reached),
        *efforts(*EFFORT),
        pooled("demonstrations_ratio", lambda row: effort_ratio(row.pairs, "demonstrations")),
        pooled("keyframes_ratio", lambda row: effort_ratio(row.pairs, "keyframes")),
        pooled("originals", lambda row: mean(row.counted(), originals)),
        text("made_first", lambda row: made(edits for _, edits in of_runs(row.counted(), first_edits))),
        text("made_in_all", lambda row: made(edits for _, edits in of_runs(row.counted(), all_edits))),
    ]
    of_keys = keys("protocol", "task", "variation", "edit_needed", "teacher", "method")
    heading = "T1 effort: what corrections take, against teaching from scratch"
    return table("t1", heading, of_keys, columns, of_rows, len(runs))


def methods(ledger: Ledger) -> Table:
    """Every method beside every edit."""
    counted = ledger.counted()
    pairs = beside([run for run in counted if run.method != SITU], partners(counted, SITU))
    of_rows = rows(ledger.single(), method_key, pairs)

    def demonstrations(row: Row) -> Cell:
        return None if row.key[1] == CONTROL else effort_ratio(row.pairs, "demonstrations")

    def times(row: Row) -> Cell:
        both = [(own, own.update_seconds(), situ.update_seconds()) for own, situ in row.pairs]
        return over_runs([(own, one / other) for own, one, other in both if one is not None and other], MEDIAN)

    columns = [
        RUNS, UNITS, VARIATIONS,
        *endings("not_applicable", "untaught", "spoilt", "gave_up", "broken_off"),
        pooled("reached", lambda row: share_of([(run, (run.is_reached(), 1)) for run in row.counted()])),
        count("below_target", lambda row: sum(run.is_reached_by_luck() for run in row.counted())),
        pooled("after", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("once", lambda row: once(row.counted())),
        pooled("IQM", lambda row: over_runs(of_runs(row.counted(), lambda run: rate(run.after)), INTERQUARTILE_MEAN)),
        pooled("original", lambda row: success(row.counted(), lambda run: run.original_after)),
        *efforts("demonstrations", "tries"),
        pooled("demonstrations_to_situ", demonstrations),
        pooled("update_ms", lambda row: median(row.counted(), update_ms), wall=True),
        pooled("update_to_situ", times, wall=True),
    ]
    heading = "Methods: every method beside every edit"
    return table("methods", heading, keys(*METHOD_KEYS), columns, of_rows, len(ledger.single()))


def t6(ledger: Ledger) -> Table:
    """What it takes, by the teacher."""
    runs = [run for run in ledger.single() if run.edit != "none" and run.ending != "not_applicable"]
    of_rows = rows(runs, lambda run: (run.protocol, run.method, run.teacher))

    def spent(row: Row) -> list[tuple[Run, list[Effort]]]:
        # Teaching from scratch does not build on the originals.
        return [(run, [run.effort] if run.method == FROM_SCRATCH else [run.originals, run.effort]) for run in row.runs]

    def failed(row: Row) -> Cell:
        return share_of([
            (run, (sum(one.tries - one.demonstrations for one in of), sum(one.tries for one in of)))
            for run, of in spent(row)
        ])

    def foreseen(row: Row) -> Cell:
        if not any(one.foreseen for _, of in spent(row) for one in of):
            return None
        return ratio([(run, (sum(one.foreseen for one in of), sum(one.tries for one in of))) for run, of in spent(row)])

    def primitives(run: Run) -> float | None:
        return run.structure.nodes / run.structure.skills if run.structure and run.structure.skills else None

    columns = [
        RUNS, UNITS, VARIATIONS,
        *endings("untaught", "spoilt", "gave_up", "broken_off"),
        pooled("changed", lambda row: success(row.counted(), lambda run: run.after)),
        pooled("original", lambda row: success(row.counted(), lambda run: run.original_after)),
        *efforts(*EFFORT),
        pooled("failed", failed),
        pooled("foreseen", foreseen),
        pooled("primitives_a_skill", lambda row: mean(row.counted(), primitives)),
    ]
    heading = "T6 teachers: what it takes, and what comes of it, by the teacher"
    return table("t6", heading, keys("protocol", "method", "teacher"), columns, of_rows, len(runs))


def came_to_nothing(ledger: Ledger) -> Table:
    """Why runs came to nothing."""
    names = {"untaught": "untaught", "gave_up": "gave up", "spoilt": "spoilt"}
    names |= {"method_error": "method error", "timed_out": "timed out", "panicked": "panicked"}

    def key(run: Run) -> tuple[str, ...]:
        place = ("all", "all") if run.ending == "untaught" else (run.variation, run.method)
        return (run.protocol, run.task, place[0], run.teacher, place[1], names[run.ending], run.why)

    def runs_of(row: Row) -> int:
        return len({run.seed for run in row.runs}) if row.key[5] == "untaught" else len(row.runs)

    runs = [run for run in ledger.runs if run.ending in names]
    of_keys = keys("protocol", "task", "variation", "teacher", "method", "ending", "why")
    heading = "Runs that came to nothing, and why"
    return table("endings", heading, of_keys, [count("runs", runs_of)], rows(runs, key), len(runs))
