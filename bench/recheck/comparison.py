"""A published table against what it ought to be: cell by cell in CSV, and Markdown against CSV."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from typing import Any

from cells import ENDINGS, Between, Cell, Column, Exact, Field, Percentile, Table, Word
from published import Csv, Markdown
from resampling import HALF, near

# Below this a corrected p-value shows a difference.
LEVEL = 0.05
_NUMBER = re.compile(r"-?\d+\.\d{6}")
# The columns of which the sentences above a table speak, in their order.
SPOKEN = {
    "correct_or_scratch": ("demonstrations", "keyframes", "success"),
    "separate_or_joint": ("success", "original"),
}

# The groups of which a sentence is said, by their name in it.
SPOKEN_GROUPS = {
    "every edit": "all",
    "all but self-loops": "all but self-loops",
    "node-modification: shown": "node-modification: shown",
    "node-modification: not shown": "node-modification: not shown",
}
BEGINNING = re.compile(
    rf"`situ`, (.*?), ({'|'.join(map(re.escape, SPOKEN_GROUPS))}) \((\d+) runs, (\d+) units, (\d+) variations\)"
)


@dataclass(frozen=True)
class Disagreement:
    """A value that is not what it ought to be."""

    table: str
    row: str
    column: str
    expected: str
    found: str

    def __str__(self) -> str:
        return f"{self.table}: row {self.row}: column {self.column}: expected {self.expected}, found {self.found}"


@dataclass
class Findings:
    """What the comparison of a table came to, and how likely the least likely of the drawn values is."""

    exact: int = 0
    drawn: int = 0
    markdown: int = 0
    least_likely: tuple[float, str] = (1.0, "")
    disagreements: list[Disagreement] = field(default_factory=list)


class _Comparison:
    def __init__(self, table: Table) -> None:
        self.table, self.findings = table, Findings()
        self.heads = [name for column in table.columns for name in column.fields()]
        self.fields = [[one for column, cell in zip(table.columns, cells) for one in _fields(column, cell)]
                       for cells in table.rows]
        # A part of a column that says nothing in any row is not written.
        self.kept = [any(row[index] != Word("") for row in self.fields) for index in range(len(self.heads))]

    def whole(self, csv: Csv) -> Csv | None:
        """CSV with the parts that are not written, which are empty; `None` where the heads are others than expected."""
        written = [name for name, is_kept in zip(self.heads, self.kept) if is_kept]
        if csv.heads != written:
            unknown = [name for name in csv.heads if name not in written]
            missing = [name for name in written if name not in csv.heads]
            order = "" if unknown or missing else "the same in another order"
            self.differs("heads", "all", f"{missing or written}", f"{unknown or order or 'none of these'}")
            return None
        rows = []
        for row in csv.rows:
            rest = iter(row)
            rows.append([next(rest) if is_kept else "" for is_kept in self.kept])
        return Csv(self.heads, rows)

    def differs(self, row: str, column: str, expected: str, found: str) -> None:
        self.findings.disagreements.append(Disagreement(self.table.name, row, column, expected, found))

    def field(self, place: tuple[str, str], expected: Field, found: str) -> None:
        """One field of CSV."""
        findings = self.findings
        if isinstance(expected, Word):
            findings.exact += expected.text != ""
            if found != expected.text:
                self.differs(*place, f"`{expected.text}`", f"`{found}`")
            return
        is_exact = isinstance(expected, Exact)
        findings.exact += is_exact
        findings.drawn += not is_exact
        # A number that is 0 to six decimals has no sign.
        if not _NUMBER.fullmatch(found) or found == "-0.000000":
            self.differs(*place, "a number with six decimals", f"`{found}`")
            return
        value = float(found)
        if isinstance(expected, Exact):
            if not near(value, expected.value):
                self.differs(*place, f"{expected.value:.9f}", found)
        elif isinstance(expected, Between):
            if not expected.low - HALF <= value <= expected.high + HALF:
                self.differs(*place, f"from {expected.low:.6f} to {expected.high:.6f}", found)
        else:
            self.percentile(place, expected, found)

    def percentile(self, place: tuple[str, str], expected: Percentile, found: str) -> None:
        verdict = expected.distribution.judge(float(found), expected.upper)
        if verdict.is_accepted:
            self.findings.least_likely = min(self.findings.least_likely, (verdict.probability, ", ".join(place)))
        else:
            self.differs(*place, verdict.accepted, found)

    def csv(self, csv: Csv) -> None:
        """The whole of CSV."""
        table = self.table
        expected = {self.key(cells): fields for cells, fields in zip(table.rows, self.fields)}
        found = {tuple(row[: len(table.keys)]): row for row in csv.rows}
        if len(found) != len(csv.rows):
            self.differs("all", "keys", "no two rows of one name", "two")
        for key in expected.keys() - found.keys():
            self.differs(", ".join(key), "all", "this row", "none")
        for key, row in found.items():
            if key not in expected:
                self.differs(", ".join(key), "all", "no such row", "one")
                continue
            for name, one, text in zip(self.heads, expected[key], row, strict=True):
                self.field((", ".join(key), name), one, text)

    def key(self, cells: Sequence[Cell]) -> tuple[str, ...]:
        words = (cell[0] if cell else Word("") for cell in cells[: len(self.table.keys)])
        return tuple(word.text if isinstance(word, Word) else "" for word in words)

    def markdown(self, csv: Csv, markdown: Markdown) -> None:
        """Markdown, which says the same with fewer decimals."""
        table = self.table
        if markdown.records != table.records:
            self.differs("origin", "Records", str(table.records), str(markdown.records))
        protocols = sorted({row[0] for row in csv.rows})
        if csv.heads[0] == "protocol" and markdown.protocols != protocols:
            self.differs("origin", "Protocol", str(protocols), str(markdown.protocols))
        heads = [column.head() for column in table.columns]
        if markdown.heads != heads or len(markdown.rows) != len(csv.rows):
            self.differs("Markdown", "heads and rows", f"{len(csv.rows)} rows of {heads}",
                         f"{len(markdown.rows)} rows of {markdown.heads}")
            return
        # As many in every cell of a column.
        decimals = [max(map(_decimals, cells)) for cells in zip(*markdown.rows)]
        for fields, cells in zip(csv.rows, markdown.rows):
            row, rest = ", ".join(fields[: len(table.keys)]), list(fields)
            for column, cell, digits in zip(table.columns, cells, decimals):
                own = [rest.pop(0) for _ in ENDINGS[column.shape]]
                self.findings.markdown += 1
                if not _says_the_same(column.shape, own, cell, digits):
                    self.differs(row, f"{column.head()} in Markdown", str(own), cell)
        self.sentences(markdown)

    def verdicts(self, markdown: Markdown) -> None:
        """The sentences above the paired table: one for each test, where SITU is worse first."""
        expected: list[tuple[int, str]] = []
        for row in markdown.rows:
            cells = dict(zip(markdown.heads, row))
            for name in ("success", "demonstrations", "original"):
                p = cells.get(f"Holm {name}", "–")
                if p == "–":
                    continue
                is_more = (float(cells[name].split()[0]) > 0) != (name == "demonstrations")
                rank = 1 if float(p) >= LEVEL else 2 if is_more else 0
                words = ("worse", "no difference is shown", "better")[rank]
                beginning = f"`situ` against `{cells['other']}`, {cells['teacher']}, {name}"
                expected.append((rank, f"{beginning}: {words}: {cells[name]}, Holm {p}."))
        said = [sentence for _, sentence in sorted(expected, key=lambda one: one[0])]
        self.findings.markdown += len(said)
        if markdown.sentences != said:
            self.differs("sentences", "all", str(said), str(markdown.sentences))

    def sentences(self, markdown: Markdown) -> None:
        """The sentences above a table say what its rows say."""
        if self.table.name == "paired":
            self.verdicts(markdown)
            return
        spoken = SPOKEN.get(self.table.name)
        rows = {tuple(row[:4]): dict(zip(markdown.heads, row)) for row in markdown.rows}
        wanted = {
            (teacher, group) for (_, teacher, method, group) in rows
            if spoken and method == "situ" and group in SPOKEN_GROUPS.values()
        }
        said = set()
        for sentence in markdown.sentences:
            beginning = BEGINNING.match(sentence)
            if not spoken or not beginning:
                self.differs("sentence", "all", "none like it", sentence)
                continue
            teacher, group = beginning[1], SPOKEN_GROUPS[beginning[2]]
            said.add((teacher, group))
            row = next((row for key, row in rows.items() if key[1:] == (teacher, "situ", group)), {})
            numbers = re.findall(r"[≥≤~]?-?\d+\.\d+(?: \[[^]]*\])*", sentence)
            expected = [row.get(name, "") for name in ("runs", "units", "variations", *spoken)]
            self.findings.markdown += len(expected)
            if [*beginning.groups()[2:], *numbers] != expected:
                self.differs(f"sentence of {teacher}, {group}", "all", str(expected), sentence)
        for teacher, group in wanted - said:
            self.differs(f"sentence of {teacher}, {group}", "all", "a sentence", "none")


def _fields(column: Column[Any], cell: Cell) -> Sequence[Field]:
    """The fields of a cell in CSV."""
    return cell if cell is not None else [Word("")] * len(ENDINGS[column.shape])


def _decimals(cell: str) -> int:
    found = re.search(r"\.(\d+)", cell)
    return len(found[1]) if found else 0


def _says_the_same(shape: str, fields: list[str], cell: str, decimals: int) -> bool:
    """Whether a cell of Markdown says what the fields of CSV say, each number with so many decimals."""
    if not any(fields):
        return cell == "–"
    if shape in ("text", "count"):
        return cell == fields[0]
    if shape == "rate":
        beginning, fields = f"{fields[0]}/{fields[1]}", fields[2:]
    else:
        beginning = fields.pop() if shape != "number" else ""
    if not cell.startswith(beginning):
        return False
    rest = cell[len(beginning):]
    expected = [one for one in fields if one]
    number = r"(-?\d+(?:\.\d+)?)"
    pattern = "" if shape == "rate" else number
    pattern += rf" \[{number}, {number}\]" * (len(expected) // 2)
    found = re.fullmatch(pattern, rest)
    return found is not None and all(
        _rounds_to(text, value, decimals) for text, value in zip(found.groups(), expected, strict=True)
    )


def _rounds_to(text: str, value: str, decimals: int) -> bool:
    if _decimals(text) != decimals:
        return False
    try:
        apart = abs(Decimal(text) - Decimal(value))
    except InvalidOperation:
        return False
    return apart <= Decimal(5).scaleb(-decimals - 1) + Decimal("0.0000005") and not re.fullmatch(r"-[0.]+", text)


def compare(table: Table, csv: Csv, markdown: Markdown | None) -> Findings:
    """What a table in CSV and in Markdown is against what it ought to be."""
    comparison = _Comparison(table)
    whole = comparison.whole(csv)
    if whole is None:
        return comparison.findings
    comparison.csv(whole)
    if markdown is None:
        comparison.differs("all", "all", "a table in Markdown", "none")
    else:
        comparison.markdown(whole, markdown)
    return comparison.findings
