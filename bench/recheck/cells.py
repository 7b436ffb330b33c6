"""What a table ought to hold: columns, and for each row a cell under each, of one field or several."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import resampling
import summaries
from ledger import Rate

R = TypeVar("R")


@dataclass(frozen=True)
class Word:
    """A field that holds these words, or none."""

    text: str


@dataclass(frozen=True)
class Exact:
    """A field that holds this number to six decimals."""

    value: float


@dataclass(frozen=True)
class Percentile:
    """A field that holds the lower or the upper end of a bootstrap interval."""

    distribution: resampling.Distribution[Any]
    upper: bool


@dataclass(frozen=True)
class Between:
    """A field that holds a number which depends on what was drawn, between these."""

    low: float
    high: float


Field = Word | Exact | Percentile | Between
# The fields of a cell; `None` where there is nothing.
Cell = Sequence[Field] | None

# What follows the name of a column in CSV, by the shape of the column.
ENDINGS = {
    "text": ("",),
    "count": ("",),
    "number": ("",),
    "rate": ("_successes", "_n", "_low", "_high"),
    "estimate": ("", "_low", "_high", "_bound"),
    "pooled": ("", "_low", "_high", "_variations_low", "_variations_high", "_bound"),
}


@dataclass(frozen=True)
class Column(Generic[R]):
    """A column of a table over rows of `R`. The name is that in Markdown, with `_` for a space."""

    name: str
    shape: str
    cell: Callable[[R], Cell]
    wall: bool = False

    def fields(self) -> list[str]:
        """The names of its fields in CSV: without signs."""
        name = self.name.replace("|Z|", "applicable").replace("|T|", "model_size").replace("/", "_over_")
        clock = "_wall" if self.wall else ""
        return [name.replace(" ", "_").replace("-", "_") + ending + clock for ending in ENDINGS[self.shape]]

    def head(self) -> str:
        """Its head in Markdown."""
        return self.name.replace("_", " ") + (" (wall)" if self.wall else "")


@dataclass(frozen=True)
class Table:
    """A table as it ought to be: the columns that say something, and the cells of each row.

    `keys` are the columns at the beginning that name a row; `records` is the number of records that it is made of.
    """

    name: str
    heading: str
    columns: list[Column[Any]]
    rows: list[list[Cell]]
    keys: tuple[str, ...]
    records: int


def says_something(cell: Cell) -> bool:
    """Whether a cell holds anything but the count 0."""
    return cell is not None and list(cell) != [Word("0")]


def table(
    name: str,
    heading: str,
    keys: Sequence[Column[R]],
    columns: Sequence[Column[R]],
    rows: Sequence[R],
    records: int,
) -> Table:
    """The table of these rows. A column that says nothing in any of them is not written."""
    every = [*keys, *columns]
    cells = [[column.cell(row) for column in every] for row in rows]
    kept = [index for index in range(len(every)) if any(says_something(row[index]) for row in cells)]
    names = tuple(column.name for column in keys if any(column is every[index] for index in kept))
    columns_kept, cells_kept = [every[index] for index in kept], [[row[index] for index in kept] for row in cells]
    return Table(name, heading, columns_kept, cells_kept, names, records)


def text(name: str, of: Callable[[R], str | None]) -> Column[R]:
    """A column of words."""

    def cell(row: R) -> Cell:
        words = of(row)
        return None if words is None else [Word(words)]

    return Column(name, "text", cell)


def count(name: str, of: Callable[[R], int]) -> Column[R]:
    """A column of whole numbers."""
    return Column(name, "count", lambda row: [Word(str(of(row)))])


def number(name: str, of: Callable[[R], float | None], wall: bool = False) -> Column[R]:
    """A column of numbers without an interval."""

    def cell(row: R) -> Cell:
        value = of(row)
        return None if value is None else [Exact(value)]

    return Column(name, "number", cell, wall)


def share(name: str, of: Callable[[R], Rate | None]) -> Column[R]:
    """A column of k of n with the Wilson interval."""

    def cell(row: R) -> Cell:
        rate = of(row)
        if rate is None or not rate.rollouts:
            return None
        low, high = summaries.wilson(rate.successes, rate.rollouts)
        return [Word(str(rate.successes)), Word(str(rate.rollouts)), Exact(low), Exact(high)]

    return Column(name, "rate", cell)


def estimate(name: str, of: Callable[[R], Cell], wall: bool = False) -> Column[R]:
    """A column of numbers with one interval."""
    return Column(name, "estimate", of, wall)


def pooled(name: str, of: Callable[[R], Cell], wall: bool = False) -> Column[R]:
    """A column of numbers with two intervals."""
    return Column(name, "pooled", of, wall)


def mark(above_is_exact: bool, below_is_exact: bool = True) -> str:
    """The mark of a quotient, each part of which is known exactly or is a lower bound."""
    if above_is_exact:
        return "" if below_is_exact else "≤"
    return "≥" if below_is_exact else "~"
