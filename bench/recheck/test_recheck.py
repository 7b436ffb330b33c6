"""Tests of the second computation: values that are known, what chance may do, and errors that are planted.

Command:  python3 bench/recheck/test_recheck.py
Plants its errors in copies of `results/quick`, or of the folder that `RECHECK_FOLDER` names, by a seed that it prints.
"""

import csv
import json
import math
import os
import random
import re
import shutil
import tempfile
import unittest
from pathlib import Path

import ledger
import published
import recheck
import resampling
import summaries
from cells import Exact, Table, Word
from measures import MEDIAN, RATIO
from resampling import Distribution

FOLDER = Path(os.environ.get("RECHECK_FOLDER", Path(__file__).parents[2] / "results" / "quick"))
SEED = 1
# Errors that are planted in each table in CSV, and in each in Markdown.
PLANTED = 4
# Records that each get a success more.
RECORDS = 3


class KnownValues(unittest.TestCase):
    """Values that others published, and values by hand."""

    def test_the_reference(self) -> None:
        low, high = summaries.wilson(20, 20)
        self.assertEqual((round(low, 3), high), (0.839, 1.0))
        x, y = [(1, 2), (2, 2), (1, 1), (2, 1)], [(1, 1), (2, 2), (3, 3)]
        flat = [[score for run in of for score in run] for of in (x, y)]
        self.assertEqual(list(map(summaries.interquartile_mean, flat)), [1.5, 2.0])
        tasks = [([float(run[task]) for run in x], [float(run[task]) for run in y]) for task in (0, 1)]
        self.assertAlmostEqual(summaries.improvement(tasks) or 0.0, 1 / 3, places=12)
        for found, value in zip(summaries.sequence([[0.8], [0.6, 0.9]]), (0.85, 0.20, 0.80), strict=True):
            self.assertAlmostEqual(found or 0.0, value, places=12)
        self.assertIsNone(summaries.sequence([[0.5]])[1], "one stage alone loses nothing")

    def test_tables_of_others(self) -> None:
        """Student's percentiles as printed in tables; `p.adjust(c(.01, .04, .03, .005), "holm")` of R."""
        for freedom, value in ((1, 12.706205), (2, 4.302653), (5, 2.570582), (30, 2.042272), (1000, 1.962339)):
            self.assertAlmostEqual(summaries.student(freedom), value, places=6)
        for found, value in zip(summaries.holm([0.01, 0.04, 0.03, 0.005]), (0.03, 0.06, 0.06, 0.02), strict=True):
            self.assertAlmostEqual(found, value, places=12)

    def test_by_hand(self) -> None:
        self.assertEqual([summaries.median(of) for of in ([3.0, 1.0, 2.0], [4.0, 1.0], [])], [2.0, 2.5, None])
        self.assertEqual(summaries.quantile([float(one) for one in range(101)], 0.99), 99.0)
        # Ln y is 0, 2, 1 where ln x is 0, 1, 2: slope .5 about (1, 1), residuals −.5, 1, −.5.
        e = math.e
        slope, half, intercept = summaries.power_law([(1, 1), (e, e * e), (e * e, e)]) or (0.0, 0.0, 0.0)
        self.assertAlmostEqual(slope, 0.5, places=12)
        self.assertAlmostEqual(intercept, 0.5, places=12)
        self.assertAlmostEqual(half, math.tan(0.475 * math.pi) * math.sqrt(0.75), places=9)
        self.assertIsNone(summaries.power_law([(1, 1), (2, 0), (3, 1)]))

    def test_sign_flips(self) -> None:
        for units, least in ((3, 0.25), (10, 2 / 1024)):
            test = resampling.flip_test([0.4] * units)
            self.assertEqual((test.p, test.least), (least, least))
        self.assertEqual(resampling.flip_test([0.0, 0.0]).p, 1.0)
        # 0.1 + 0.2 and 0.3 differ in their last bits.
        self.assertEqual(resampling.flip_test([0.1, 0.2, -0.3]).p, 1.0)
        # Beyond 16 units: of +1, −1 the sums are binomial.
        differences = [1.0] * 13 + [-1.0] * 5
        exact = 2 * sum(math.comb(18, k) for k in range(13, 19)) / 2**18
        drawn = resampling.flip_test(differences)
        self.assertTrue(drawn.is_drawn and drawn.low < exact < drawn.high, drawn)
        self.assertTrue(drawn.high - drawn.low < 0.03 and not drawn.low < 1.3 * exact < drawn.high, drawn)


class Chance(unittest.TestCase):
    """What is accepted of a drawn value."""

    def published(self, generator: random.Random, values: list[float], size: int) -> tuple[float, float]:
        """The interval of a mean as one publishes it, `size` values a cluster, drawn anew."""
        clusters = [values[first : first + size] for first in range(0, len(values), size)]
        drawn = sorted(
            sum(sum(generator.choice(clusters)) for _ in clusters) / len(values) for _ in range(resampling.PUBLISHED)
        )
        low, high = (summaries.quantile(drawn, share) or 0.0 for share in (0.025, 0.975))
        return round(low, 6), round(high, 6)

    def distribution(self, values: list[float], size: int = 1) -> Distribution[tuple[float, float]]:
        clusters = [[(one, 1.0) for one in values[at : at + size]] for at in range(0, len(values), size)]
        return Distribution(clusters, [len(clusters)], RATIO)

    def test_honest_intervals_are_accepted_and_others_are_not(self) -> None:
        generator = random.Random(SEED)
        for count in (6, 18):
            for _ in range(20):
                values = [generator.choice([0.0, 0.2, 0.6, 0.8, 1.0]) + generator.gauss(0, 0.1) for _ in range(count)]
                distribution = self.distribution(values)
                self.assertEqual(distribution.is_whole, count == 6)
                low, high = self.published(generator, values, 1)
                self.assertTrue(distribution.judge(low, upper=False).is_accepted, (values, low))
                self.assertTrue(distribution.judge(high, upper=True).is_accepted, (values, high))
                # The end of an interval of 80 %: 1.28 standard errors in place of 1.96.
                width = (1 - 1.28 / 1.96) * (high - low) / 2
                self.assertFalse(distribution.judge(round(low + width, 6), upper=False).is_accepted)
                # Four runs of each unit, which agree: drawn as units, and as if each run were one.
                runs = [one for one in values for _ in range(4)]
                self.assertTrue(self.distribution(runs, size=4).judge(low, upper=False).is_accepted)
                self.assertFalse(self.distribution(runs).judge(low, upper=False).is_accepted)

    def test_the_error_is_what_is_stated(self) -> None:
        """With an error of 10 % in place of 1e-6, nearly so many honest percentiles are refused, and no more."""
        generator, stated, refused = random.Random(SEED), resampling.ERROR, 0
        values = [generator.gauss(0, 1) for _ in range(6)]
        distribution, trials = self.distribution(values), 200
        try:
            resampling.ERROR = 0.1
            for _ in range(trials):
                refused += not distribution.judge(self.published(generator, values, 1)[0], upper=False).is_accepted
        finally:
            resampling.ERROR = stated
        # 462 values are nearly continuous. The two ends are those of two neighbouring order statistics.
        self.assertTrue(0.02 * trials < refused < 0.12 * trials, refused)

    def test_a_value_that_no_resample_has_is_refused(self) -> None:
        distribution = Distribution([[1.0], [4.0]], [2], MEDIAN)
        self.assertEqual([distribution.judge(value, upper=False).is_accepted for value in (1.0, 1.000001, 2.5)],
                         [True, False, False])

    def test_strata_are_drawn_apart(self) -> None:
        clusters = [[(1.0, 1.0)], [(3.0, 1.0)], [(100.0, 1.0)]]
        within = Distribution(clusters, [2, 1], RATIO)
        self.assertTrue(within.judge(34.0, upper=False).is_accepted and within.judge(106 / 3, upper=True).is_accepted)
        self.assertFalse(within.judge(1.0, upper=False).is_accepted)


class Planted(unittest.TestCase):
    """Errors that are planted in a published folder, each of which must show."""

    tables: dict[str, list[Table]]

    @classmethod
    def setUpClass(cls) -> None:
        cls.tables = recheck.expected(ledger.read(FOLDER / "ledger.jsonl"))

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name) / "planted"
        shutil.copytree(FOLDER, self.folder)

    def disagreements(self, *names: str) -> list[str]:
        """What disagrees, in these files of tables or in all."""
        tables = {file: of for file, of in self.tables.items() if not names or file in names}
        found = recheck.check_against(tables, self.folder)
        known = {name for file, of in tables.items() for name in (f"{file}.md", *(table.name for table in of))}
        return [str(one) for name, of in found.items() if not names or name in known for one in of.disagreements]

    def test_nothing_is_wrong_where_nothing_is_planted(self) -> None:
        self.assertEqual(self.disagreements(), [])

    def test_a_digit_in_csv(self) -> None:
        """Any digit of what is not drawn, the first one of what is."""
        generator = random.Random(SEED)
        print(f"seed {SEED}: {PLANTED} digits in each table")
        for file, table in ((file, table) for file, tables in self.tables.items() for table in tables):
            path = self.folder / f"{table.name}.csv"
            whole, there, drawn = path.read_text(encoding="utf-8"), published.read_csv(path), drawn_places(table)
            places = [
                (row, column) for row, fields in enumerate(there.rows) for column, field in enumerate(fields)
                if re.search(r"\d", field)
            ]
            for _ in range(PLANTED):
                row, column = generator.choice(places)
                field, rows = there.rows[row][column], [list(one) for one in there.rows]
                digits = [one.start() for one in re.finditer(r"\d", field)]
                is_drawn = (tuple(there.rows[row][: len(table.keys)]), column) in drawn
                rows[row][column] = other_digit(generator, field, digits[0] if is_drawn else generator.choice(digits))
                write_csv(path, [there.heads, *rows])
                # Another key is another row.
                where = "this row" if column < len(table.keys) else f"column {there.heads[column]}:"
                with self.subTest(table=table.name, row=row, column=there.heads[column], planted=rows[row][column]):
                    self.assertIn(where, " ".join(self.disagreements(file)))
            path.write_text(whole, encoding="utf-8")

    def test_a_digit_in_markdown(self) -> None:
        generator = random.Random(SEED)
        for file in (file for file, tables in self.tables.items() if tables):
            path = self.folder / f"{file}.md"
            whole = path.read_text(encoding="utf-8")
            lines = whole.splitlines(keepends=True)
            heads = {number for number, line in enumerate(lines[1:]) if line.startswith("| ---")}
            places = [
                (number, digit.start()) for number, line in enumerate(lines)
                if line.startswith(("| ", "- ")) and number not in heads for digit in re.finditer(r"\d", line)
            ]
            for number, at in generator.sample(places, min(PLANTED, len(places))):
                changed = other_digit(generator, lines[number], at)
                path.write_text("".join([*lines[:number], changed, *lines[number + 1 :]]), encoding="utf-8")
                with self.subTest(file=file, planted=changed):
                    self.assertTrue(self.disagreements(file))
            path.write_text(whole, encoding="utf-8")

    def test_a_success_more_in_the_ledger(self) -> None:
        generator, path = random.Random(SEED), self.folder / "ledger.jsonl"
        lines = path.read_text(encoding="utf-8").splitlines()
        records = [json.loads(line) for line in lines]
        fitting = [
            number for number, record in enumerate(records)
            if record["kind"] == "run" and (rate := record["after"]) and rate["successes"] < rate["rollouts"]
        ]
        for number in generator.sample(fitting, RECORDS):
            record = json.loads(lines[number])
            record["after"]["successes"] += 1
            record["after"]["once"] = max(record["after"]["once"], record["after"]["successes"])
            changed = [*lines[:number], json.dumps(record), *lines[number + 1 :]]
            path.write_text("\n".join(changed) + "\n", encoding="utf-8")
            wrong = {name for name, of in recheck.check(self.folder).items() if of.disagreements}
            self.assertTrue({"t1", "methods"} <= wrong, f"line {number + 1}: {wrong}")

    def test_files_rows_and_columns(self) -> None:
        """What is missing, and what ought not to be there."""
        t1, markdown = self.folder / "t1.csv", self.folder / "t1.md"
        there, whole = published.read_csv(t1), markdown.read_text(encoding="utf-8")
        write_csv(t1, [there.heads, *there.rows[1:]])
        self.assertIn("expected this row, found none", " ".join(self.disagreements("t1")))
        write_csv(t1, [there.heads, *there.rows, there.rows[0]])
        self.assertTrue(self.disagreements("t1"), "a row twice")
        write_csv(t1, [row[:-1] for row in [there.heads, *there.rows]])
        self.assertTrue(self.disagreements("t1"), "a column less")
        write_csv(t1, [[*there.heads, "luck"], *([*row, "0"] for row in there.rows)])
        self.assertTrue(self.disagreements("t1"), "a column more")
        t1.unlink()
        self.assertTrue(self.disagreements("t1"), "a table less")
        write_csv(t1, [there.heads, *there.rows])
        self.assertEqual(self.disagreements(), [])
        for name in ("t0.csv", "t0.md"):
            (self.folder / name).write_text("protocol\n", encoding="utf-8")
            self.assertTrue(any(name in one for one in self.disagreements()), name)
            (self.folder / name).unlink()
        markdown.write_text(re.sub(r"Records: (\d+)", r"Records: 1\1", whole), encoding="utf-8")
        self.assertTrue(self.disagreements("t1"), "records")
        markdown.unlink()
        self.assertTrue(self.disagreements("t1"), "Markdown less")

    def test_lines_that_are_no_records(self) -> None:
        path = self.folder / "ledger.jsonl"
        lines = path.read_text(encoding="utf-8").splitlines()
        other = [lines[1].replace('"schema":2', '"schema":1'), lines[1].replace("keyframes", "frames")]
        for bad in (lines[0], "{", *other):
            path.write_text(f"{lines[0]}\n{bad}\n", encoding="utf-8")
            with self.assertRaisesRegex(ledger.LedgerError, "ledger.jsonl:2: "):
                ledger.read(path)


def drawn_places(table: Table) -> set[tuple[tuple[str, ...], int]]:
    """The places of drawn fields: the key of the row, and the column among those that are written."""
    rows = [
        [field for column, cell in zip(table.columns, cells) for field in (cell or [Word("")] * len(column.fields()))]
        for cells in table.rows
    ]
    written = [index for index, fields in enumerate(zip(*rows)) if any(field != Word("") for field in fields)]
    places = set()
    for fields in rows:
        key = tuple(field.text for field in fields[: len(table.keys)] if isinstance(field, Word))
        drawn = (place for place, index in enumerate(written) if not isinstance(fields[index], Word | Exact))
        places |= {(key, place) for place in drawn}
    return places


def other_digit(generator: random.Random, text: str, at: int) -> str:
    """The text with another digit at this place."""
    return text[:at] + generator.choice([digit for digit in "0123456789" if digit != text[at]]) + text[at + 1 :]


def write_csv(path: Path, rows: list[list[str]]) -> None:
    """Writes rows as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


if __name__ == "__main__":
    unittest.main()
