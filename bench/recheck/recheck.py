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
import ledger
import published
import run_tables
from cells import Table
from comparison import Disagreement, Findings, compare

# The tables of each Markdown file, in their order.
PUBLICATIONS: dict[str, list[Callable[[ledger.Ledger], Table]]] = {
    "headline": [run_tables.headline],
    "questions": [run_tables.correct_or_scratch, run_tables.separate_or_joint],
    "paired": [run_tables.paired],
    "t1": [run_tables.t1],
    "t2": [run_tables.t2],
    "t3": [run_tables.t3],
    "t4": [run_tables.t4_physics, cost_tables.scaling, cost_tables.slopes, cost_tables.crossover, cost_tables.latency],
    "t5": [run_tables.t5, run_tables.t5_sequences],
    "t6": [run_tables.t6],
    "t7": [run_tables.t7],
    "methods": [run_tables.methods],
    "endings": [run_tables.endings],
}


def _missing(table: str, what: str, is_wanted: bool) -> Findings:
    words = ("rows for one", "none") if is_wanted else ("no row for one", "one")
    return Findings(disagreements=[Disagreement(table, "all", what, *words)])


def check(folder: Path) -> dict[str, Findings]:
    """What was found of each table in the folder, and of each that ought to be there."""
    records = ledger.read(folder / "ledger.jsonl")
    findings: dict[str, Findings] = {}
    for name, makers in PUBLICATIONS.items():
        tables = [made for make in makers if (made := make(records)).rows]
        path = folder / f"{name}.md"
        markdown = published.read_markdown(path) if path.exists() else []
        if path.exists() and not tables:
            findings[f"{name}.md"] = _missing(name, "the file in Markdown", is_wanted=False)
            continue
        if [table.heading for table in tables] != [table.heading for table in markdown]:
            findings[f"{name}.md"] = _missing(name, f"headings {[table.heading for table in tables]} in Markdown", True)
        by_heading = {table.heading: table for table in markdown}
        for table in tables:
            path = folder / f"{table.name}.csv"
            if path.exists():
                findings[table.name] = compare(table, published.read_csv(path), by_heading.get(table.heading))
            else:
                findings[table.name] = _missing(table.name, "the file in CSV", is_wanted=True)
    known = {f"{name}.csv" for name in findings} | {f"{name}.md" for name in PUBLICATIONS}
    for path in sorted([*folder.glob("*.csv"), *folder.glob("*.md")]):
        if path.name not in known:
            findings[path.name] = _missing(path.name, "the file", is_wanted=False)
    return findings


def report(findings: dict[str, Findings]) -> list[str]:
    """The lines that are printed."""
    lines = [str(one) for found in findings.values() for one in found.disagreements]
    counts = {
        name: (found.exact, found.drawn, found.markdown, len(found.disagreements)) for name, found in findings.items()
    }
    counts["all"] = tuple(map(sum, zip(*counts.values())))
    width = max(map(len, counts))
    lines.append(f"{'table':{width}} {'exact':>7} {'drawn':>7} {'Markdown':>9} {'disagree':>9}")
    lines += [
        f"{name:{width}} {exact:7} {drawn:7} {markdown:9} {wrong:9}"
        for name, (exact, drawn, markdown, wrong) in counts.items()
    ]
    away, table, where = max((*found.farthest, name)[::2] + (found.farthest[1],) for name, found in findings.items())
    exact, drawn, markdown, wrong = counts["all"]
    if where:
        lines.append(f"The farthest of the drawn values is {away:.1f} standard errors of its rank away: {table}: {where}")
    lines.append(
        f"{exact} values agree exactly and {drawn} within the error of drawing; {markdown} cells of Markdown say the same"
        if not wrong else f"{wrong} of {exact + drawn} values and {markdown} cells of Markdown disagree"
    )
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
