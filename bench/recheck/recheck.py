"""Checks the tables of a ledger by a second computation, which shares no code with the one that made them.

Command:  python3 bench/recheck/recheck.py FOLDER
Needs Python 3.10 and nothing else. The folder holds `ledger.jsonl` and its tables in CSV and Markdown. Every value of
every table is computed from the ledger, by the definitions in the tables' notes. What is not drawn at random must agree
to the six decimals that are printed; what is drawn must lie where other draws leave it with a probability of 1e-6 at
the most. Says how many values were checked, and each that disagrees; the exit status is then 1, and 2 where the folder
cannot be read.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import cost_tables
import effort_tables
import ledger
import model_tables
import paired_tables
import published
from cells import Table
from comparison import Disagreement, Findings, compare

# The tables of each Markdown file, in their order.
PUBLICATIONS: dict[str, list[Callable[[ledger.Ledger], Table]]] = {
    "headline": [effort_tables.headline],
    "questions": [paired_tables.correct_or_scratch, paired_tables.separate_or_joint],
    "paired": [paired_tables.paired],
    "t1": [effort_tables.t1],
    "t2": [model_tables.t2],
    "t3": [model_tables.t3],
    "t4": [
        model_tables.t4_physics, cost_tables.scaling, cost_tables.slopes, cost_tables.crossover, cost_tables.latency,
    ],
    "t5": [model_tables.t5, model_tables.t5_sequences],
    "t6": [effort_tables.t6],
    "t7": [model_tables.t7],
    "methods": [effort_tables.methods],
    "endings": [effort_tables.came_to_nothing],
}

# Values that agree or not: exact ones, drawn ones, cells of Markdown, and disagreements.
Counts = tuple[int, int, int, int]


def expected(records: ledger.Ledger) -> dict[str, list[Table]]:
    """The tables of each Markdown file, but for those that have no row."""
    return {
        name: [made for make in makers if (made := make(records)).rows] for name, makers in PUBLICATIONS.items()
    }


def _missing(table: str, what: str, is_wanted: bool) -> Findings:
    words = ("rows for one", "none") if is_wanted else ("no row for one", "one")
    return Findings(disagreements=[Disagreement(table, "all", what, *words)])


def check(folder: Path) -> dict[str, Findings]:
    """What was found of each table in the folder, and of each that ought to be there."""
    return check_against(expected(ledger.read(folder / "ledger.jsonl")), folder)


def check_against(tables_of: dict[str, list[Table]], folder: Path) -> dict[str, Findings]:
    """The same against tables that are known."""
    findings: dict[str, Findings] = {}
    for name, tables in tables_of.items():
        path = folder / f"{name}.md"
        markdown = published.read_markdown(path) if path.exists() else []
        headings = [table.heading for table in tables]
        if headings != [table.heading for table in markdown]:
            findings[path.name] = _missing(path.name, f"headings {headings}", is_wanted=bool(headings))
        by_heading = {table.heading: table for table in markdown}
        for table in tables:
            path = folder / f"{table.name}.csv"
            if path.exists():
                findings[table.name] = compare(table, published.read_csv(path), by_heading.get(table.heading))
            else:
                findings[table.name] = _missing(path.name, "the file", is_wanted=True)
    known = {f"{name}.csv" for name in findings} | {f"{name}.md" for name in PUBLICATIONS}
    for path in sorted([*folder.glob("*.csv"), *folder.glob("*.md")]):
        if path.name not in known:
            findings[path.name] = _missing(path.name, "the file", is_wanted=False)
    return findings


def _counts(found: Findings) -> Counts:
    return found.exact, found.drawn, found.markdown, len(found.disagreements)


def report(findings: dict[str, Findings]) -> list[str]:
    """The lines that are printed."""
    lines = [str(one) for found in findings.values() for one in found.disagreements]
    counts = {name: _counts(found) for name, found in findings.items()}
    exact, drawn, markdown, wrong = (sum(of) for of in zip(*counts.values()))
    counts["all"] = exact, drawn, markdown, wrong
    width = max(map(len, counts))
    lines.append(f"{'table':{width}} {'exact':>7} {'drawn':>7} {'Markdown':>9} {'disagree':>9}")
    lines += [f"{name:{width}} {of[0]:7} {of[1]:7} {of[2]:9} {of[3]:9}" for name, of in counts.items()]
    likely, name = min((found.least_likely[0], name) for name, found in findings.items())
    if drawn:
        where = f"{name}: {findings[name].least_likely[1]}"
        lines.append(f"the least likely of the drawn values has a probability of {likely:.1e}: {where}")
    if wrong:
        lines.append(f"{wrong} of {exact + drawn} values and {markdown} cells of Markdown disagree")
    else:
        agree = f"{exact} values agree exactly, {drawn} within the error of drawing"
        lines.append(f"{agree}; {markdown} cells of Markdown say the same")
    return lines


def main(arguments: list[str]) -> int:
    """Runs the check of one folder and gives the exit status."""
    if len(arguments) != 1:
        print("usage: python3 recheck.py FOLDER", file=sys.stderr)
        return 2
    try:
        findings = check(Path(arguments[0]))
    except (OSError, ledger.LedgerError, published.PublishedError) as error:
        print(error, file=sys.stderr)
        return 2
    print("\n".join(report(findings)))
    return int(any(found.disagreements for found in findings.values()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
