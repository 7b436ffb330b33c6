"""The published tables: CSV and Markdown as they are on disk."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

_ORIGIN = re.compile(r"Protocol: (?P<protocols>.*?)\. (?:.* )?Records: (?P<records>\d+)\. Made by `.*`; do not edit\.")
_SEPARATOR = re.compile(r"(?<!\\)\|")


class PublishedError(Exception):
    """A file that is no table."""


@dataclass(frozen=True)
class Csv:
    """A table in CSV."""

    heads: list[str]
    rows: list[list[str]]


@dataclass(frozen=True)
class Markdown:
    """A table in Markdown: its heading, its protocols, the records that it says it is of, sentences, heads and rows."""

    heading: str
    protocols: list[str]
    records: int
    sentences: list[str]
    heads: list[str]
    rows: list[list[str]]


def read_csv(path: Path) -> Csv:
    """The table in a CSV file, each row as long as the heads."""
    with path.open(encoding="utf-8", newline="") as file:
        lines = list(csv.reader(file, strict=True))
    if not lines:
        raise PublishedError(f"{path.name}: empty")
    for number, line in enumerate(lines, 1):
        if len(line) != len(lines[0]):
            raise PublishedError(f"{path.name}:{number}: {len(line)} fields where {len(lines[0])} are expected")
    return Csv(lines[0], lines[1:])


def _cells(line: str) -> list[str]:
    """The cells of a row."""
    return [cell.strip().replace("\\|", "|") for cell in _SEPARATOR.split(line)[1:-1]]


def read_markdown(path: Path) -> list[Markdown]:
    """The tables in a Markdown file."""
    tables = []
    for section in re.split(r"^## ", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        lines = section.splitlines()
        origins = [origin for line in lines if (origin := _ORIGIN.match(line))]
        rows = [_cells(line) for line in lines if line.startswith("|")]
        if len(origins) != 1 or len(rows) < 2:
            raise PublishedError(f"{path.name}: no line of origin or no table under `{lines[0]}`")
        for row in rows:
            if len(row) != len(rows[0]):
                raise PublishedError(f"{path.name}: a row of {len(row)} cells where {len(rows[0])} are expected: {row}")
        sentences = [line[2:] for line in lines if line.startswith("- ")]
        protocols = re.findall(r"`(.*?)`", origins[0]["protocols"])
        tables.append(Markdown(lines[0], protocols, int(origins[0]["records"]), sentences, rows[0], rows[2:]))
    return tables
