//! SITU beside every other method: paired differences, tested by sign flips over units and corrected by Holm.

use std::collections::BTreeMap;

use super::column::{Bound, Cell, Columns, Shape, some};
use super::pooled::{Pooled, pooled, unit_means};
use super::rows::{MethodName, rows};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Rate, Record, RunRecord};
use crate::stats::paired::{SignFlip, holm, sign_flip};

/// The publication.
pub(super) const PAIRED: Publication = Publication {
    name: "paired",
    question: "Where is SITU better than another method, and where is it worse?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "paired",
    text: "SITU beside every other method, paired",
    note: "Differences, SITU less the other, over the runs of both in the same cell with the same seed, where the task \
        needs an edit: success on the changed task and on the original one after the last demonstration, from fresh \
        starts, and demonstrations, where a run that did not reach the target counts the budget. Two 95 % bootstrap \
        intervals each: by units (family × seed) and by variations. p: a two-sided sign-flip test over the means of the \
        units, exact up to 16 of them; `Holm` is corrected over all tests of this table. `least p` is the least that \
        so many units can give.",
};

/// The method that is compared.
const SITU: &str = "situ";

/// A quantity of a run; `None` where the run has none.
type Measure = (&'static str, [&'static str; 3], fn(&RunRecord) -> Option<f64>);

const MEASURES: [Measure; 3] = [
    ("success", ["success", "p_success", "Holm_success"], |run| share(run.after)),
    ("demonstrations", ["demonstrations", "p_demonstrations", "Holm_demonstrations"], |run| {
        Some(f64::from(if run.is_reached() { run.effort.demonstrations } else { run.budget }))
    }),
    ("original", ["original", "p_original", "Holm_original"], |run| share(run.retained)),
];

fn share(rate: Option<Rate>) -> Option<f64> {
    rate.filter(|rate| rate.rollouts > 0).map(|rate| f64::from(rate.successes) / f64::from(rate.rollouts))
}

/// Protocol, teacher, and the method that SITU is compared with.
type Key<'a> = (&'a str, &'a str, MethodName<'a>);

/// A difference and its test.
struct Tested {
    difference: Pooled,
    test: SignFlip,
    /// The p-value corrected over the table.
    corrected: f64,
}

struct Row<'a> {
    key: Key<'a>,
    runs: usize,
    units: usize,
    /// One for each measure.
    tested: Vec<Option<Tested>>,
}

/// A difference of a measure over pairs, SITU's run first.
fn tested(of: &[(&RunRecord, &RunRecord)], measure: fn(&RunRecord) -> Option<f64>, seed: u64) -> Option<Tested> {
    let differences = of.iter().filter_map(|(own, other)| Some((*own, measure(own)? - measure(other)?)));
    let differences: Vec<(&RunRecord, f64)> = differences.collect();
    let weighed: Vec<_> = differences.iter().map(|(run, value)| (*run, (*value, 1.0))).collect();
    let test = sign_flip(&unit_means(&differences), seed)?;
    Some(Tested { difference: pooled(&weighed, seed)?, test, corrected: test.p })
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("other", |row| row.key.2.name)
        .count("runs", |row| row.runs)
        .count("units", |row| row.units)
        .column("least_p", Shape::Number(4), |row| {
            some(row.tested.iter().flatten().next(), |tested| Cell::Number(tested.test.least))
        });
    MEASURES.into_iter().enumerate().fold(columns, |columns, (index, (_, [difference, p, corrected], _))| {
        let of = move |row: &Row, cell: fn(&Tested) -> Cell| some(row.tested[index].as_ref(), cell);
        columns
            .column(difference, Shape::Pooled(2), move |row| {
                of(row, |tested| Cell::Pooled(tested.difference, Bound::Exact))
            })
            .column(p, Shape::Number(4), move |row| of(row, |tested| Cell::Number(tested.test.p)))
            .column(corrected, Shape::Number(4), move |row| of(row, |tested| Cell::Number(tested.corrected)))
    })
}

fn table(records: &Canonical) -> Table {
    let runs = || {
        let runs = records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
        runs.filter(|run| run.key.edit != situ::edit::Edit::None)
    };
    let place = |run: &RunRecord| {
        let key = &run.key;
        (key.protocol.clone(), key.task.clone(), key.variation.clone(), key.teacher.clone(), key.seed)
    };
    let own: BTreeMap<_, &RunRecord> =
        runs().filter(|run| run.key.method == SITU).map(|run| (place(run), run)).collect();
    let others = runs().filter(|run| run.key.method != SITU);
    let pairs = others.filter_map(|other| {
        let key: Key = (&other.key.protocol, &other.key.teacher, MethodName::of(&other.key.method));
        Some((key, (*own.get(&place(other))?, other)))
    });
    let label = |(protocol, teacher, method): &Key<'_>| format!("paired/{protocol}/{teacher}/{method}");
    let mut table: Vec<Row> = Vec::new();
    for row in rows(pairs, label) {
        let tested = MEASURES.iter().map(|(name, _, measure)| tested(&row.of, *measure, row.seed(name))).collect();
        let unit = |(run, _): &(&RunRecord, &RunRecord)| (run.key.task.clone(), run.key.seed);
        let units = row.of.iter().map(unit).collect::<std::collections::BTreeSet<_>>().len();
        table.push(Row { key: row.key, runs: row.of.len(), units, tested });
    }
    let mut tests: Vec<&mut Tested> = table.iter_mut().flat_map(|row| row.tested.iter_mut().flatten()).collect();
    let corrected = holm(&tests.iter().map(|tested| tested.test.p).collect::<Vec<_>>());
    for (tested, corrected) in tests.iter_mut().zip(corrected) {
        tested.corrected = corrected;
    }
    Table::new(TITLE, columns(), &table, table.iter().map(|row| (row.key.0, row.runs)))
}
