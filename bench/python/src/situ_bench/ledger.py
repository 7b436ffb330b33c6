"""Ledgers: the records of runs, one JSON object a line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterator

if TYPE_CHECKING:
    import pandas


def read_ledger(path: str | Path) -> list[dict[str, Any]]:
    """The records of a ledger, in order. The path may be that of its folder."""
    path = Path(path)
    path = path / "ledger.jsonl" if path.is_dir() else path
    with path.open(encoding="utf-8") as lines:
        return [json.loads(line) for line in lines if line.strip()]


def rows(records: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """The records with their nested keys joined by dots; lists stay what they are."""

    def flat(value: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
        for key, inner in value.items():
            if isinstance(inner, dict):
                yield from flat(inner, f"{prefix}{key}.")
            else:
                yield f"{prefix}{key}", inner

    for record in records:
        yield dict(flat(record, ""))


def to_pandas(path: str | Path) -> "pandas.DataFrame":
    """The records as a table, a row each. Needs pandas."""
    import pandas

    return pandas.DataFrame(list(rows(read_ledger(path))))
