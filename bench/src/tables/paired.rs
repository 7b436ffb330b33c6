//! SITU beside every other method: paired differences, tested by sign flips over units and corrected by Holm.

use std::collections::BTreeMap;

use situ::method::Role;

use super::column::{Bound, Cell, Columns, Shape, some};
use super::measure::{cell, difference, share, units};
use super::pooled::{Pooled, draws, pooled_by, pooled_ratio, unit_sums, variation};
use super::rows::{MethodName, place, role, rows};
use super::table::{self, NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};
use crate::stats;
use crate::stats::paired::{SignFlip, holm, probability_of_improvement, sign_flip};

/// The publication.
pub(super) const PAIRED: Publication = Publication {
    name: "paired",
    question: "Where is SITU better than another method, and where is it worse?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "paired",
    text: "SITU beside every other method, paired",
    note: "Every other method but the control. Differences, SITU less the other, over the runs of both in the same \
        cell with the same seed, where the task needs an edit: success on the changed task and on the original one \
        after the last demonstration, from fresh starts, and demonstrations, where a run that did not reach the target \
        counts the budget; and `fits`, the hidden Markov models fitted at an update, over runs of which both were \
        corrected, without a test. Two 95 % bootstrap intervals each: by units (family × seed) and by variations. p: a \
        two-sided sign-flip test over the sums of the units, exact up to 16 of them; `Holm` is corrected over all \
        tests of this table. `least p` is the least that as many units as differ in success can give, before the \
        correction. `improvement` is the probability that a run of SITU succeeds more often than a run of the other \
        method on the same variation, ties half, averaged over variations (Agarwal et al. 2021), each weighed by its \
        runs.",
};

/// Below this a corrected p-value shows a difference.
const LEVEL: f64 = 0.05;

/// The method that is compared.
const SITU: &str = "situ";

/// A quantity of a run; `None` where the run has none.
type Measure = ([&'static str; 3], fn(&RunRecord) -> Option<f64>);

const MEASURES: [Measure; 3] = [
    (["success", "p_success", "Holm_success"], |run| share(run.after)),
    (["demonstrations", "p_demonstrations", "Holm_demonstrations"], |run| Some(f64::from(run.charged()))),
    (["original", "p_original", "Holm_original"], |run| share(run.retained)),
];

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
    /// The probability that SITU does better.
    improvement: Cell,
    /// The difference of the fits of an update.
    fits: Cell,
    /// One for each measure.
    tested: Vec<Option<Tested>>,
}

/// Hidden Markov models fitted at an update, the mean over the corrections of a run.
fn fits(run: &RunRecord) -> Option<f64> {
    stats::mean(&run.corrections.iter().map(|correction| correction.counters.hmm_fits as f64).collect::<Vec<_>>())
}

/// A difference of a measure over pairs, SITU's run first.
fn tested(of: &[(&RunRecord, &RunRecord)], measure: fn(&RunRecord) -> Option<f64>) -> Option<Tested> {
    let differences = of.iter().filter_map(|(own, other)| Some((*own, measure(own)? - measure(other)?)));
    let differences: Vec<(&RunRecord, f64)> = differences.collect();
    let weighed: Vec<_> = differences.iter().map(|(run, value)| (*run, (*value, 1.0))).collect();
    let test = sign_flip(&unit_sums(&differences), draws())?;
    Some(Tested { difference: pooled_ratio(&weighed)?, test, corrected: test.p })
}

/// The probability that the success of a run of SITU is greater than that of a run of the other method on the same
/// variation, averaged over variations.
fn improvement(of: &[(&RunRecord, &RunRecord)]) -> Cell {
    let scored = of.iter().filter_map(|(own, other)| Some((*own, (*own, share(own.after)?, share(other.after)?))));
    let scored: Vec<_> = scored.collect();
    let probability = |scores: &mut dyn Iterator<Item = &(&RunRecord, f64, f64)>| {
        let mut tasks: BTreeMap<_, (Vec<f64>, Vec<f64>)> = BTreeMap::new();
        for (run, own, other) in scores {
            let of = tasks.entry(variation(run)).or_default();
            of.0.push(*own);
            of.1.push(*other);
        }
        let tasks: Vec<(&[f64], &[f64])> = tasks.values().map(|(own, other)| (&**own, &**other)).collect();
        probability_of_improvement(&tasks)
    };
    cell(pooled_by(&scored, probability), Bound::Exact)
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.key.0)
        .text("teacher", |row| row.key.1)
        .text("other", |row| row.key.2.name)
        .count("runs", |row| row.runs)
        .count("units", |row| row.units)
        .column("improvement", Shape::Pooled(2), |row| row.improvement.clone())
        .column("least_p", Shape::Number(4), |row| {
            some(row.tested.iter().flatten().next(), |tested| Cell::Number(tested.test.least))
        });
    let columns =
        MEASURES.into_iter().enumerate().fold(columns, |columns, (index, ([difference, p, corrected], _))| {
            let of = move |row: &Row, cell: fn(&Tested) -> Cell| some(row.tested[index].as_ref(), cell);
            columns
                .column(difference, Shape::Pooled(2), move |row| {
                    of(row, |tested| Cell::Pooled(tested.difference, Bound::Exact))
                })
                .column(p, Shape::Number(4), move |row| of(row, |tested| Cell::Number(tested.test.p)))
                .column(corrected, Shape::Number(4), move |row| of(row, |tested| Cell::Number(tested.corrected)))
        });
    columns.column("fits", Shape::Pooled(1), |row| row.fits.clone())
}

/// What a test says of SITU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Worse,
    NotShown,
    Better,
}

impl Verdict {
    /// Fewer demonstrations are better, and more of everything else.
    fn of(measure: usize, tested: &Tested) -> Self {
        let is_more = (tested.difference.value > 0.0) != (MEASURES[measure].0[0] == "demonstrations");
        match (tested.corrected < LEVEL, is_more) {
            (false, _) => Self::NotShown,
            (true, true) => Self::Better,
            (true, false) => Self::Worse,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Worse => "worse",
            Self::NotShown => "no difference is shown",
            Self::Better => "better",
        }
    }
}

/// A sentence for each test, where SITU is worse first.
fn said(table: &[Row<'_>]) -> Vec<String> {
    let tests = table.iter().flat_map(|row| {
        let tested = row.tested.iter().enumerate();
        tested.filter_map(move |(measure, tested)| Some((row, measure, tested.as_ref()?)))
    });
    let mut said: Vec<(Verdict, String)> = tests
        .map(|(row, measure, tested)| {
            let verdict = Verdict::of(measure, tested);
            let name = MEASURES[measure].0[0];
            let digits = Shape::Pooled(2);
            let difference = table::markdown(digits, &Cell::Pooled(tested.difference, Bound::Exact));
            let (teacher, other, words) = (row.key.1, row.key.2.name, verdict.words());
            let p = table::markdown(Shape::Number(4), &Cell::Number(tested.corrected));
            (verdict, format!("`{SITU}` against `{other}`, {teacher}, {name}: {words}: {difference}, Holm {p}."))
        })
        .collect();
    said.sort_by_key(|(verdict, _)| *verdict);
    said.into_iter().map(|(_, sentence)| sentence).collect()
}

fn table(records: &Canonical) -> Table {
    let runs = || records.iter().filter_map(Record::single_run).filter(|run| run.counts_for_an_edit());
    let own: BTreeMap<_, &RunRecord> =
        runs().filter(|run| run.key.method == SITU).map(|run| (place(run), run)).collect();
    let others = runs().filter(|run| run.key.method != SITU && role(&run.key.method) != Role::Control);
    let pairs = others.filter_map(|other| {
        let key: Key = (&other.key.protocol, &other.key.teacher, MethodName::of(&other.key.method));
        Some((key, (*own.get(&place(other))?, other)))
    });
    let mut table: Vec<Row> = Vec::new();
    for row in rows(pairs) {
        let tested = MEASURES.iter().map(|(_, measure)| tested(&row.of, *measure)).collect();
        let units = units(row.of.iter().map(|pair| pair.0));
        let improvement = improvement(&row.of);
        let fits = difference(row.of.iter().map(|(own, other)| (*own, fits(own), fits(other))));
        table.push(Row { key: row.key, runs: row.of.len(), units, improvement, fits, tested });
    }
    let mut tests: Vec<&mut Tested> = table.iter_mut().flat_map(|row| row.tested.iter_mut().flatten()).collect();
    let corrected = holm(&tests.iter().map(|tested| tested.test.p).collect::<Vec<_>>());
    for (tested, corrected) in tests.iter_mut().zip(corrected) {
        tested.corrected = corrected;
    }
    let said = said(&table);
    Table::new(TITLE, columns(), &table, table.iter().map(|row| (row.key.0, row.runs))).saying(said)
}
