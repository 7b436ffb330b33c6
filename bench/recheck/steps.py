"""What each step from the former protocol to this one changes in the answers to the paper's two questions.

Command:  python3 bench/recheck/steps.py ANNOUNCED SILENT
Needs Python 3.10 and nothing else. Both are folders with a ledger of one protocol. Of the first, the runs of the
teacher who errs in nothing are read (`expert`); of the second, those of one who errs in nothing but never names an
object anew (`silent`), which is how the former protocol cut. The former reading counts five corrections at the most,
of a run that did not reach the target what it spent, and success in the rollouts that ended the corrections. Each step
changes one thing and keeps the ones before it; the last puts the full retraining that has SITU's rule of modification
in place of the joint model. Every value has a 95 % interval by units (family and seed) within families.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ledger import Ledger, LedgerError, Rate, Run, read
from measures import FROM_SCRATCH, SITU, beside, partners, rate
from ratios import ratio

FORMER_BUDGET = 5
TEACHERS = ("expert", "silent")

Pair = tuple[Run, Run]
# What a pair adds to the two sums of a ratio.
Terms = Callable[[Pair], tuple[float, float] | None]


@dataclass(frozen=True)
class Reading:
    """How a run is read. `budget` is the former one, or none: then that of the ledger is meant."""

    budget: int | None
    is_fresh: bool

    def _given(self, run: Run) -> int:
        return len(run.corrections) if self.budget is None else min(len(run.corrections), self.budget)

    def _is_cut(self, run: Run) -> bool:
        return self.budget is not None and run.method != FROM_SCRATCH

    def demonstrations(self, run: Run) -> float:
        """What counts as the demonstrations that a run took."""
        if self._is_cut(run):
            return self._given(run)
        return run.effort.demonstrations if self.budget is not None else run.charged()

    def keyframes(self, run: Run) -> float:
        """Keyframes over the tries at these demonstrations."""
        if self._is_cut(run):
            return sum(one.effort.keyframes for one in run.corrections[: self._given(run)])
        return run.effort.keyframes

    def success(self, run: Run) -> float | None:
        """The success rate on the changed task."""
        if self.is_fresh or run.method == FROM_SCRATCH or not run.corrections:
            return rate(run.after)
        return rate(_last(run, self._given(run)))


def _last(run: Run, given: int) -> Rate:
    return run.corrections[given - 1].decided_by


def _ratio(of: Callable[[Run], float]) -> Terms:
    return lambda pair: (of(pair[0]), of(pair[1]))


def _apart(own: Callable[[Run], float | None], other: Callable[[Run], float | None]) -> Terms:
    def terms(pair: Pair) -> tuple[float, float] | None:
        one, two = own(pair[0]), other(pair[1])
        return None if one is None or two is None else (one - two, 1.0)

    return terms


def value(pairs: Sequence[Pair], terms: Terms) -> str:
    """The ratio of the sums, with its interval by units."""
    return ratio([(pair[0], found) for pair in pairs if (found := terms(pair)) is not None])


def first_question(ledger: Ledger, reading: Reading) -> list[str]:
    """Corrected against taught from scratch: demonstrations of all and but for self-loops, keyframes, and success."""
    runs = [run for run in ledger.counted() if run.edit != "none"]
    pairs = beside([run for run in runs if run.method == SITU], partners(runs, FROM_SCRATCH))
    more = [pair for pair in pairs if not pair[0].self_loop]
    return [
        str(len(pairs)),
        value(pairs, _ratio(reading.demonstrations)),
        value(more, _ratio(reading.demonstrations)),
        value(pairs, _ratio(reading.keyframes)),
        value(pairs, _apart(reading.success, reading.success)),
    ]


def second_question(ledger: Ledger) -> list[str]:
    """Separate less joint, then SITU less the full retraining with its rule, in success on the changed task."""
    runs = [run for run in ledger.counted() if run.edit != "none"]
    own = [run for run in runs if run.method == SITU]
    joint = [(run, run) for run in own if run.joint is not None]
    fair = beside(own, partners(runs, "rebuild"))
    return [
        value(joint, _apart(lambda run: rate(run.after), lambda run: rate(run.joint.changed if run.joint else None))),
        value(fair, _apart(lambda run: rate(run.after), lambda run: rate(run.after))),
    ]


def table(announced: Ledger, silent: Ledger) -> list[str]:
    """The lines of both tables, in Markdown."""
    steps = [
        ("former", silent, Reading(FORMER_BUDGET, is_fresh=False)),
        ("+ naming an object again is a boundary", announced, Reading(FORMER_BUDGET, is_fresh=False)),
        ("+ one budget, charged where the target was not reached", announced, Reading(None, is_fresh=False)),
        ("+ fresh starts", announced, Reading(None, is_fresh=True)),
    ]
    heads = ["step", "runs", "demonstrations", "but self-loops", "keyframes", "success"]
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * (len(heads) - 1)]
    lines += ["| " + " | ".join([name, *first_question(of, reading)]) + " |" for name, of, reading in steps]
    lines += ["", "| | separate less joint | SITU less `rebuild` |", "| --- | ---: | ---: |"]
    for name, of in (("former cuts", silent), ("naming an object again is a boundary", announced)):
        lines.append("| " + " | ".join([name, *second_question(of)]) + " |")
    return lines


COMMAND = "situ-bench run --protocol families --teacher silent --method situ --method rebuild --method from_scratch"
HEADING = f"""\
Made by `python3 bench/recheck/steps.py results/families SILENT`, where SILENT is what `{COMMAND} --out SILENT` makes; \
do not edit.
"""
NOTE = """
What each step from the former protocol to this one changes in the answers to the paper's two questions, each keeping
those above it. The expert errs in nothing; in the first row it never names an object anew, which is how the former
protocol cut. *Former*: five corrections at the most, of a run that did not reach the target what it spent, and success
in the rollouts that ended the corrections. Teaching from scratch had eight demonstrations and keeps fresh success in
all rows, for a ledger keeps no other. Ratios are of corrections to teaching from scratch, sums over sums; success is a
difference. Intervals by units (family × seed), 95 %."""


def _of(folder: str, teacher: str) -> Ledger:
    """The runs of a teacher in a folder."""
    return Ledger([run for run in read(Path(folder) / "ledger.jsonl").runs if run.teacher == teacher], [])


def main(arguments: list[str]) -> int:
    """Prints the tables of two folders and gives the exit status."""
    if len(arguments) != 2:
        print("usage: python3 steps.py ANNOUNCED SILENT", file=sys.stderr)
        return 2
    try:
        announced, silent = (_of(folder, teacher) for folder, teacher in zip(arguments, TEACHERS))
    except (OSError, LedgerError) as error:
        print(error, file=sys.stderr)
        return 2
    print("\n".join([HEADING, *table(announced, silent), NOTE]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
