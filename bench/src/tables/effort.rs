//! T1: number and length of the demonstrations it takes to correct a task model, against teaching from scratch.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::method::Role;

use super::cell::{Bound, Cell, made, rate, seed, share, some, spent};
use super::column::{Columns, Shape};
use super::method_name::{MethodName, Methods};
use super::publication::Publication;
use super::table::{Table, Title};
use crate::ledger::Canonical;
use crate::record::{Outcome, Record, RunRecord, TotalEffort};
use crate::stats;

/// The publication.
pub(super) const T1: Publication = Publication {
    name: "t1",
    question: "What do corrections take, against teaching the changed task from scratch?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "t1",
    text: "T1 effort: what corrections take, against teaching from scratch",
    note: "A row is a cell over its seeds. Runs of a method that cannot make the edit needed (not applicable), \
        untaught and spoilt runs are counted apart and enter nothing else. Success is pooled over the rollouts of all \
        seeds, with the Wilson 95 % interval. Demonstrations, keyframes, seconds and metres are what was spent until \
        the target success rate was first reached or the budget of demonstrations was used up (restricted mean, 95 % \
        bootstrap interval over seeds); ≥ marks a mean over runs some of which used the budget up. Ratios are to \
        teaching from scratch, paired by seed; ≥, ≤ and ~ mark censored corrections, censored teaching from scratch, \
        and both.",
};

/// The method that others are compared with, and whose demonstrations are whole ones.
const FROM_SCRATCH: &str = "from_scratch";

type Measure = (&'static str, fn(&TotalEffort) -> f64, usize);

const MEASURES: [Measure; 4] = [
    ("demonstrations", |effort| f64::from(effort.demonstrations), 1),
    ("keyframes", |effort| f64::from(effort.keyframes), 1),
    ("seconds", |effort| effort.seconds, 1),
    ("metres", |effort| effort.metres, 2),
];

/// The measures whose ratio to teaching from scratch is shown: number and length, the paper's own.
const RATIOS: [(&str, usize); 2] = [("demonstrations_ratio", 0), ("keyframes_ratio", 1)];

/// A cell of the protocol, but for its method.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place<'a> {
    protocol: &'a str,
    task: &'a str,
    variation: &'a str,
    edit: Edit,
    teacher: &'a str,
}

struct Row<'a> {
    place: Place<'a>,
    method: &'a str,
    runs: Vec<&'a RunRecord>,
    /// Those of the runs that say something about the method.
    counted: Vec<&'a RunRecord>,
    /// Each of these, and the run from scratch with the same seed, where that says something too.
    pairs: Vec<(&'a RunRecord, &'a RunRecord)>,
    /// How the ratios to teaching from scratch stand to the truth.
    bound: Bound,
}

impl<'a> Row<'a> {
    fn new(place: Place<'a>, method: &'a str, runs: Vec<&'a RunRecord>, partners: &[&'a RunRecord]) -> Self {
        let counted: Vec<_> = runs.iter().copied().filter(|run| run.outcome.counts()).collect();
        let partner = |run: &RunRecord| {
            let with_seed = |other: &&RunRecord| other.key.seed == run.key.seed && other.outcome.counts();
            partners.iter().copied().find(with_seed)
        };
        let pairs: Vec<_> = counted.iter().filter_map(|run| Some((*run, partner(run)?))).collect();
        let (own, theirs) =
            (pairs.iter().all(|pair| pair.0.is_reached()), pairs.iter().all(|pair| pair.1.is_reached()));
        Self { place, method, runs, counted, pairs, bound: Bound::of(own, theirs) }
    }

    fn outcomes(&self, is: fn(&Outcome) -> bool) -> usize {
        self.runs.iter().filter(|run| is(&run.outcome)).count()
    }

    /// The seed of the bootstrap of a quantity.
    fn seed(&self, quantity: &str) -> u64 {
        let Place { protocol, task, variation, edit, teacher } = self.place;
        seed(&format!("t1/{protocol}/{task}/{variation}/{edit}/{teacher}/{}", self.method), quantity)
    }
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = Columns::<Row<'a>>::new()
        .text("protocol", |row| row.place.protocol)
        .text("task", |row| row.place.task)
        .text("variation", |row| row.place.variation)
        .text("edit_needed", |row| row.place.edit.name())
        .text("teacher", |row| row.place.teacher)
        .text("method", |row| row.method)
        .count("seeds", |row| row.runs.len())
        .count("not_applicable", |row| row.outcomes(|outcome| *outcome == Outcome::NotApplicable))
        .count("untaught", |row| row.outcomes(|outcome| *outcome == Outcome::Untaught))
        .count("spoilt", |row| row.outcomes(|outcome| matches!(outcome, Outcome::Spoilt { .. })))
        .column("before", Shape::Rate, |row| rate(row.counted.iter().filter_map(|run| run.before)))
        .column("after", Shape::Rate, |row| rate(row.counted.iter().filter_map(|run| run.after)))
        .column("reached", Shape::Rate, |row| share(row.counted.iter().map(|run| run.is_reached())));
    let columns = MEASURES.into_iter().fold(columns, |columns, (name, measure, digits)| {
        columns.column(name, Shape::Estimate(digits), move |row| {
            let of = row.counted.iter().map(|run| (measure(&run.effort), !run.is_reached()));
            spent(of, row.seed(name))
        })
    });
    let columns = RATIOS.into_iter().fold(columns, |columns, (name, measure)| {
        columns.column(name, Shape::Estimate(2), move |row| {
            let measure = MEASURES[measure].1;
            let pairs: Vec<_> =
                row.pairs.iter().map(|(own, other)| (measure(&own.effort), measure(&other.effort))).collect();
            some(stats::paired_ratio(&pairs, row.seed(name)), |ratio| Cell::Estimate(ratio, row.bound))
        })
    });
    columns
        .text("made_first", |row| made(row.counted.iter().filter_map(|run| run.edits_made().next())))
        .text("made_in_all", |row| made(row.counted.iter().flat_map(|run| run.edits_made())))
}

fn table(records: &Canonical) -> Table {
    let methods = Methods::listed();
    let mut runs: BTreeMap<(Place, MethodName), Vec<&RunRecord>> = BTreeMap::new();
    for run in records.iter().filter_map(Record::single_run) {
        let key = &run.key;
        let (protocol, task, variation, teacher) = (&*key.protocol, &*key.task, &*key.variation, &*key.teacher);
        let place = Place { protocol, task, variation, edit: key.edit, teacher };
        runs.entry((place, methods.name(&key.method))).or_default().push(run);
    }
    let mut rows = Vec::with_capacity(runs.len());
    for (&(place, method), own) in &runs {
        let partners = runs.get(&(place, methods.name(FROM_SCRATCH)));
        let partners = partners.filter(|_| methods.role(method.name) == Role::Correct);
        rows.push(Row::new(place, method.name, own.clone(), partners.map_or(&[], Vec::as_slice)));
    }
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.place.protocol, row.runs.len())))
}
