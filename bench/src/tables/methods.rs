//! Every method beside every edit: success, demonstrations, and what an update costs against SITU's.

use std::collections::BTreeSet;

use super::column::{Cell, Columns, MILLISECONDS_PER_SECOND, Shape, median, rate, share, spent};
use super::rows::{Compared, MethodKey, compared, method_columns, method_key, uncounted};
use super::table::{Publication, Table, Title};
use crate::ledger::Canonical;
use crate::record::RunRecord;
use crate::stats;

/// The publication.
pub(super) const METHODS: Publication = Publication {
    name: "methods",
    question: "What does every method reach, edit by edit, and what does its update cost against SITU's?",
    tables: |records| vec![table(records)],
};

const TITLE: Title = Title {
    id: "methods",
    text: "Methods: every method beside every edit",
    note: "A row is a method and the edit that the variation needs, over all tasks, variations, teachers and seeds. \
        Runs of a method that cannot make the edit (not applicable), untaught and spoilt runs are counted apart and \
        enter nothing else. `reached` is the share of runs that reached the target within their budget, `after` \
        success pooled over rollouts; Wilson 95 % intervals. Demonstrations are corrective, or full ones where a \
        method is taught from scratch, until the target was reached or the budget used up (restricted mean, 95 % \
        bootstrap interval over runs); ≥ marks a mean over runs some of which used it up. `to_situ` is the ratio of \
        such means, paired by cell and seed; ≥, ≤ and ~ mark runs of the method, of situ and of both that used their \
        budget up. The clock: the median over runs of the mean time of an update, and the median of its ratio to that \
        of situ in the same cell with the same seed, where both were corrected; other runs went on beside it.",
};

/// The method that others are compared with.
const SITU: &str = "situ";

type Row<'a> = Compared<'a, MethodKey<'a>>;

/// The number of tasks, variations and teachers.
fn cells(row: &Row) -> usize {
    let keys = row.row.of.iter().map(|run| &run.key);
    keys.map(|key| (&key.task, &key.variation, &key.teacher)).collect::<BTreeSet<_>>().len()
}

/// The ratio of the time of an update to that of `situ`.
fn time_to_situ(row: &Row) -> Cell {
    let ratios = row.pairs.iter().filter_map(|(run, situ)| Some(update_seconds(run)? / update_seconds(situ)?));
    median(ratios.filter(|ratio| ratio.is_finite()), row.row.seed("time ratio"))
}

fn columns<'a>() -> Columns<'a, Row<'a>> {
    let columns = method_columns::<Row<'a>>(|row| row.row.key).count("cells", cells);
    uncounted(columns.count("runs", |row| row.row.of.len()))
        .column("reached", Shape::Rate, |row| share(row.counted.iter().map(|run| run.is_reached())))
        .column("after", Shape::Rate, |row| rate(row.counted.iter().filter_map(|run| run.after)))
        .column("demonstrations", Shape::Estimate(2), |row| {
            let of = row.counted.iter().map(|run| (demonstrations(run), !run.is_reached()));
            spent(of, row.row.seed("demonstrations"))
        })
        .column("demonstrations_to_situ", Shape::Estimate(2), |row| row.ratio(demonstrations, "ratio"))
        .wall("update_ms", Shape::Estimate(2), |row| {
            let times = row.counted.iter().filter_map(|run| Some(MILLISECONDS_PER_SECOND * update_seconds(run)?));
            median(times, row.row.seed("time"))
        })
        .wall("update_to_situ", Shape::Estimate(1), time_to_situ)
}

fn table(records: &Canonical) -> Table {
    let label = |(protocol, method, edit): &MethodKey<'_>| format!("methods/{protocol}/{method}/{edit}");
    let rows = compared(records, method_key, label, SITU, |run| run.key.method != SITU);
    Table::new(TITLE, columns(), &rows, rows.iter().map(|row| (row.row.key.0, row.row.of.len())))
}

fn demonstrations(run: &RunRecord) -> f64 {
    f64::from(run.effort.demonstrations)
}

/// The mean time of an update of a run; nothing of a run without one.
fn update_seconds(run: &RunRecord) -> Option<f64> {
    stats::mean(&run.corrections.iter().map(|correction| correction.update_seconds).collect::<Vec<_>>())
}
