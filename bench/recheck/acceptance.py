"""Whether a change of the update is accepted: what the issue of the update asks for, beside the former revision.

Command:  python3 bench/recheck/acceptance.py SHOWN NOW FORMER [OTHER…]
Needs Python 3.10 and nothing else. SHOWN is results/tasks/shown.csv, the list of the variations that show their change.
The others are folders with a ledger of one protocol: NOW of this revision's `situ`, FORMER of `situ` before it, and any
number with other methods of this revision. Every value is over the runs of both teachers unless it says one, with a
95 % interval by units (family and seed) within families.
"""

import csv
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from ledger import Ledger, LedgerError, Rate, Run, read
from measures import EDITS, SITU, beside, grouped, partners, rate
from ratios import Terms, interval, quotient, ratio
from summaries import wilson

ORACLE = "oracle_edit"
TEACHERS = ("expert", "novice")
GOOD = 0.9

# What a run adds to a value.
Of = Callable[[Run], Terms | None]


def shown_cells(path: Path) -> set[tuple[str, str]]:
    """The variations of which every change is shown by what is observed."""
    with path.open(encoding="utf-8", newline="") as file:
        cells = grouped(((row["task"], row["variation"]), row["shown"] == "true") for row in csv.DictReader(file))
    return {cell for cell, shown in cells.items() if all(shown)}


def first_edit(run: Run) -> Terms | None:
    """Whether the first correction that shows the change leads to the edit that is needed, and to no other."""
    first = next((one for one in run.corrections if one.shows_change), None)
    return None if first is None else (float(first.edits == {run.edit}), 1.0)


def needed_among_first(run: Run) -> Terms | None:
    """The same, where other edits beside it are forgiven."""
    first = next((one for one in run.corrections if one.shows_change), None)
    return None if first is None else (float(run.edit in first.edits), 1.0)


def reached(run: Run) -> Terms:
    """Whether the target was reached."""
    return float(run.is_reached()), 1.0


def demonstrations(run: Run) -> Terms:
    """Demonstrations, the budget where the target was not reached."""
    return float(run.charged()), 1.0


def _successes(of: Rate | None) -> Terms | None:
    return None if of is None else (float(of.successes), float(of.rollouts))


def changed(run: Run) -> Terms | None:
    """Success on the changed task."""
    return _successes(run.after)


def kept(run: Run) -> Terms | None:
    """Success on the original task after, over success before."""
    after, before = run.original_after, run.original_before
    return None if after is None or before is None else (float(after.successes), float(before.successes))


def both(run: Run) -> Terms | None:
    """Whether the old and the new task both succeed in nine of ten."""
    new, old = rate(run.after), rate(run.original_after)
    return None if new is None or old is None else (float(min(new, old) >= GOOD), 1.0)


def retrieved(run: Run) -> Terms | None:
    """Segments that some primitive has, and those of them in which A1.6 alone finds it."""
    steps = [step for one in run.corrections for step in one.steps if step.retrieved is not None]
    return (float(sum(bool(step.retrieved) for step in steps)), float(len(steps))) if steps else None


def index_size(run: Run) -> Terms | None:
    """|Z| over |T|, summed over the segments."""
    steps = [step for one in run.corrections for step in one.steps]
    applicable, known = sum(step.applicable for step in steps), sum(step.model_size for step in steps)
    return (float(applicable), float(known)) if steps else None


def cell(runs: Iterable[Run], of: Of) -> str:
    """The ratio of what runs add, with its interval."""
    return ratio([(run, terms) for run in runs if (terms := of(run)) is not None])


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _head(cells: Sequence[str]) -> list[str]:
    return ["", _line(cells), "| --- |" + " ---: |" * (len(cells) - 1)]


def lines_of(ledgers: dict[str, list[Run]], shown: set[tuple[str, str]]) -> list[str]:
    """A line for each thing that is asked for, a column for each ledger."""
    def is_edit(*edits: str) -> Callable[[Run], bool]:
        return lambda run: run.edit in edits

    def modification(is_shown: bool) -> Callable[[Run], bool]:
        return lambda run: run.edit == "node-modification" and ((run.task, run.variation) in shown) == is_shown

    additions = is_edit("node-addition", "edge-addition")
    changes = is_edit(*EDITS[:3])
    asked: list[tuple[str, Of, Callable[[Run], bool]]] = [
        *((f"first edit right: {edit}", first_edit, is_edit(edit)) for edit in EDITS[:3]),
        ("the needed edit among the first: node-modification", needed_among_first, is_edit("node-modification")),
        ("reached", reached, changes),
        *((f"reached: {edit}", reached, is_edit(edit)) for edit in EDITS[:3]),
        *((f"demonstrations: {edit}", demonstrations, is_edit(edit)) for edit in EDITS),
        *((f"success on the changed task: {edit}", changed, is_edit(edit)) for edit in EDITS),
        ("original kept: modifications that are shown", kept, modification(is_shown=True)),
        ("original kept: the other modifications", kept, modification(is_shown=False)),
        ("original kept: additions", kept, additions),
        ("both tasks ≥ 9/10: modifications that are shown", both, modification(is_shown=True)),
        ("both tasks ≥ 9/10: the other modifications", both, modification(is_shown=False)),
        ("both tasks ≥ 9/10: additions", both, additions),
        ("both tasks ≥ 9/10: all changes", both, changes),
        ("A1.6 alone finds the primitive", retrieved, lambda run: True),
        ("mean |Z| / mean |T|", index_size, lambda run: True),
    ]
    lines = _head(["", *ledgers])
    for name, of, counts in asked:
        lines.append(_line([name, *(cell(filter(counts, runs), of) for runs in ledgers.values())]))
    return lines


def beside_oracle(now: list[Run], oracle: list[Run], shown: set[tuple[str, str]]) -> list[str]:
    """Demonstrations of a modification less those of the method that is told the edit, paired."""
    pairs = beside([run for run in now if run.edit == "node-modification"], partners(oracle, ORACLE))
    lines = _head(["demonstrations of a modification, `situ` less `oracle_edit`", "pairs", "difference"])
    for name, is_shown in (("shown", True), ("not shown", False)):
        own = [pair for pair in pairs if ((pair[0].task, pair[0].variation) in shown) == is_shown]
        known = [(one, (float(one.charged() - other.charged()), 1.0)) for one, other in own]
        lines.append(_line([name, str(len(own)), ratio(known)]))
    return lines


def beside_others(now: list[Run], others: dict[str, list[Run]], shown: set[tuple[str, str]]) -> list[str]:
    """Two lines for each other ledger: its own, and that of `situ` now on the same runs."""
    def is_shown(run: Run) -> bool:
        return (run.task, run.variation) in shown

    modified, added = "node-modification", ("node-addition", "edge-addition")
    asked: list[tuple[str, Of, Callable[[Run], bool]]] = [
        ("first edit right: additions", first_edit, lambda run: run.edit in added),
        ("modifications", first_edit, lambda run: run.edit == modified),
        ("reached", reached, lambda run: run.edit in EDITS[:3]),
        ("demonstrations", demonstrations, lambda run: run.edit in EDITS[:3]),
        ("changed", changed, lambda run: run.edit in EDITS[:3]),
        ("kept: shown modifications", kept, lambda run: run.edit == modified and is_shown(run)),
        ("other modifications", kept, lambda run: run.edit == modified and not is_shown(run)),
        ("additions", kept, lambda run: run.edit in added),
        ("both ≥ 9/10: shown modifications", both, lambda run: run.edit == modified and is_shown(run)),
        ("other modifications", both, lambda run: run.edit == modified and not is_shown(run)),
        ("all changes", both, lambda run: run.edit in EDITS[:3]),
    ]
    lines = _head(["", "runs", *(name for name, _, _ in asked)])
    for name, runs in others.items():
        places = {run.place() for run in runs}
        for title, side in ((name, runs), ("now", [run for run in now if run.place() in places])):
            cells = (cell(filter(counts, side), of) for _, of, counts in asked)
            lines.append(_line([title, str(len(side)), *cells]))
    return lines


# What a cell is compared in, and the sign of what is worse.
COMPARED: list[tuple[str, Of, float]] = [
    ("demonstrations", demonstrations, 1.0), ("changed", changed, -1.0), ("kept", kept, -1.0),
]


def cells_apart(now: list[Run], former: list[Run]) -> list[str]:
    """Every variation and teacher: reached, with Wilson's interval, demonstrations and success, now and before."""
    lines = _head(["cell", "reached", "before", "demonstrations", "before", "changed", "before", "kept", "before", ""])
    own, old = (grouped(((run.task, run.variation, run.teacher), run) for run in runs) for runs in (now, former))
    for name in sorted(own):
        if name not in old:
            continue
        sides = own[name], old[name]
        values = [
            [quotient([terms for run in side if (terms := of(run)) is not None]) for side in sides]
            for _, of, _ in COMPARED
        ]
        counts = [(sum(run.is_reached() for run in side), len(side)) for side in sides]
        worse = [what for what, of, sign in COMPARED if is_worse(sides[0], sides[1], of, sign)]
        low, high = wilson(*counts[0])
        numbers = [number for pair in values for number in pair]
        lines.append(_line([
            " ".join(name), f"{counts[0][0]}/{counts[0][1]} [{low:.2f}, {high:.2f}]", f"{counts[1][0]}/{counts[1][1]}",
            *("–" if number is None else f"{number:.2f}" for number in numbers),
            "worse: " + ", ".join(worse) if worse else "",
        ]))
    return lines


def is_worse(now: list[Run], former: list[Run], of: Of, sign: float) -> bool:
    """Whether the paired difference is worse beyond its interval."""
    old = {run.place(): run for run in former}
    known = []
    for run in now:
        pair = old.get(run.place())
        one, two = (None if side is None else of(side) for side in (run, pair))
        if one is not None and two is not None and one[1] and two[1]:
            known.append((run, (sign * (one[0] / one[1] - two[0] / two[1]), 1.0)))
    ends = interval(known) if len(known) > 1 else None
    return ends is not None and ends[0] > 0.0


HEADING = """\
Made by `python3 bench/recheck/acceptance.py {}`; do not edit.
"""
NOTE = """
*First edit right*: the first correction that shows the change leads to the needed edit and to no other. The former
ledger does not tell a way back, along which something is shown again, from another edge, and counts it as an edit of
its own; so the next line forgives what is made beside the needed edit. *Kept*: successes on the original task after
the last correction over those before the first, from the same fresh starts. A run that did not reach the target counts
its budget of demonstrations. *Worse* is a cell whose paired difference over seeds is worse and its interval is without
0. Intervals of 95 % by units (family × seed); of a cell, Wilson's. Below each other method, and below each other
setting of `situ` (the name of its folder: `next` is the executor that tries the next way and the next child), stands
`situ` now on the same runs."""


def _runs(folders: Sequence[str]) -> list[Run]:
    return [run for folder in folders for run in Ledger(read(Path(folder) / "ledger.jsonl").runs, []).counted()]


def main(arguments: list[str]) -> int:
    """Prints the tables and gives the exit status."""
    if len(arguments) < 3:
        print("usage: python3 acceptance.py SHOWN NOW FORMER [OTHER...]", file=sys.stderr)
        return 2
    try:
        shown = shown_cells(Path(arguments[0]))
        now, former = _runs(arguments[1:2]), _runs(arguments[2:3])
        # By method; `situ` itself, under another protocol, by the folder.
        others = grouped((Path(folder).name if run.method == SITU else run.method, run)
                         for folder in arguments[3:] for run in _runs([folder]))
    except (OSError, KeyError, LedgerError) as error:
        print(error, file=sys.stderr)
        return 2
    now = [run for run in now if run.method == SITU]
    print(HEADING.format(" ".join(arguments)))
    print(f"{len(now)} runs now and {len(former)} before that say something about the method.")
    ledgers = {"now": now, "before": former}
    for teacher in TEACHERS:
        ledgers |= {f"{teacher}, {name}": [run for run in runs if run.teacher == teacher]
                    for name, runs in (("now", now), ("before", former))}
    print("\n".join(lines_of(ledgers, shown)))
    if ORACLE in others:
        print("\n".join(beside_oracle(now, others[ORACLE], shown)))
    if others:
        print("\n".join(beside_others(now, others, shown)))
    print("\n".join(cells_apart(now, former)))
    print(NOTE)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
