//! Every method beside every edit: success, demonstrations, and what an update costs against SITU's.

use situ::method::Role;

use super::column::{Cell, Columns, MILLISECONDS_PER_SECOND, Shape};
use super::measure::{EFFORT, effort, interquartile_mean, median, of_runs, once, share_of, success, units, variations};
use super::rows::{Compared, MethodKey, compared, method_columns, method_key, role, uncounted};
use super::table::{NO_FIGURES, Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::RunRecord;

/// The publication.
pub(super) const METHODS: Publication = Publication {
    name: "methods",
    question: "What does every method reach, edit by edit, and what does its update cost against SITU's?",
    tables: |records| vec![table(records)],
    figures: NO_FIGURES,
};

const TITLE: Title = Title {
    id: "methods",
    text: "Methods: every method beside every edit",
    note: "A row is a method and the edit that the variation needs, over all tasks, variations, teachers and seeds. \
        Runs of a method that cannot make the edit (not applicable), untaught and spoilt runs are counted apart and \
        enter nothing else. `reached` is the share of runs that reached the target within their budget, by the \
        rollouts that decided, and `below target` how many of them are below it from fresh starts. `after` and `once` \
        (at some time in the rollout) are success from fresh starts, by which nothing was decided; IQM is the \
        interquartile mean over runs; `original` is success on the original task after the last correction. \
        Demonstrations are corrective, or full ones where a method is taught from scratch; a run that did not reach \
        the target counts its budget. ≥ marks a mean with such runs, whose tries are what was spent; a control is \
        taught nothing and has neither. `to situ` is the ratio of such means, paired by cell and seed; ≥, ≤ and ~ mark \
        runs of the method, of situ and of both that did not reach it. Two 95 % bootstrap intervals each: by units \
        (family × seed) and by variations. The clock: the median over runs of the mean time of an update, and the \
        median of its ratio to that of situ in the same cell with the same seed, where both were corrected; other runs \
        went on beside it.",
};

/// The method that others are compared with.
const SITU: &str = "situ";

type Row<'a> = Compared<'a, MethodKey<'a>>;

/// The ratio of the time of an update to that of `situ`.
fn time_to_situ(row: &Row) -> Cell {
    let ratio = |(run, situ): &(&RunRecord, &RunRecord)| Some(run.update_seconds()? / situ.update_seconds()?);
    let ratios = row.pairs.iter().filter_map(|pair| Some((pair.0, ratio(pair).filter(|ratio| ratio.is_finite())?)));
    median(&ratios.collect::<Vec<_>>())
}

/// The mean of a measure of effort; nothing for a control, which is taught nothing.
fn taught(row: &Row, index: usize) -> Cell {
    if role(row.row.key.1.name) == Role::Control {
        return Cell::Nothing;
    }
    let (_, measure, _) = EFFORT[index];
    effort(row.runs(), measure)
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.row.key)
        .count("runs", |row| row.counted.len())
        .count("units", |row| units(row.runs()))
        .count("variations", |row| variations(row.runs()));
    let is_reached = |run: &RunRecord| Some((f64::from(u8::from(run.is_reached())), 1.0));
    uncounted(columns)
        .column("reached", Shape::Pooled(2), move |row| share_of(&of_runs(row.runs(), is_reached)))
        .count("below_target", |row| row.runs().filter(|run| run.is_reached_by_luck()).count())
        .column("after", Shape::Pooled(2), |row| success(row.runs(), |run| run.after))
        .column("once", Shape::Pooled(2), |row| once(row.runs()))
        .column("IQM", Shape::Pooled(2), |row| interquartile_mean(row.runs()))
        .column("original", Shape::Pooled(2), |row| success(row.runs(), |run| run.retained))
        .column("demonstrations", Shape::Pooled(2), |row| taught(row, 0))
        .column("tries", Shape::Pooled(2), |row| taught(row, 1))
        .column("demonstrations_to_situ", Shape::Pooled(2), |row| {
            if role(row.row.key.1.name) == Role::Control { Cell::Nothing } else { row.ratio(EFFORT[0].1) }
        })
        .wall("update_ms", Shape::Pooled(2), |row| {
            let times = of_runs(row.runs(), |run| Some(MILLISECONDS_PER_SECOND * run.update_seconds()?));
            median(&times)
        })
        .wall("update_to_situ", Shape::Pooled(1), time_to_situ)
}

fn table(records: &Canonical) -> Table {
    let rows = compared(records, method_key, SITU, |run| run.key.method != SITU);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.row.key.0, row.row.of.len())))
}
