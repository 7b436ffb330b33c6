"""The published ledgers can be read."""

import pathlib

from situ_bench import read_ledger, rows

QUICK = pathlib.Path(__file__).parents[3] / "results/quick"


def test_the_published_records_are_read() -> None:
    records = read_ledger(QUICK)
    assert records == read_ledger(QUICK / "ledger.jsonl") and len(records) > 10
    flat = list(rows(records))
    runs = [row for row in flat if row["kind"] == "run"]
    assert {"situ", "rebuild"} <= {row["key.method"] for row in runs}
    assert not any(isinstance(value, dict) for row in flat for value in row.values())
