//! T7: whether the probabilities of children mean what they say, and how well the policies explain what they were not
//! given.

use super::column::{Bound, Cell, Columns, Shape, some};
use super::measure::{cell, median, of_runs, share_of, units, variations};
use super::pooled::pooled_by;
use super::rows::{self, MethodKey, method_columns, method_key, rows};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::calibration::{BranchCalibration, brier, calibration_error};
use crate::ledger::Canonical;
use crate::record::{Record, RunRecord};

/// The publication.
pub(super) const T7: Publication = Publication {
    name: "t7",
    question: "Do the probabilities of children mean what they say, and do the policies explain what they were not given?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "t7",
    text: "T7 confidence: calibration at the branches, and likelihood of what was held out",
    note: "A row is a method and the edit that the variation needs, over all tasks, teachers and seeds whose run \
        counts. A choice is made where a place has two children or more, in the rollouts of the last model from fresh \
        starts; the likeliest child is right where it holds the skill that the task's own program would do next, as \
        the teacher calls it, or is END where the goal holds. `accuracy` is the share that was right; Brier and ECE \
        are the Brier score and the expected calibration error (ten bins of equal width) of its probability; runs \
        without a choice enter none of the three. `explained` is the share of the segments of a demonstration that was \
        given to nobody for which some primitive has a density; `likelihood` their log-likelihood, nats per keyframe, \
        the median over runs. Two 95 % bootstrap intervals each: by units (family × seed) and by variations.",
};

type Row<'a> = rows::Row<MethodKey<'a>, &'a RunRecord>;

fn calibrations<'a>(row: &Row<'a>) -> Vec<(&'a RunRecord, &'a BranchCalibration)> {
    row.of.iter().filter_map(|run| Some((*run, run.calibration.as_ref()?))).collect()
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    method_columns::<Row<'a>>(|row| row.key)
        .count("runs", |row| row.of.len())
        .count("units", |row| units(row.of.iter().copied()))
        .count("variations", |row| variations(row.of.iter().copied()))
        .count("choices", |row| calibrations(row).iter().map(|(_, one)| one.choices() as usize).sum::<usize>())
        .column("accuracy", Shape::Pooled(2), |row| {
            let pair = |(run, one): (_, &BranchCalibration)| (run, (f64::from(one.right()), f64::from(one.choices())));
            let of: Vec<_> = calibrations(row).into_iter().map(pair).collect();
            share_of(&of)
        })
        .column("Brier", Shape::Pooled(3), |row| {
            cell(pooled_by(&calibrations(row), |all| brier(all.copied())), Bound::Exact)
        })
        .column("ECE", Shape::Number(3), |row| {
            some(calibration_error(calibrations(row).into_iter().map(|(_, one)| one)), Cell::Number)
        })
        .column("explained", Shape::Pooled(2), |row| {
            let pair = |run: &RunRecord| {
                let held_out = run.held_out?;
                Some((f64::from(held_out.explained), f64::from(held_out.segments)))
            };
            share_of(&of_runs(row.of.iter().copied(), pair))
        })
        .column("likelihood", Shape::Pooled(1), |row| {
            let of = of_runs(row.of.iter().copied(), |run| run.held_out?.per_keyframe());
            median(&of)
        })
}

fn table(records: &Canonical) -> Table {
    let runs = records.iter().filter_map(Record::single_run).filter(|run| run.outcome.counts());
    let rows: Vec<Row> = rows(runs.map(|run| (method_key(run), run)));
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.key.0, row.of.len())))
}
