//! T1: number and length of the demonstrations it takes to correct a task model, against teaching from scratch.

use std::collections::BTreeMap;

use situ::edit::Edit;
use situ::method::Role;

use super::{Bound, Cell, Column, MethodName, Methods, Shape, Table, column, made, rate, seed, share};
use crate::record::{Effort, Outcome, Record, Run};
use crate::stats;

/// The method that others are compared with, and whose demonstrations are full ones.
const FROM_SCRATCH: &str = "from_scratch";

const NOTE: &str = "A row is a cell over its seeds. Runs of a method that cannot make the edit needed (not applicable), untaught and spoilt runs are \
counted apart and enter nothing else. Success is \
pooled over the rollouts of all seeds, with the Wilson 95 % interval. Demonstrations, keyframes, seconds and metres are what \
was spent until the target success rate was first reached or the budget of demonstrations was used up (restricted mean, 95 % \
bootstrap interval over seeds); ≥ marks a mean over runs some of which used the budget up. Ratios are to teaching from scratch, \
paired by seed; ≥, ≤ and ~ mark censored corrections, censored teaching from scratch, and both.";

type Measure = (&'static str, fn(&Effort) -> f64, Shape);

const MEASURES: [Measure; 4] = [
    ("demonstrations", |effort| f64::from(effort.demonstrations), Shape::Estimate(1)),
    ("keyframes", |effort| f64::from(effort.keyframes), Shape::Estimate(1)),
    ("seconds", |effort| effort.seconds, Shape::Estimate(1)),
    ("metres", |effort| effort.metres, Shape::Estimate(2)),
];

/// The measures whose ratio to teaching from scratch is shown: number and length, the paper's own.
const RATIOS: [(&str, usize); 2] = [("demonstrations_ratio", 0), ("keyframes_ratio", 1)];

fn columns() -> Vec<Column> {
    let text =
        ["protocol", "task", "variation", "edit_needed", "teacher", "method"].map(|name| column(name, Shape::Text));
    let counts = ["seeds", "not_applicable", "untaught", "spoilt"].map(|name| column(name, Shape::Count));
    let rates = ["before", "after", "reached"].map(|name| column(name, Shape::Rate));
    let measures = MEASURES.map(|(name, _, shape)| column(name, shape));
    let ratios = RATIOS.map(|(name, _)| column(name, Shape::Estimate(2)));
    let edits = ["made_first", "made_in_all"].map(|name| column(name, Shape::Text));
    text.into_iter().chain(counts).chain(rates).chain(measures).chain(ratios).chain(edits).collect()
}

/// A cell without its method, and the method.
type Row<'a> = ((&'a str, &'a str, &'a str, Edit, &'a str), MethodName);

fn row_of<'a>(run: &'a Run, methods: &Methods) -> Row<'a> {
    let key = &run.key;
    ((&key.protocol, &key.task, &key.variation, key.edit, &key.teacher), methods.name(&key.method))
}

/// The table, from records in canonical order.
pub(super) fn table(records: &[Record]) -> Table {
    let methods = Methods::listed();
    let mut rows: BTreeMap<Row, Vec<&Run>> = BTreeMap::new();
    for record in records {
        if let Some(run) = record.single_run() {
            rows.entry(row_of(run, &methods)).or_default().push(run);
        }
    }
    let scratch = methods.name(FROM_SCRATCH);
    let rendered = rows.iter().map(|(row, runs)| {
        let compared = methods.role(&row.1.name) == Role::Correct;
        let partners = compared.then(|| rows.get(&(row.0, scratch.clone()))).flatten();
        cells(row, runs, partners.map_or(&[], Vec::as_slice))
    });
    Table {
        id: "t1",
        title: "T1 effort: what corrections take, against teaching from scratch",
        note: NOTE,
        columns: columns(),
        rows: rendered.collect(),
        protocols: rows.keys().map(|row| row.0.0.to_owned()).collect(),
        records: rows.values().map(Vec::len).sum(),
    }
}

fn cells(row: &Row, runs: &[&Run], partners: &[&Run]) -> Vec<Cell> {
    let ((protocol, task, variation, edit, teacher), MethodName { name: method, .. }) = row;
    let label = format!("t1/{protocol}/{task}/{variation}/{edit}/{teacher}/{method}");
    let counted: Vec<&Run> = runs.iter().copied().filter(|run| run.outcome.counts()).collect();
    let outcomes = |is: fn(&Outcome) -> bool| Cell::Count(runs.iter().filter(|run| is(&run.outcome)).count());
    let mut cells: Vec<Cell> = [*protocol, *task, *variation, edit.name(), *teacher, method.as_str()]
        .into_iter()
        .map(|word| Cell::Text(word.to_owned()))
        .collect();
    cells.push(Cell::Count(runs.len()));
    cells.push(outcomes(|outcome| *outcome == Outcome::NotApplicable));
    cells.push(outcomes(|outcome| *outcome == Outcome::Untaught));
    cells.push(outcomes(|outcome| matches!(outcome, Outcome::Spoilt { .. })));
    cells.push(rate(counted.iter().filter_map(|run| run.before)));
    cells.push(rate(counted.iter().filter_map(|run| run.after)));
    cells.push(share(counted.iter().map(|run| is_reached(run))));
    for (name, measure, _) in MEASURES {
        let spent: Vec<(f64, bool)> = counted.iter().map(|run| (measure(&run.effort), !is_reached(run))).collect();
        cells.push(match stats::restricted_mean(&spent, seed(&label, name)) {
            None => Cell::Nothing,
            Some(mean) => Cell::Estimate(mean.estimate, Bound::of(mean.censored == 0, true)),
        });
    }
    let pairs: Vec<(&Run, &Run)> = counted.iter().filter_map(|run| Some((*run, partner(run, partners)?))).collect();
    let all = |part: fn(&(&Run, &Run)) -> bool| pairs.iter().all(part);
    let bound = Bound::of(all(|pair| is_reached(pair.0)), all(|pair| is_reached(pair.1)));
    for (name, measure) in RATIOS {
        let spent = |run: &Run| MEASURES[measure].1(&run.effort);
        let pairs: Vec<(f64, f64)> = pairs.iter().map(|pair| (spent(pair.0), spent(pair.1))).collect();
        let ratio = stats::paired_ratio(&pairs, seed(&label, name));
        cells.push(ratio.map_or(Cell::Nothing, |ratio| Cell::Estimate(ratio, bound)));
    }
    let corrections = |run: &&Run| run.corrections.iter().map(|correction| correction.edit_made).collect::<Vec<_>>();
    cells.push(made(counted.iter().filter_map(|run| corrections(run).first().copied())));
    cells.push(made(counted.iter().flat_map(corrections)));
    cells
}

fn is_reached(run: &Run) -> bool {
    run.outcome == Outcome::Reached
}

/// The run from scratch with the same seed, where it counts.
fn partner<'a>(run: &Run, partners: &[&'a Run]) -> Option<&'a Run> {
    partners.iter().copied().find(|other| other.key.seed == run.key.seed && other.outcome.counts())
}
